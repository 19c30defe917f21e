"""A study that recites: what a comparison makes of the numbers, curves, sentences and failures that its variants have."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr
from pydantic import Field

import wucht
from wucht import InputError
from wucht.dynamics.work import Work
from wucht.extending import Answer, Study
from wucht.schema import Parameter, si
from wucht.studies.subjects import Description

KEYS = {"drive.slope": ("slope", "N m s"), "p1.mass": ("mass", "kg"), "b.count": ("number", ""), "b.turns": ("turns", "")}


@dataclass(frozen=True)
class Reciter:
    """A subject that is no machine: the name of its file, and values of keys."""

    title: str
    values: Mapping[str, Any]
    dimensionless: bool = False

    @property
    def parameters(self) -> dict[str, Parameter]:
        return {path: Parameter(path, 0.0, unit, "", what) for path, (what, unit) in KEYS.items()}


class ReciterSubject:
    """Its file has a title and a question; one called "bare" has no units."""

    def from_document(self, document: Any, path: Path, name: str, settings: Mapping[str, Any]) -> Any:
        return Reciter(path.stem, settings, path.stem == "bare"), {}

    def describe(self, subject: Any) -> Description:
        return Description(subject.title, subject.dimensionless, {"title": subject.title, "values": subject.values})


SUBJECT = ReciterSubject()
Say = Callable[[Answer, Reciter], object]
ANSWERS: list[Say] = []
recited: list[str] = []


class Recital(Study):
    """Recite one of the answers. It has a kind only where a test compares."""

    kind = ""
    subject = f"{__name__}:SUBJECT"
    curves = (("time", "swing"), ("time", "sway"), ("x", "y"), ("u", "w"))
    curves_of_equations = (("value", "state"), ("time", "states"))

    says: float = si("", "answer", default=0.0)
    word: str = Field(default="", title="word")
    lasts: float = si("s", "time", default=0.0)
    stores: float = si("", "stored numbers", default=0.0)

    def prepare(self, subject: Reciter) -> float:
        if self.word == "unspeakable":
            raise InputError("study.word", self.word, "must be decent")
        return self.stores

    def stored_numbers(self, prepared: float) -> float:
        return prepared

    def solve(self, subject: Reciter, prepared: float, work: Work) -> Iterator[Answer]:
        recited.append(f"{subject.title} {self.says:g}")
        a = Answer()
        a.sentence = f"answer {self.says:g}"
        ANSWERS[int(self.says)](a, subject)
        yield a

    def draw(self, result: xr.Dataset) -> Any:
        raise NotImplementedError


def compare(*answers: Say, of: tuple[str, ...] = ("a",), vary: dict[str, Any] | None = None, **options: Any) -> xr.Dataset:
    """Compare variants of one file with these answers; of: files by name, each with its own answer, or with the last one."""
    ANSWERS[:] = answers
    recited.clear()
    for k, name in enumerate(of):
        question = f'[study]\nkind = "recital"\nsays = {min(k, len(answers) - 1)}\n'
        Path(f"{name}.toml").write_text(question, encoding="utf-8")
    if vary is None:
        vary = {"study.says": list(range(len(answers)))} if len(of) == 1 else {}
    return wucht.compare([f"{name}.toml" for name in of], None, vary, **options)


def nothing(a: Answer, _: Reciter) -> None:
    """An answer in words alone."""


def speed(value: float | None) -> Say:
    """A number, and nothing else."""
    return lambda a, _: a.number("final_speed", value, "final speed", "rad/s", headline=True)
