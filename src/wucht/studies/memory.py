"""Completed units of work, stored in the output folder and read back: resuming is memoisation.

A unit is a named, deterministic part of a study's work: a leg, a run, a point, a tile. It is computed once for a question; when
the same question is repeated with the same folder, it is read back to the last bit.

The folder ``units`` has a file for all units completed since the preceding file, with their question, whose fingerprint begins
its name. A file has a unique name and is never changed: several processes add theirs to one folder, of any questions.

For a repeated question a folder has its result, its units of work, or those of another question.
"""

from __future__ import annotations

import json
import shutil
import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from wucht.errors import InputError, RunError, WuchtError
from wucht.results import archive
from wucht.results.output_folder import PARTIAL, load_result, remove_partial
from wucht.results.store import RESULT, replace_file, return_free_memory, to_json
from wucht.studies.study import Study
from wucht.studies.subjects import Description

if TYPE_CHECKING:
    import xarray as xr

T = TypeVar("T")
FOLDER = "units"
_HASH = 16  # hexadecimal digits of a question's fingerprint
_FINGERPRINT = "[0-9a-f]" * _HASH
_EARLIER = f"{_FINGERPRINT}/zarr.json"  # as version 0.2.0 stored the units of a question
_QUESTION = "question"  # in a file, beside the units
_EVERY_S = 2.0  # between two writings: a kill loses only the units computed since then, and the current one
_MOST = 8_000_000  # bytes waiting to be written
_TRIES = 3  # attempts to write, if another process has removed the folder meanwhile
_MOST_DIFFERENCES = 3


class UnitMemory:
    """Units of work of one question. folder: where they are stored; None: nowhere."""

    def __init__(self, folder: Path | None = None, question: Mapping[str, Any] | None = None) -> None:
        self._folder, self._question = folder, dict(question or {})
        self._fingerprint = sha256(json.dumps(self._question, sort_keys=True).encode()).hexdigest()[:_HASH]
        self._stored_units: dict[str, Any] = {}
        self._new: dict[str, Any] = {}
        self._write_time, self._size = clock.perf_counter(), 0

    @classmethod
    def start(cls, folder: Path, question: Mapping[str, Any]) -> UnitMemory:
        """Start an empty memory for a question: units in the folder, of this or another question, are removed.

        Other files in a folder of that name stay: it may be the user's own. Raises ``InputError`` if a file is in its place.
        """
        units = folder / FOLDER
        if units.is_symlink() or (units.exists() and not units.is_dir()):  # neither is a link followed, nor a pipe waited for
            raise InputError("-o", str(folder), f"a file is in the place of the folder {FOLDER}", code="file")
        for description in _matching_paths(folder, _EARLIER):
            shutil.rmtree(description.parent, ignore_errors=True)
        _remove_units(folder, _FINGERPRINT)
        return cls(folder, question)

    @classmethod
    def resume(cls, folder: Path, question: Mapping[str, Any]) -> UnitMemory:
        """Read the units of a question from the folder. Unreadable ones are left out, and computed again."""
        memory = cls(folder, question)
        for file in _matching_paths(folder, f"{memory._fingerprint}-*.npz"):
            with suppress(WuchtError):
                memory._stored_units |= archive.read_value(file, FOLDER)
        return memory

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """The result of a unit: read back, or computed now and stored."""
        if self.knows(name):
            stored_outcome: T = self._stored_units.pop(name)
            return stored_outcome
        outcome = compute()
        self.keep(name, outcome)
        return outcome

    def knows(self, name: str) -> bool:
        """True if a unit can be read back."""
        return name in self._stored_units

    def keep(self, name: str, outcome: Any) -> None:
        """Store the result of a computed unit."""
        if self._folder is not None:
            self._new[name] = outcome
            self._size += archive.size(outcome)
            if clock.perf_counter() - self._write_time > _EVERY_S or self._size > _MOST:
                self.flush()

    def flush(self) -> None:
        """Write the new units. Raises ``RunError`` if that is not possible."""
        self._write_time = clock.perf_counter()
        if self._folder is None or not self._new:
            return
        for tries_left in reversed(range(_TRIES)):
            try:
                replace_file(self._folder / FOLDER / f"{self._fingerprint}-{uuid4().hex}.npz", self._write)
                break
            except RunError:
                if not tries_left:
                    raise
        self._new, self._size = {}, 0
        return_free_memory()

    def _write(self, file: Path) -> None:
        file.parent.mkdir(parents=True, exist_ok=True)
        archive.write_values(file, {_QUESTION: self._question, FOLDER: self._new})

    @contextmanager
    def kept_on_error(self) -> Iterator[None]:
        """Write the new units where the block fails; Ctrl-C gets a sentence on what is stored."""
        try:
            yield
        except BaseException as error:
            with suppress(WuchtError):  # the error of the study is more informative
                self.flush()
            if self._folder is not None and isinstance(error, KeyboardInterrupt):
                raise KeyboardInterrupt(interruption(self._folder)) from None
            raise

    def forget(self) -> None:
        """Remove the units of this question."""
        if self._folder is not None:
            _remove_units(self._folder, self._fingerprint)


def stored_questions(folder: Path) -> list[dict[str, Any]]:
    """The questions whose units are stored in a folder."""
    questions: dict[str, dict[str, Any]] = {}
    for file in _matching_paths(folder, f"{_FINGERPRINT}-*.npz"):
        fingerprint = file.name[:_HASH]
        if fingerprint not in questions:
            with suppress(WuchtError):  # a damaged file has no question
                questions[fingerprint] = archive.read_value(file, _QUESTION)
    return list(questions.values())


def _matching_paths(folder: Path, pattern: str) -> list[Path]:
    """Paths in the folder of units that match a pattern; none if another process has just removed it."""
    try:
        return sorted((folder / FOLDER).glob(pattern))
    except FileNotFoundError:
        return []


def _remove_units(folder: Path, fingerprint: str) -> None:
    """Remove units, with what kills have left beside them; their folder too, unless it has others.

    Raises ``InputError`` if that is not possible.
    """
    try:
        for pattern in (f"{fingerprint}-*.npz", f".{fingerprint}-*.part"):
            for file in _matching_paths(folder, pattern):
                file.unlink(missing_ok=True)
    except OSError as error:
        raise InputError("-o", str(folder), f"nothing can be written there: {error.strerror}") from None
    with suppress(OSError):  # it has files of others, or is not there
        (folder / FOLDER).rmdir()


def question_of(spec: Study, subject: Any, description: Description) -> dict[str, Any]:
    """The question and its described subject as JSON: two that are equal, except for titles, have the same answer."""
    question: dict[str, Any] = json.loads(to_json({"study": spec.table_for(subject), "machine": description.facts}))
    return question


def earlier_result(folder: Path, spec: Study, question: Mapping[str, Any]) -> tuple[xr.Dataset | None, list[str]]:
    """The complete result of the same question, if the folder has it; and a note on a result with another horizon.

    There is none where the folder has a run of this question that is not complete: that is continued. Raises ``InputError`` if
    what the folder has belongs to another question, was changed, or is the unfinished run of an earlier version.
    """
    questions, result = stored_questions(folder), _stored_result(folder / RESULT)
    if not questions:
        if _matching_paths(folder, _EARLIER) or (result is not None and not result.attrs["finished"]):
            explanation = (
                "was begun by an earlier version of wucht, which alone can continue it; without --resume it begins anew"
            )
            raise InputError("--resume", None, f"the unfinished run in {folder} {explanation}", code="earlier-version")
        if (part := _stored_result(folder / PARTIAL)) is not None:
            questions = [without_titles(part.wucht.question)]
    if question in questions:
        return None, []
    if result is not None:
        answered_question = without_titles(result.wucht.question)
        if answered_question == question:
            return result, []
        questions = questions or [answered_question]
    if not questions:
        return None, []
    stored_question = questions[0]
    before, now = stored_question["study"].get("kind"), spec.kind
    if before != now:
        raise InputError(
            "--resume", None, f"the result in {folder} answers study.kind = {before!r}, not {now!r}", code="other-study"
        )
    differing = differences(stored_question, question)
    if all(key.removeprefix("study.").split(".")[0] in spec.horizon for key in differing):
        return None, [f"{', '.join(differing)}: different from that of the result in the folder; the study was restarted"]
    details = "; ".join(list(differing.values())[:_MOST_DIFFERENCES])
    more = f" and {len(differing) - _MOST_DIFFERENCES} more" if len(differing) > _MOST_DIFFERENCES else ""
    raise InputError(
        "--resume", None, f"the result in {folder} answers another question: {details}{more}", code="other-question"
    )


def begin_units(folder: Path, question: Mapping[str, Any], resume: bool, announce: Callable[[str], object]) -> UnitMemory:
    """The units of a question in a folder; without ``resume``, or where there are none, it is computed from the beginning."""
    complete = f"; {folder / RESULT}, which is complete, stays until it ends" if (folder / RESULT).is_file() else ""
    if resume and question in stored_questions(folder):
        announce(f"the unfinished run in {folder} is continued{complete}")
        return UnitMemory.resume(folder, question)
    if resume:
        announce(f"there is no unfinished run in {folder}: the study begins anew{complete}")
    memory = UnitMemory.start(folder, question)
    remove_partial(folder)
    return memory


def interruption(folder: Path, failure: str = "") -> str:
    """The sentence on a run that was interrupted, or has failed: what it leaves in its folder, and what was there before."""
    earlier = f"; the earlier result, {folder / RESULT}, is unchanged" if (folder / RESULT).is_file() else ""
    if failure:
        return f"{failure}. What was computed so far is in {folder / PARTIAL}{earlier}"
    part = f"what was computed so far is in {folder / PARTIAL}" if (folder / PARTIAL).is_file() else "there is no result yet"
    steps = "--resume continues from there" if stored_questions(folder) else "nothing to continue"
    return f"interrupted: {part}, and {steps}{earlier}"


def _stored_result(file: Path) -> xr.Dataset | None:
    """The result in a file, None if there is none. Raises ``InputError`` if it was changed."""
    try:
        return load_result(file) if file.exists() else None
    except InputError as error:
        raise error.with_prefix("--resume", ": ") from None


def without_titles(question: Any) -> Any:
    """A question without the titles of its subjects, on which no answer depends."""
    if isinstance(question, Mapping):
        return {key: without_titles(value) for key, value in question.items() if key != "title"}
    return [without_titles(item) for item in question] if isinstance(question, list) else question


def differences(before: Any, now: Any, path: str = "") -> dict[str, str]:
    """Keys in which two questions differ, with a description each. ``contents`` is the hash of a table's file."""
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
    """The file named by a table or by a table in it."""
    file_names = [t.get("file") for t in (table, *table.values()) if isinstance(t, Mapping)]
    return next((str(n) for n in file_names if n is not None), None)


def _brief(value: Any) -> str:
    text = "not given" if value is None else repr(value)
    return text if len(text) <= 40 else f"{text[:36]} ..."
