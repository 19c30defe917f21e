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

from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.results.quantities import Quantity, result_dataset
from wucht.schema import si
from wucht.studies.cluster import TaskReport
from wucht.studies.spec import Spec
from wucht.studies.subjects import Description


class Marked:
    """A subject that is no machine: the folder of the marks."""

    def describe(self, subject: Any) -> Description:
        return Description("marks", True, {})


MARKED = Marked()


class TiledSquares(Spec):
    """Squares of numbers, a tile each."""

    kind: ClassVar[str] = ""
    subject: ClassVar[str] = f"{__name__}:MARKED"
    tiled: ClassVar[bool] = True

    count: float = si("", "count", default=10, gt=0)
    lasts: float = si("", "seconds a tile takes", default=0.1)


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


def prepare(spec: TiledSquares, subject: Path) -> tuple[TiledSquares, Path]:
    return spec, subject


def run(plan: tuple[TiledSquares, Path], work: Work) -> Iterator[tuple[Square, ...]]:
    spec, folder = plan
    found: dict[str, Square] = {}
    yield ()
    tasks = {f"square {k}": partial(square, folder, spec.lasts, k) for k in range(int(spec.count))}
    for name, one in work.part("squares", 0.0, 0.9).units(tasks, "squares"):
        found[name] = one
        yield tuple(found[n] for n in tasks if n in found)


def dataset(plan: tuple[TiledSquares, Path], squares: tuple[Square, ...]) -> xr.Dataset:
    numbers = np.array([s.number for s in squares], int)
    noise = np.array([s.noise for s in squares]).reshape(-1, 50)
    quantities = [
        Quantity("square", numbers**2, "square", "", "number"),
        Quantity("noise", noise, "noise", "", "number component"),
        Quantity("count", len(squares), "number of squares"),
    ]
    return result_dataset(quantities, "done")


def figure(result: xr.Dataset) -> Any:
    raise NotImplementedError


def report(result: xr.Dataset) -> list[str]:
    return []
