"""Subjects of studies: how one is read from a study file, and how a result describes it.

Two subjects are distinguished by a hash of everything on which a result depends, the same in every process. Numbers count to
the last bit, also within equations, where printing rounds them, and in piecewise functions, which are printed by name alone.
Titles and names of files do not count; the contents of files do.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

import sympy as sp
from sympy.printing.str import StrPrinter

from wucht.analysis.plausibility import plausibility_notes
from wucht.errors import InputError
from wucht.files.catalogue import ABOUT, load_document, machine_of
from wucht.files.catalogue import equations_of as document_equations
from wucht.files.documents import Document
from wucht.files.user_system import UserSystem
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Drive
from wucht.piecewise import Pieces
from wucht.schema import refuse_unknown
from wucht.studies.study import Study
from wucht.system import System

_SILENT = frozenset({"title", "warnings", "notes", "parameters", "file"})  # parameters are listed separately


class _Exactly(StrPrinter):  # type: ignore[misc]
    """Printer of SymPy expressions with all digits, so that they could be restored."""

    printmethod = "_exactly"  # not the methods for readable output

    def _print_Float(self, number: sp.Float) -> str:
        return str(number._mpf_)

    def _print_Pieces(self, pieces: Pieces) -> str:
        return _text((pieces.breakpoints, pieces.coefficients))


def _fingerprint_of_machine(machine: Machine) -> str:
    """Fingerprint of a machine without its parameter values: of its parts and their energies, which give the equations."""
    return _fingerprint({f.name: getattr(machine, f.name) for f in fields(machine) if f.name not in _SILENT})


@lru_cache(maxsize=64)
def _fingerprint_of_system(system: System) -> str:
    """Fingerprint of equations without the values of their parameters."""
    return _fingerprint(system)


def _fingerprint(value: Any) -> str:
    return hashlib.sha256(_text(value).encode()).hexdigest()[:16]


@lru_cache(maxsize=4096)  # the same energies belong to each machine of a comparison, and to each question about one
def _expression_text(expression: sp.Basic) -> str:
    return str(_Exactly().doprint(expression))


def _text(value: Any) -> str:
    """A value as a string that is the same for equal values only; whole numbers equal those of floating point."""
    match value:
        case None | bool() | str():
            return repr(value)
        case int() | float():
            return float(value).hex()
        case sp.Basic():
            return _expression_text(value)
        case sp.MatrixBase():
            return str(_Exactly().doprint(value))
        case Mapping():
            text = ",".join(f"{_text(key)}:{_text(item)}" for key, item in value.items())
        case set() | frozenset():
            text = ",".join(sorted(map(_text, value)))
        case _ if is_dataclass(value):
            text = _text({f.name: getattr(value, f.name) for f in fields(value) if f.name not in _SILENT})
        case Iterable():
            text = ",".join(map(_text, value))
        case _:
            raise TypeError(f"no fingerprint is known for the type {type(value).__qualname__}")
    return f"{type(value).__qualname__}({text})"


@dataclass(frozen=True)
class Description:
    """Description of a subject in a result. facts: as JSON; two subjects with the same facts are the same to a study.

    notes: origins of derived parameters. parts: of a machine, see ``_parts_of``; they describe ``facts`` and add none.
    """

    title: str
    dimensionless: bool
    facts: Mapping[str, Any]
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    parts: tuple[Mapping[str, Any], ...] = ()


class SubjectKind(Protocol):
    """A kind of subject."""

    def from_document(self, document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Any, Document]:
        """Read the subject from a study file, and its tables with all settings. Raises ``InputError``."""
        ...

    def describe(self, subject: Any) -> Description:
        """Describe a subject for a result. Raises ``InputError`` if it is no subject of this kind."""
        ...


class MachineSubject:
    """The machine of the table ``[machine]``."""

    def from_document(self, document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Machine, Document]:
        """See ``SubjectKind``."""
        if "system" in document and "machine" not in document:
            raise InputError("system", None, "the subject of this study must be a machine: give a table [machine]")
        refuse_unknown(document, (*ABOUT, "machine"), "")
        machine, tables = machine_of(document, path, name, settings)
        return machine, {"machine": tables}

    def describe(self, subject: Any) -> Description:
        """See ``SubjectKind``."""
        if not isinstance(subject, Machine):
            raise InputError("machine", subject, "the subject of this study must be a machine")
        facts = {
            "title": subject.title,
            "structure": _fingerprint_of_machine(subject),
            "parameters": subject.values,
            "bodies": [[b.name, b.kind, b.about] for b in subject.bodies],
        }
        dimensionless, parts = not subject.units.time, _parts_of(subject)
        notes = (*subject.notes, *plausibility_notes(subject))
        return Description(subject.title, dimensionless, facts, subject.warnings, notes, parts)


def _parts_of(machine: Machine) -> tuple[Mapping[str, Any], ...]:
    """The parts of a machine in words, for its readers, in the order of its energies.

    Each with ``path``, ``kind``, the body it turns about or acts ``on``, and for each of its ``parameters`` its name in words,
    its unit, and whether it changes over time, so that its value is that at the start. A carrier has its ``directions``, a
    drive its ``sense``, and what of it is estimated as ``estimates``, each with its range, in words. Parameters of tracks
    belong to parts of their paths.
    """
    owners: dict[str, dict[str, Any]] = {}
    for part in machine.parts:
        on = getattr(part, "about", None) or getattr(part, "on", None) or ""
        owners[part.path] = {"path": part.path, "kind": part.kind, "on": on, "parameters": {}}
        if isinstance(part, Drive):
            owners[part.path] |= {"sense": getattr(part, "sense", 1)}
            owners[part.path] |= {"estimates": list(part.estimates())} if part.estimates() else {}
    carrier = owners.get("carrier") or owners.get("")
    if carrier is not None:
        carrier["directions"] = list(machine.labels)
    over_time = {schedule.parameter for schedule in machine.schedules}
    for path, parameter in machine.parameters.items():
        owner = max((name for name in owners if not name or path.startswith(f"{name}.")), key=len, default=None)
        if owner is None:
            owner = path.rpartition(".")[0]
            owners[owner] = {"path": owner, "kind": "track", "on": "", "parameters": {}}
        facts = {"what": parameter.long_name, "unit": parameter.unit}
        owners[owner]["parameters"][path] = facts | ({"over_time": True} if path in over_time else {})
    return tuple(owners.values())


class MachineOrSystemSubject:
    """The machine of the table ``[machine]``, or the user equations of the table ``[system]``."""

    def from_document(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[Machine | UserSystem, Document]:
        """See ``SubjectKind``."""
        if "system" not in document:
            if "machine" not in document:
                raise InputError("machine", None, "give a table [machine], or the equations of a table [system]")
            return MACHINE.from_document(document, path, name, settings)
        if "machine" in document:
            raise InputError("system", None, "a study has one subject: give either [machine] or [system]")
        refuse_unknown(document, (*ABOUT, "system"), "")
        equations, tables = document_equations(document, path, name, settings)
        return equations, {"system": tables}

    def describe(self, subject: Any) -> Description:
        """See ``SubjectKind``."""
        if isinstance(subject, Machine):
            return MACHINE.describe(subject)
        if not isinstance(subject, UserSystem):
            raise InputError("machine", subject, "the subject of this study must be a machine or a wucht.UserSystem")
        facts = {
            "title": subject.title,
            "structure": _fingerprint_of_system(subject.system),
            "parameters": dict(subject.values),
        }
        return Description(subject.title, True, facts)


MACHINE = MachineSubject()
MACHINE_OR_SYSTEM = MachineOrSystemSubject()


def subject_of(spec: Study | type[Study]) -> SubjectKind:
    """The kind of subject that a spec names."""
    module, _, name = spec.subject.partition(":")
    subject: SubjectKind = getattr(import_module(module), name)
    return subject


def is_name(spec: Study, subject: Any) -> bool:
    """True for the path or catalogue name of a file that has the subject of a study.

    False for subjects themselves; a study of one's own may have a path as its subject. Raises ``InputError`` where the question
    names its files itself.
    """
    if not isinstance(subject, str | Path):
        return False
    try:
        subject_of(spec).describe(subject)
    except InputError as error:
        if error.location.startswith("study."):
            raise
        return True
    return False


def named_subject(spec: Study, name: str | Path, settings: Mapping[str, Any] | None = None) -> Any:
    """The subject of a study in a file, by its path or catalogue name; the question in the file is not read.

    settings: values by path. Raises ``InputError``: file, key, given value and requirement.
    """
    document, path = load_document(str(name))
    try:
        return subject_of(spec).from_document(document | {"study": spec.to_table()}, path, str(name), settings or {})[0]
    except InputError as error:
        raise error.with_file(path) from None
