"""The table [linkage] of a cam file: the linkage between the follower's lever and the output."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Literal

from pydantic import Field

from wucht.cams.linkages.closure import Linkage
from wucht.cams.linkages.four_bar_and_slider_crank import FourBar, SliderCrank
from wucht.schema import SI, TableModel, si

_Branch = Literal["open", "crossed"]
_SIGN = {"open": +1, "crossed": -1}


class LinkageTable(TableModel):
    """A linkage of some kind. unit: of the output's motion."""

    unit: ClassVar[str] = "rad"

    @classmethod
    def error_location(cls) -> str:
        """Return its path in a file."""
        return "linkage"

    @property
    def output_arm(self) -> float | None:
        """Length in m of the arm of an output that turns; None of one that slides."""
        return None

    @abstractmethod
    def linkage(self) -> Linkage:
        """Return the linkage. Raises ``InputError`` where it does not close."""


class FourBarTable(LinkageTable):
    """Lever and output turn about fixed pivots, and a coupler joins their arms."""

    kind: ClassVar[str] = "four-bar"

    ground: SI[float] = si("m", "distance of the pivots", gt=0)
    input: SI[float] = si("m", "length of the lever's arm", gt=0)
    coupler: SI[float] = si("m", "length of the coupler", gt=0)
    output: SI[float] = si("m", "length of the output's arm", gt=0)
    angle: SI[float] = si("rad", "angle of the lever's arm to the ground where the law is zero")
    branch: _Branch = Field(default="open", description="position of coupler and output, of the two that fit the lever")

    @property
    def output_arm(self) -> float:
        """See ``LinkageTable``."""
        return self.output

    def linkage(self) -> Linkage:
        """See ``LinkageTable``."""
        return FourBar(self.ground, self.input, self.coupler, self.output, self.angle, _SIGN[self.branch])


class SliderCrankTable(LinkageTable):
    """A rod joins the arm of the lever to a slider."""

    kind: ClassVar[str] = "slider-crank"
    unit: ClassVar[str] = "m"

    crank: SI[float] = si("m", "length of the lever's arm", gt=0)
    rod: SI[float] = si("m", "length of the rod", gt=0)
    angle: SI[float] = si("rad", "angle of the crank to the slide where the law is zero")
    offset: SI[float] = si("m", "offset of the slide", default=0.0)
    branch: _Branch = Field(default="open", description="position of rod and slide, of the two that fit the crank")

    def linkage(self) -> Linkage:
        """See ``LinkageTable``."""
        return SliderCrank(self.crank, self.rod, self.angle, self.offset, _SIGN[self.branch])
