"""What studies are asked of: how a subject is read from a study file, and how a result describes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from wucht.errors import InputError
from wucht.files.catalogue import ABOUT, machine_of
from wucht.files.catalogue import equations_of as own_equations_of
from wucht.files.documents import Document
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.schema import refuse_unknown
from wucht.studies.fingerprints import fingerprint_of_machine, fingerprint_of_system
from wucht.studies.spec import Spec


@dataclass(frozen=True)
class Description:
    """What a result says of its subject. facts: as JSON; two subjects with the same facts are the same to a study.

    notes: what the parameters were made of, where they are not as given.
    """

    title: str
    dimensionless: bool
    facts: Mapping[str, Any]
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


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
        if "system" in document and "machine" not in document:
            raise InputError("system", None, "this study is asked of a machine: needed is a table [machine]")
        refuse_unknown(document, (*ABOUT, "machine"), "")
        machine, described = machine_of(document, path, name, settings)
        return machine, {"machine": described}

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if not isinstance(subject, Machine):
            raise InputError("machine", subject, "this study is asked of a machine")
        facts = {
            "title": subject.title,
            "structure": fingerprint_of_machine(subject),
            "parameters": subject.values,
            "bodies": [[b.name, b.kind, b.about] for b in subject.bodies],
        }
        return Description(subject.title, not subject.units.time, facts, subject.warnings, subject.notes)


class OfMachineOrSystem:
    """The machine of the table ``[machine]``, or the user's own equations of the table ``[system]``."""

    def read(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[Machine | OwnEquations, Document]:
        """See ``Subject``."""
        if "system" not in document:
            if "machine" not in document:
                raise InputError("machine", None, "needed is a table [machine], or the equations of a table [system]")
            return MACHINE.read(document, path, name, settings)
        if "machine" in document:
            raise InputError("system", None, "a study is asked of one thing: give either [machine] or [system]")
        refuse_unknown(document, (*ABOUT, "system"), "")
        equations, described = own_equations_of(document, path, name, settings)
        return equations, {"system": described}

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if isinstance(subject, Machine):
            return MACHINE.describe(subject)
        if not isinstance(subject, OwnEquations):
            raise InputError("machine", subject, "this study is asked of a machine, or of wucht.OwnEquations")
        facts = {"title": subject.title, "structure": fingerprint_of_system(subject.system), "parameters": dict(subject.values)}
        return Description(subject.title, True, facts)


def equations_of(subject: Machine | OwnEquations) -> OwnEquations:
    """The System of a study's subject with values of its parameters: of a machine, its full equations of motion."""
    return subject if isinstance(subject, OwnEquations) else OwnEquations(subject.system, _own_values(subject), subject.title)


def _own_values(machine: Machine) -> dict[str, float]:
    return {name: machine.values[name] for name in machine.system.parameter_names}


MACHINE = OfMachine()
MACHINE_OR_SYSTEM = OfMachineOrSystem()


def subject_of(spec: Spec | type[Spec]) -> Subject:
    """The kind of subject that a spec names."""
    module, _, name = spec.subject.partition(":")
    subject: Subject = getattr(import_module(module), name)
    return subject
