"""The table [law] of standard laws, which rise, rest and return, and of a motion by points; the entry point of all laws but
harmonic ones, those in segments too."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from wucht.cams.laws.standard_laws import StandardLaw, standard_law
from wucht.cams.laws.table_law import TableLaw
from wucht.cams.tables.motion_law import UNITS, LawTable, MotionLaw
from wucht.cams.tables.rise_table import RiseTable
from wucht.cams.tables.segments_law import SegmentsTable
from wucht.errors import InputError
from wucht.files.tables import read_table
from wucht.schema import Composite, Unit, composite

__all__ = ["STANDARD", "PointsTable", "RiseTable", "SegmentsTable", "StandardTable"]

_CAM_ANGLE = Unit("rad", "cam angle")


class StandardTable(RiseTable):
    """A standard law by its name."""

    points: Composite[tuple[tuple[float, float], ...]] = composite(
        default=(), description="points of a spline: shares of the rise and of the stroke"
    )

    standard: ClassVar[str] = ""

    def rise_law(self) -> StandardLaw:
        """See ``RiseTable``."""
        return standard_law(self.standard, self.points)


class PointsTable(LawTable):
    """A motion by points over one turn: cam angle and output, from a file or as numbers in SI."""

    kind: ClassVar[str] = "table"

    points: Composite[tuple[tuple[float, float], ...]] = composite(description="points: cam angle and output")
    degree: Literal[3, 5] = Field(default=5, description="degree of the spline through the points")
    unit: Literal["rad", "m"] = Field(default="rad", description="unit of the output, of an angle or a length")

    @classmethod
    def with_file_contents(cls, entries: Mapping[str, Any], folder: Path, unit: str | None) -> Mapping[str, Any]:
        """See ``LawTable``: with the points of its file."""
        if "file" not in entries:
            return entries
        name = entries["file"]
        if not isinstance(name, str) or not name.strip() or "\0" in name:
            raise InputError("law.file", name, "must be the name of a file")
        if "points" in entries:
            raise InputError("law.file", name, "give either file or points")
        failures = list[str]()
        for candidate in [unit] if unit is not None else UNITS:
            try:
                points = read_table(folder / name, (_CAM_ANGLE, UNITS[candidate]))
            except InputError as error:
                failures.append(error.explanation)
            else:
                return {**{k: v for k, v in entries.items() if k != "file"}, "points": points, "unit": candidate}
        raise InputError("law.file", name, max(failures, key=_line_number))  # with the other unit it fails at the heading

    @property
    def stated_unit(self) -> str | None:
        """See ``LawTable``."""
        return self.unit

    def make_motion_law(self, unit: str) -> MotionLaw:
        """See ``LawTable``."""
        angles, outputs = np.array(self.points).reshape(-1, 2).T
        return MotionLaw(TableLaw(angles, outputs, self.degree), unit)


def _line_number(sentence: str) -> int:
    """Return the line number of a file that a message names, 0 without one."""
    line_match = re.match(r"line (\d+):", sentence)
    return int(line_match[1]) if line_match else 0


def _standard_table(kind: str, name: str, description: str) -> type[LawTable]:
    """Return the table class of a standard law: its kind in a file, its name, and its description."""
    return type(
        f"{kind} law", (StandardTable,), {"kind": kind, "standard": name, "__doc__": f"Rise, rest and return: {description}."}
    )


STANDARD: list[type[LawTable]] = [  # in a file "harmonic" is the series; the simple harmonic law of the textbooks is named so
    _standard_table("3-4-5", "3-4-5", "a polynomial whose acceleration begins at zero"),
    _standard_table("4-5-6-7", "4-5-6-7", "a polynomial whose jerk begins at zero"),
    _standard_table("inclined-sine", "inclined-sine", "a sine on a straight line (cycloidal)"),
    _standard_table("modified-sine", "modified-sine", "a sine with faster ends, whose largest velocity is small"),
    _standard_table("modified-trapezoid", "modified-trapezoid", "a trapezoid of acceleration with rounded corners"),
    _standard_table("simple-harmonic", "harmonic", "half a cosine, whose acceleration jumps at both ends"),
    _standard_table("parabolic", "parabolic", "constant acceleration, which jumps at both ends and in the middle"),
    _standard_table("cubic-spline", "cubic-spline", "a spline through points"),
    _standard_table("quintic-spline", "quintic-spline", "a smoother spline through points"),
]
