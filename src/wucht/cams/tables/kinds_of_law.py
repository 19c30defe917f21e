"""The table [law] of all kinds: what its key ``kind`` may say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from wucht.cams.laws.rise_and_return import RiseAndReturn
from wucht.cams.laws.standard_laws import standard_law
from wucht.cams.laws.table_law import TableLaw
from wucht.cams.tables.harmonic_law import HarmonicTable
from wucht.cams.tables.motion_law import LawTable, MotionLaw
from wucht.cams.tables.output import Position, read_output
from wucht.fields import si


class RiseTable(LawTable):
    """A standard law: it rises by a stroke, rests, and returns."""

    stroke: Position = Field(description="stroke")
    rise: tuple[float, float] = si("rad", "arc of the cam angle")
    back: tuple[float, float] | None = si("rad", "arc of the cam angle", default=None, alias="return")
    points: tuple[tuple[float, float], ...] = Field((), description="points of a spline: shares of the rise and of the stroke")

    standard: ClassVar[str] = ""

    def quantities(self) -> Iterator[tuple[str, float | str]]:
        """See ``LawTable``."""
        yield "law.stroke", self.stroke

    def motion(self, unit: str) -> MotionLaw:
        """See ``LawTable``."""
        stroke = read_output(unit, self.stroke, "law.stroke")
        return MotionLaw(RiseAndReturn(standard_law(self.standard, self.points), stroke, self.rise, self.back), unit)


class PointsTable(LawTable):
    """A motion by points over one turn: cam angle and output, from a file or as numbers in SI.

    unit: of the output.
    """

    kind: ClassVar[str] = "table"

    points: tuple[tuple[float, float], ...] = Field(description="points: cam angle and output")
    degree: Literal[3, 5] = 5
    unit: Literal["rad", "m"] = "rad"

    @property
    def stated_unit(self) -> str | None:
        """See ``LawTable``."""
        return self.unit

    def motion(self, unit: str) -> MotionLaw:
        """See ``LawTable``."""
        angles, outputs = np.array(self.points).reshape(-1, 2).T
        return MotionLaw(TableLaw(angles, outputs, self.degree), unit)


def _standard(kind: str, name: str, what: str) -> type[LawTable]:
    """The table of a standard law: its kind in a file, its name there, and what it is."""
    return type(f"{kind} law", (RiseTable,), {"kind": kind, "standard": name, "__doc__": f"Rise, rest and return: {what}."})


_STANDARD: list[type[LawTable]] = [  # in a file "harmonic" is the series; the simple harmonic law of the textbooks is named so
    _standard("3-4-5", "3-4-5", "a polynomial whose acceleration begins at zero"),
    _standard("4-5-6-7", "4-5-6-7", "a polynomial whose jerk begins at zero"),
    _standard("inclined-sine", "inclined-sine", "a sine on a straight line (cycloidal)"),
    _standard("modified-sine", "modified-sine", "a sine with faster ends, whose largest velocity is small"),
    _standard("modified-trapezoid", "modified-trapezoid", "a trapezoid of acceleration with rounded corners"),
    _standard("simple-harmonic", "harmonic", "half a cosine, whose acceleration jumps at both ends"),
    _standard("cubic-spline", "cubic-spline", "a spline through points"),
    _standard("quintic-spline", "quintic-spline", "a smoother spline through points"),
]
_ALL: list[type[LawTable]] = [HarmonicTable, PointsTable, *_STANDARD]
LAWS: Mapping[str, type[LawTable]] = {t.kind: t for t in _ALL}
