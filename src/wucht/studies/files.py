"""File -> study: a study file or catalogue name, with values set from the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wucht.documents import Document, choice, flatten, no_nan, table
from wucht.errors import InputError, RunError
from wucht.machines.catalogue import described_machine, load_document
from wucht.machines.files import machine_from
from wucht.machines.machine import Machine
from wucht.studies.kinds import NOT_YET, STUDIES, Kind, Question


@dataclass(frozen=True)
class StudyFile:
    """A study file read: the machine, the kind of study and its question, and the whole input as written."""

    path: Path
    name: str
    machine: Machine
    kind: Kind
    question: Question
    document: Document


def read_study(name: str, settings: Mapping[str, Any] | None = None) -> StudyFile:
    """Read a study file or catalogue entry.

    settings: values by path; those that begin with ``study.`` belong to the table ``[study]``, all others to the machine.
    Raises ``InputError``: file, key, what was given, what is allowed.
    """
    document, path = load_document(name)
    own = flatten(settings or {})
    try:
        found = _read(document, path, name, own)
    except InputError as error:
        raise error.within(str(path), ": ") from None
    return StudyFile(path, name, *found)


def _read(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Machine, Kind, Question, Document]:
    mine = {k: v for k, v in settings.items() if not k.startswith("study.")}
    described = described_machine(document, path, name, mine)
    machine = machine_from(described)
    written = dict(table(document, "study", "study")) if "study" in document else {"kind": "run-up"}
    no_nan(written, "study")
    asked = _of_kind(written, settings.get("study.kind", written.get("kind")))
    for key, value in settings.items():
        if key.startswith("study."):
            _set_study(asked, key.removeprefix("study.").split("."), value)
    kind = STUDIES[choice(asked, "kind", "study", STUDIES, NOT_YET)]
    question = kind.question.read(asked, machine)
    try:
        question.check(machine)
    except RunError as error:
        raise InputError("machine", None, str(error)) from None
    return machine, kind, question, {"study": asked, "machine": described}


def _of_kind(written: Document, kind: Any) -> Document:
    """The table ``[study]``; of a file written for another kind only what this kind knows too."""
    if kind == written.get("kind") or not isinstance(kind, str) or kind not in STUDIES:
        return dict(written)
    known = {*STUDIES[kind].question.keys} - {"range", "along", "values", "rate", "points"}  # each means another thing in each
    return {k: v for k, v in written.items() if k in known}


def _set_study(asked: Document, keys: list[str], value: Any) -> None:
    if keys[0] in ("until", "turns", "settled"):
        # These three are one choice: setting one from the command line replaces what the file says.
        for other in ("until", "turns", "settled"):
            asked.pop(other, None)
    for key in keys[:-1]:
        inner = asked.setdefault(key, {})
        if not isinstance(inner, dict):
            inner = asked[key] = {"angle": inner}
        asked = inner
    asked[keys[-1]] = value
