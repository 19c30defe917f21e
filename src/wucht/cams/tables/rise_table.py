"""The keys of the table [law] of a law that rises, rests and returns."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator

from pydantic import Field

from wucht.cams.laws.cam_segments import RiseAndReturn
from wucht.cams.laws.standard_laws import StandardLaw
from wucht.cams.tables.motion_law import LawTable, Position, RiseMotionLaw, read_output
from wucht.schema import SI, si


class RiseTable(LawTable):
    """A law that rises by a stroke, rests, and returns."""

    stroke: Position = Field(title="stroke", description="stroke of the output between its two rests")
    rise: SI[tuple[float, float]] = si("rad", "arc of the cam angle", help="arc on which the output rises, [begin, end]")
    back: SI[tuple[float, float] | None] = si("rad", "arc of the cam angle", default=None, alias="return", help=(
        "arc of the cam angle on which the output returns, `[begin, end]`"
    ))  # fmt: skip

    @abstractmethod
    def rise_law(self) -> StandardLaw:
        """Return the law of the rise, from 0 to 1 over an arc of 1. Raises ``InputError``."""

    def output_values(self) -> Iterator[tuple[str, float | str]]:
        """See ``LawTable``."""
        yield "law.stroke", self.stroke

    def make_motion_law(self, unit: str) -> RiseMotionLaw:
        """See ``LawTable``."""
        stroke = read_output(unit, self.stroke, "law.stroke")
        return RiseMotionLaw(RiseAndReturn(self.rise_law(), stroke, self.rise, self.back), unit)
