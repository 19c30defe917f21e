"""What papers print and others computed, beside the catalogue's own numbers."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("published.toml")
_DEGREES = {"deg": 180 / math.pi}


@dataclass(frozen=True)
class Compared:
    """A number and ours. within: by how much they may differ, in its unit. by: who says so."""

    quantity: str
    theirs: float
    ours: float
    unit: str
    by: str
    within: float

    @property
    def off(self) -> float:
        """The difference; of angles the shorter way round."""
        off = self.ours - self.theirs
        return (off + 180) % 360 - 180 if self.unit == "deg" else off

    @property
    def agrees(self) -> bool:
        """Whether they differ by no more than they may, and by what floating point makes of the bound."""
        return abs(self.off) <= self.within * (1 + 1e-9)


@cache
def published() -> dict[str, Any]:
    """The file, by the names of the catalogue."""
    return tomllib.loads(FILE.read_text(encoding="utf-8"))


def compared(name: str, summary: Mapping[str, Any]) -> list[Compared]:
    """The numbers of an entry beside those of its summary."""
    return [_beside(number, summary) for number in published().get(name, {}).get("numbers", [])]


def contradicted(name: str, summary: Mapping[str, Any]) -> list[str]:
    """What must be so and is not."""
    given = published().get(name, {}).get("given", [])
    return [f"{name}: {g['path']} is no {g['value']!r}" for g in given if at(summary, g["path"]) != g["value"]]


def at(summary: Mapping[str, Any], path: Sequence[str | int]) -> Any:
    """The value at a path into a summary."""
    value: Any = summary
    for step in path:
        value = value[step]
    return value


def _beside(number: Mapping[str, Any], summary: Mapping[str, Any]) -> Compared:
    unit, theirs = number.get("unit", ""), float(number["value"])
    ours = float(at(summary, number["path"])) * _DEGREES.get(unit, 1.0)
    within = number["within"] * (abs(theirs) if number.get("relative") else 1.0)
    return Compared(number["quantity"], theirs, ours % 360 if unit == "deg" else ours, unit, number["by"], within)
