"""Units of work that are done, kept in the output folder and read back: resuming is memoisation.

A unit is a named, deterministic part of a study's work: a leg, a run, a point, a tile. It is computed once for a question; when
the same question is asked again of the same folder, it is read back to the last bit.
"""

from __future__ import annotations

import json
import shutil
import time as clock
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from wucht.errors import InputError, WuchtError
from wucht.results import archive
from wucht.results.store import replacing, to_json

T = TypeVar("T")
FOLDER = "units"
_QUESTION = "question.json"
_EVERY_S = 2.0  # between two writings: a kill loses no more than what was computed since, and the unit that was under way


class Memory:
    """The units of one question. folder: where they are kept; None: nowhere."""

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = folder
        self._known: dict[str, Any] = {}
        self._new: dict[str, Any] = {}
        self._written, self._files = clock.perf_counter(), 0

    @classmethod
    def begun(cls, folder: Path, question: Mapping[str, Any]) -> Memory:
        """An empty memory for a question: what the folder kept of another one is removed."""
        forget(folder)
        memory = cls(folder / FOLDER)
        (folder / FOLDER).mkdir(parents=True)
        replacing(folder / FOLDER / _QUESTION, lambda beside: beside.write_text(to_json(question), encoding="utf-8"))
        return memory

    @classmethod
    def resumed(cls, folder: Path) -> Memory:
        """The memory of a folder. A file that cannot be read is left out: its units are computed again."""
        memory = cls(folder / FOLDER)
        for file in sorted((folder / FOLDER).glob("*.npz")):
            memory._files = max(memory._files, int(file.stem))
            try:
                memory._known |= archive.read(file)
            except WuchtError:
                file.unlink()
        return memory

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """The result of a unit: read back, or computed now and kept."""
        if name in self._known:
            known: T = self._known.pop(name)
            return known
        outcome = compute()
        if self._folder is not None:
            self._new[name] = outcome
            if clock.perf_counter() - self._written > _EVERY_S:
                self.flush()
        return outcome

    def flush(self) -> None:
        """Write what is new. Raises ``RunError`` where that cannot be done."""
        self._written = clock.perf_counter()
        if self._folder is None or not self._new:
            return
        self._files += 1
        replacing(self._folder / f"{self._files:06}.npz", lambda beside: archive.write(beside, self._new))
        self._new = {}


def question_of(folder: Path) -> dict[str, Any] | None:
    """The question whose units a folder keeps, None if there is none."""
    try:
        question: dict[str, Any] = json.loads((folder / FOLDER / _QUESTION).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return question


def forget(folder: Path) -> None:
    """Remove the units of a folder. Raises ``InputError`` where that cannot be done."""
    try:
        shutil.rmtree(folder / FOLDER)
    except FileNotFoundError:
        return
    except OSError as error:
        raise InputError("-o", str(folder), f"nothing can be written there: {error.strerror}") from None
