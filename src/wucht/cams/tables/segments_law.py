"""The table [law] of a motion in segments, each with a law of its own: [[law.segments]]."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, ClassVar

from pydantic import Field

from wucht.cams.demands import format_degrees, format_millimetres
from wucht.cams.laws.cam_segments import Segment, SegmentedMotion, angle_after
from wucht.cams.laws.standard_laws import StandardLaw
from wucht.cams.tables.motion_law import (
    GROUP,
    LawTable,
    Position,
    SegmentedMotionLaw,
    read_output,
)
from wucht.cams.tables.rise_table import RiseTable
from wucht.errors import InputError, nearest
from wucht.kinds import kinds_of
from wucht.schema import SI, Composite, TableModel, composite, si, validate_table

_DWELL = "dwell"
_TURN = 2 * math.pi
_CLOSURE = 1e-9  # of the largest stroke: by so much the strokes may miss zero, as decimals of a file are rounded
_TOUCH = 1e-9  # rad: arcs that overlap by less touch
_SHORTEST = 1e-6  # rad


class SegmentTable(TableModel):
    """Segment of a turn on which the output moves by one law, or rests."""

    law: str = Field(alias="kind", title="kind", description='a law that rises, such as "3-4-5", or "dwell"')
    begin: SI[float | None] = si("rad", "cam angle", default=None, alias="from", help=(
        "cam angle at which it begins, by default where the one before ends, the first at 0; the output rests between segments"
    ))  # fmt: skip
    end: SI[float | None] = si("rad", "cam angle", default=None, alias="to", help=(
        "cam angle at which it ends; the last one by default a turn after the first one's begin"
    ))  # fmt: skip
    stroke: Position | None = Field(default=None, title="stroke", description=(
        "by how much the output has moved at its end, negative where it goes back; none of a dwell"
    ))  # fmt: skip
    points: Composite[tuple[tuple[float, float], ...]] = composite(
        default=(), description="points of a spline: shares of the arc and of the stroke"
    )

    def standard_law(self, location: str) -> StandardLaw | None:
        """Return its law, None where it rests. Raises ``InputError``."""
        if self.law == _DWELL:
            return None
        kinds: dict[str, type[Any]] = {k: c for k, c in kinds_of(LawTable, GROUP).items() if issubclass(c, RiseTable)}
        if self.law not in kinds:
            hint = nearest(self.law, [_DWELL, *kinds])
            raise InputError(f"{location}.kind", self.law, f"unknown kind; {hint}", code="unknown-name")
        entries = {"stroke": 1.0, "rise": (0.0, 1.0)} | ({"points": self.points} if self.points else {})
        try:
            law: StandardLaw = validate_table(kinds[self.law], entries, "law").rise_law()
        except InputError as error:
            raise InputError(error.location.replace("law", location, 1), error.value, error.explanation) from None
        return law


class SegmentsTable(LawTable):
    """Segments over a turn, each with a law of its own: rise, dwell, fall, in any number and order."""

    kind: ClassVar[str] = "segments"

    segments: Composite[tuple[SegmentTable, ...]] = composite(
        title="segments", description="segments in the order of the cam angle, tables: `[[law.segments]]`", min_length=1
    )

    def output_values(self) -> Iterator[tuple[str, float | str]]:
        """See ``LawTable``."""
        for i, segment in enumerate(self.segments):
            if segment.stroke is not None:
                yield f"law.segments[{i}].stroke", segment.stroke

    def make_motion_law(self, unit: str) -> SegmentedMotionLaw:
        """See ``LawTable``. Raises ``InputError``: arcs that overlap, a turn that does not close, a velocity that jumps."""
        begin, height, t, parts = self.segments[0].begin or 0.0, 0.0, 0.0, list[Segment]()
        for i, (table, arc) in enumerate(zip(self.segments, self._arcs(begin), strict=True)):
            at = f"law.segments[{i}]"
            law, stroke = table.standard_law(at), _stroke(table, unit, at)
            if arc[0] > t:
                parts.append(Segment(None, t, arc[0], height))
            parts.append(Segment(law, *arc, height, stroke))
            t, height = arc[1], height + stroke
        if t < _TURN:
            parts.append(Segment(None, t, _TURN, height))
        largest = max(abs(part.stroke) for part in parts)
        if not largest:
            raise InputError("law.segments", None, "nothing moves: all segments are dwells", code="rests")
        if abs(height) > _CLOSURE * largest:
            closing = "after a turn the output must be where it began"
            sentence = f"the strokes of all segments add up to {_travel(height, unit)}, not to zero: {closing}"
            raise InputError("law.segments", None, sentence, code="not-closed")
        motion = SegmentedMotion(begin, tuple(parts))
        for angle, step in motion.jumps(1).items():
            sentence = f"the velocity jumps by {_travel(step, unit)}/rad at {format_degrees(angle)}"
            raise InputError("law.segments", None, f"{sentence}: take laws that begin and end at rest", code="jumps")
        return SegmentedMotionLaw(motion, unit)

    def _arcs(self, begin: float) -> Iterator[tuple[float, float]]:
        """Yield begin and end of each segment in rad, from the first one's begin on. Raises ``InputError``."""
        last = 0.0
        for i, table in enumerate(self.segments):
            start = last if table.begin is None else float(angle_after(begin, table.begin))
            if start < last - _TOUCH:
                sentence = f"must not lie before the end of the segment before, {format_degrees(begin + last)}"
                raise InputError(f"law.segments[{i}].from", format_degrees(table.begin or 0.0), sentence)
            start = last if start < last + _TOUCH else start
            if table.end is None and i < len(self.segments) - 1:
                requirement = "this key is missing; give the cam angle at which it ends: only the last segment may omit it"
                raise InputError(f"law.segments[{i}].to", None, requirement, code="missing")
            turn = begin + _TURN
            end = float(angle_after(begin, turn if table.end is None else table.end))
            end = end if end > _TOUCH else _TURN
            if end < start + _SHORTEST or (table.end or turn) > turn + _TOUCH:
                value = None if table.end is None else format_degrees(table.end)
                allowed = f"after its begin, {format_degrees(begin + start)}, and at most at {format_degrees(turn)}"
                raise InputError(f"law.segments[{i}].to", value, f"must lie {allowed}")
            yield start, end
            last = end


def _stroke(table: SegmentTable, unit: str, location: str) -> float:
    """Return the stroke of a segment in rad or m. Raises ``InputError`` where there is none, or a dwell has one."""
    key = f"{location}.stroke"
    if table.stroke is None and table.law != _DWELL:
        requirement = "this key is missing; give the stroke of the output, negative where it goes back"
        raise InputError(key, None, requirement, code="missing")
    stroke = 0.0 if table.stroke is None else read_output(unit, table.stroke, key)
    if table.law == _DWELL and stroke:
        raise InputError(key, table.stroke, "a dwell has none: the output rests")
    if table.law != _DWELL and not (stroke and math.isfinite(stroke)):
        raise InputError(key, table.stroke, 'must be a finite number other than 0; kind = "dwell" rests')
    return stroke


def _travel(value: float, unit: str) -> str:
    return format_degrees(value) if unit == "rad" else format_millimetres(value)
