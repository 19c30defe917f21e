"""Units of work that are done, kept in the output folder and read back: resuming is memoisation.

A unit is a named, deterministic part of a study's work: a leg, a run, a point, a tile. It is computed once for a question; when
the same question is asked again of the same folder, it is read back to the last bit.

The folder ``units`` has a Zarr store for each question, named by its hash, with a group for all that was done since the group
before. A group has a name that no other has, and is never changed: a process that is killed leaves at most one that cannot be
read, and several processes at one question add to one store what all of them would find.

What a folder has of a question that is asked again is its result, its units of work, or those of another question.
"""

from __future__ import annotations

import json
import shutil
import time as clock
from collections.abc import Callable, Mapping
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from wucht.errors import InputError, RunError, WuchtError
from wucht.results import archive
from wucht.results.output_folder import load
from wucht.results.store import return_free_memory, to_json
from wucht.studies.spec import Spec
from wucht.studies.subjects import subject_of

if TYPE_CHECKING:
    import xarray as xr

T = TypeVar("T")
FOLDER = "units"
_QUESTION = "question"  # attribute of a store
_EVERY_S = 2.0  # between two writings: a kill loses no more than what was computed since, and the unit that was under way
_LARGE, _MOST = 8_000_000, 64_000_000  # bytes that wait to be written
_TRIES = 3  # of writing where another process has removed the store meanwhile
_MOST_DIFFERENCES = 3


class Memory:
    """The units of one question. folder: where they are kept; None: nowhere."""

    def __init__(self, folder: Path | None = None, question: Mapping[str, Any] | None = None) -> None:
        self._question = dict(question or {})
        self._store = None if folder is None else _store(folder, self._question)
        self._known: dict[str, Any] = {}
        self._new: dict[str, Any] = {}
        self._written, self._size = clock.perf_counter(), 0

    @classmethod
    def begun(cls, folder: Path, question: Mapping[str, Any]) -> Memory:
        """An empty memory for a question: what the folder kept, of this one or another, is removed."""
        for left in folder.glob(f".{FOLDER}-*"):
            shutil.rmtree(left, ignore_errors=True)
        _remove(folder / FOLDER, folder)
        return cls(folder, question)

    @classmethod
    def resumed(cls, folder: Path, question: Mapping[str, Any]) -> Memory:
        """What the folder has of a question. What cannot be read is left out, and computed again."""
        memory = cls(folder, question)
        for group in _found(_store(folder, question), "*/"):
            with suppress(WuchtError):
                memory._known |= archive.read(group)
        return memory

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """The result of a unit: read back, or computed now and kept."""
        if self.knows(name):
            known: T = self._known.pop(name)
            return known
        outcome = compute()
        self.keep(name, outcome)
        return outcome

    def knows(self, name: str) -> bool:
        """Whether a unit can be read back."""
        return name in self._known

    def keep(self, name: str, outcome: Any) -> None:
        """Keep the result of a unit that was computed."""
        if self._store is not None:
            self._new[name] = outcome
            self._size += archive.size(outcome)
            if clock.perf_counter() - self._written > _EVERY_S or self._size > _MOST:
                self.flush()

    @property
    def is_large(self) -> bool:
        """Whether what is not written yet takes so much memory that it should be, before more is needed."""
        return self._size > _LARGE

    def flush(self) -> None:
        """Write what is new. Raises ``RunError`` where that cannot be done."""
        self._written = clock.perf_counter()
        if self._store is None or not self._new:
            return
        for tried in range(1, _TRIES + 1):
            try:
                self._write(self._store)
                break
            except OSError as error:
                if isinstance(error, FileNotFoundError) and tried < _TRIES:
                    continue
                raise RunError(f"{self._store} cannot be written: {error.strerror or error}", code="not-written") from None
        self._new, self._size = {}, 0

    def _write(self, store: Path) -> None:
        """A group with what is new; the store too, if it is not there yet or no more."""
        import zarr
        from zarr.errors import ContainsGroupError

        if not (store / "zarr.json").is_file():
            with suppress(ContainsGroupError):  # another process was faster, with the same
                zarr.create_group(store, attributes={_QUESTION: self._question})
        archive.write(store / uuid4().hex, self._new)
        return_free_memory()

    def forget(self) -> None:
        """Remove the units of this question."""
        if self._store is not None:
            units = self._store.parent
            _remove(self._store, units.parent)
            with suppress(OSError):  # others' units are there, or none
                units.rmdir()


def questions_of(folder: Path) -> list[dict[str, Any]]:
    """The questions whose units a folder keeps."""
    import zarr

    kept: list[dict[str, Any]] = []
    for store in _found(folder / FOLDER, "*/zarr.json"):
        with suppress(Exception):  # whatever a damaged file makes the reader stumble over: then there is no question
            kept.append(dict(zarr.open_group(store.parent, mode="r").attrs[_QUESTION]))
    return kept


def _store(folder: Path, question: Mapping[str, Any]) -> Path:
    return folder / FOLDER / sha256(json.dumps(question, sort_keys=True).encode()).hexdigest()[:16]


def _found(folder: Path, pattern: str) -> list[Path]:
    """What a folder has; nothing where another process has just removed it."""
    try:
        return sorted(folder.glob(pattern))
    except FileNotFoundError:
        return []


def _remove(path: Path, beside: Path) -> None:
    """Remove a folder, at once for all who look there. Raises ``InputError`` where that cannot be done."""
    moved = beside / f".{FOLDER}-{uuid4().hex}"
    try:
        path.rename(moved)
    except FileNotFoundError:
        return
    except OSError as error:
        raise InputError("-o", str(beside), f"nothing can be written there: {error.strerror}") from None
    shutil.rmtree(moved, ignore_errors=True)


def question_of(spec: Spec, subject: Any) -> dict[str, Any]:
    """What is asked of what, as JSON: two questions that are equal, but for titles, have the same answer.

    Raises ``InputError`` where the question cannot be asked of the subject.
    """
    facts = subject_of(spec).describe(subject).facts
    question: dict[str, Any] = json.loads(to_json({"study": spec.asked_of(subject), "machine": facts}))
    return question


def earlier(file: Path, spec: Spec, question: Mapping[str, Any]) -> tuple[xr.Dataset | None, list[str]]:
    """The finished result of the same question, if this file has it; and a note on one of another horizon.

    Raises ``InputError`` where the file, or the units of work beside it, are those of another question, and where the file was
    changed.
    """
    try:
        folder, result = file.parent, load(file) if file.exists() else None
    except InputError as error:
        raise error.within("--resume", ": ") from None
    answered = None if result is None else untitled(result.wucht.question)
    if result is not None and result.attrs["finished"] and answered == question:
        return result, []
    kept = questions_of(folder) or ([] if answered is None else [answered])
    if not kept or question in kept:
        return None, []
    asked = kept[0]
    before, now = asked["study"].get("kind"), spec.kind
    if before != now:
        raise InputError(
            "--resume", None, f"the result in {folder} answers study.kind = {before!r}, not {now!r}", code="other-study"
        )
    differing = differences(asked, question)
    if all(key.removeprefix("study.").split(".")[0] in spec.horizon for key in differing):
        return None, [f"{', '.join(differing)}: another than that of the result in the folder; it was begun anew"]
    shown = "; ".join(list(differing.values())[:_MOST_DIFFERENCES])
    more = f" and {len(differing) - _MOST_DIFFERENCES} more" if len(differing) > _MOST_DIFFERENCES else ""
    raise InputError("--resume", None, f"the result in {folder} answers another question: {shown}{more}", code="other-question")


def untitled(question: Any) -> Any:
    """A question without the titles of its subjects, which no answer depends on."""
    if isinstance(question, Mapping):
        return {key: untitled(value) for key, value in question.items() if key != "title"}
    return [untitled(each) for each in question] if isinstance(question, list) else question


def differences(before: Any, now: Any, path: str = "") -> dict[str, str]:
    """In which keys two questions differ, and how. ``contents`` is the hash of a table's file."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        differing: dict[str, str] = {}
        for key in [*before, *(k for k in now if k not in before)]:
            if key == "contents" and before.get(key) != now.get(key):
                if _file_of(before) == _file_of(now):
                    differing[f"{path}file"] = f"the record {_file_of(now)} has changed"
                continue
            inner = path if key in ("machine", "parameters") else f"{path}{key}."
            differing |= differences(before.get(key), now.get(key), inner)
        return differing
    name = path.removesuffix(".")
    if name == "structure" and before != now:
        return {name: "the parts, curves, schedules or equations of the subject have changed"}
    return {} if before == now else {name: f"{name} was {_brief(before)}, now {_brief(now)}"}


def _file_of(table: Mapping[str, Any]) -> str | None:
    """The file that a table names, itself or a table in it."""
    named = [t.get("file") for t in (table, *table.values()) if isinstance(t, Mapping)]
    return next((str(n) for n in named if n is not None), None)


def _brief(value: Any) -> str:
    text = "not given" if value is None else repr(value)
    return text if len(text) <= 40 else f"{text[:36]} ..."
