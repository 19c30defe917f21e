"""What studies are asked of: how a subject is read from a study file, and how a result describes it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from wucht.checking import refuse_unknown
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.catalogue import ABOUT, described_machine
from wucht.files.documents import Document
from wucht.machines.machine import Machine
from wucht.studies.spec import Spec
from wucht.system import System


@dataclass(frozen=True)
class Description:
    """What a result says of its subject. facts: as JSON; two subjects with the same facts are the same to a study."""

    title: str
    dimensionless: bool
    facts: Mapping[str, Any]
    warnings: tuple[str, ...] = ()


class Subject(Protocol):
    """A kind of subject."""

    def read(self, document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Any, Document]:
        """From a study file: the subject, and its table with all settings made. Raises ``InputError``."""
        ...

    def describe(self, subject: Any) -> Description:
        """For a result. Raises ``InputError`` where it is no subject of this kind."""
        ...


class OfMachine:
    """The machine of the table ``[machine]``."""

    def read(self, document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Machine, Document]:
        """See ``Subject``."""
        refuse_unknown(document, (*ABOUT, "machine"), "")
        described = described_machine(document, path, name, settings)
        return machine_from(described), {"machine": described}

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if not isinstance(subject, Machine):
            raise InputError("machine", subject, "this study is asked of a machine")
        facts = {
            "title": subject.title,
            "structure": _fingerprint(subject.system),
            "parameters": subject.values,
            "bodies": [[b.name, b.kind, b.about] for b in subject.bodies],
        }
        return Description(subject.title, not subject.units.time, facts, subject.warnings)


@lru_cache(maxsize=64)
def _fingerprint(system: System) -> str:
    """Of a machine's equations, the same in every process."""
    return hashlib.sha256(repr((system.states, system.definitions, system.derivatives)).encode()).hexdigest()[:16]


MACHINE = OfMachine()


def subject_of(spec: Spec | type[Spec]) -> Subject:
    """The kind of subject that a spec names."""
    module, _, name = spec.subject.partition(":")
    subject: Subject = getattr(import_module(module), name)
    return subject
