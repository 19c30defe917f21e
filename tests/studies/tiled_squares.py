"""A study with tiles, each a moment's work, that leave a mark in a folder when they begin and when they are done.

A tile does not end while the folder has a file ``hold <number>``.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr

from wucht import InputError
from wucht.dynamics.work import Work
from wucht.extending import Answer, Study
from wucht.schema import si
from wucht.studies.cluster import TaskReport
from wucht.studies.subjects import Description


class Marked:
    """A subject that is no machine: the folder of the marks."""

    def describe(self, subject: Any) -> Description:
        return Description("marks", True, {})


MARKED = Marked()


@dataclass(frozen=True)
class Square:
    number: int
    noise: np.ndarray


def mark(folder: Path, what: str, number: int) -> None:
    (folder / f"{what} {number} {os.getpid()} {time.monotonic_ns()}").touch()


def marks(folder: Path, what: str) -> list[tuple[int, int]]:
    """The numbers of the tiles with a mark, and the processes that made it, in the order in which they did."""
    words = [p.name.split()[1:] for p in folder.glob(f"{what} *")]
    return [(int(number), int(process)) for number, process, _ in sorted(words, key=lambda w: int(w[2]))]


def square(folder: Path, lasts: float, number: int, told: TaskReport) -> Square:
    mark(folder, "begun", number)
    until = time.monotonic() + lasts
    if lasts < 0:
        raise InputError("study.lasts", lasts, "must be a time")
    try:
        while (left := until - time.monotonic()) > 0 or (folder / f"hold {number}").exists():
            time.sleep(min(0.02, max(left, 0.01)))
            told(1 - max(left, 0.0) / max(lasts, 1e-9))
    except KeyboardInterrupt:
        mark(folder, "given-up", number)
        raise
    mark(folder, "done", number)
    return Square(number, np.random.default_rng(number).normal(size=50) ** 2)


class TiledSquares(Study):
    """Squares of numbers, a tile each."""

    kind: ClassVar[str] = ""
    subject: ClassVar[str] = f"{__name__}:MARKED"
    tiled: ClassVar[bool] = True

    count: float = si("", "count", default=10, gt=0)
    lasts: float = si("", "seconds a tile takes", default=0.1)

    def prepare(self, subject: Path) -> Path:
        return subject

    def solve(self, subject: Path, folder: Path, work: Work) -> Iterator[Answer]:
        found: dict[str, Square] = {}
        yield Answer(fill=partial(state_squares, ()))
        tasks = {f"square {k}": partial(square, folder, self.lasts, k) for k in range(int(self.count))}
        for name, one in work.part("squares", 0.0, 0.9).units(tasks, "squares"):
            found[name] = one
            yield Answer(fill=partial(state_squares, tuple(found[n] for n in tasks if n in found)))

    def draw(self, result: xr.Dataset) -> Any:
        raise NotImplementedError


def state_squares(squares: tuple[Square, ...], a: Answer) -> None:
    a.curve("square", np.array([s.number for s in squares], int) ** 2, "square", "", "number")
    a.curve("noise", np.array([s.noise for s in squares]).reshape(-1, 50), "noise", "", "number component")
    a.number("count", len(squares), "number of squares")
    a.sentence = "done"
