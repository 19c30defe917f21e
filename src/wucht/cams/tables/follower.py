"""The table [follower] of a cam file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Self

from pydantic import Field, StrictBool, model_validator

from wucht.cams.followers import FlatFaced, OscillatingRoller, TranslatingRoller
from wucht.fields import Described, si


class FollowerTable(Described):
    """A follower of some kind. clockwise: the sense in which the cam turns. unit: of its motion."""

    unit: ClassVar[str] = "m"

    clockwise: StrictBool = Field(False, description="sense of the cam, true: clockwise")

    @classmethod
    def where(cls) -> str:
        """In a file."""
        return "follower"


class CounterTable(Described):
    """The lever of the counter cam, rigidly joined to that of the cam."""

    arm: float = si("m", "arm of the lever", gt=0)
    roller_radius: float = si("m", "radius of the roller", gt=0)
    angle: float = si("rad", "angle of the lever where the law is zero")


class OscillatingRollerTable(FollowerTable):
    """A roller on a lever."""

    kind: ClassVar[str] = "oscillating-roller"
    unit: ClassVar[str] = "rad"

    pivot: float = si("m", "distance of the lever's pivot from the cam's centre", gt=0)
    arm: float = si("m", "arm of the lever", gt=0)
    roller_radius: float = si("m", "radius of the roller", gt=0)
    angle: float = si("rad", "angle of the lever where the law is zero")
    counter: CounterTable | None = None
    groove: StrictBool = Field(False, description="choice of a groove, true or false")

    @model_validator(mode="after")
    def _holds_one_way(self) -> Self:
        if self.groove and self.counter is not None:
            raise ValueError("groove", "a groove holds the roller by itself: give either groove = true or a counter cam")
        return self

    def follower(self) -> OscillatingRoller:
        """The follower."""
        return OscillatingRoller(self.pivot, self.arm, self.roller_radius, self.angle)

    def counter_follower(self) -> OscillatingRoller | None:
        """That of the counter cam, if there is one."""
        c = self.counter
        return None if c is None else OscillatingRoller(self.pivot, c.arm, c.roller_radius, c.angle)


class TranslatingRollerTable(FollowerTable):
    """A roller on a rod."""

    kind: ClassVar[str] = "translating-roller"

    distance: float = si("m", "distance of the roller's centre where the law is zero", gt=0)
    roller_radius: float = si("m", "radius of the roller", gt=0)
    offset: float = si("m", "offset of the rod's axis", default=0.0)
    groove: StrictBool = Field(False, description="choice of a groove, true or false")

    def follower(self) -> TranslatingRoller:
        """The follower."""
        return TranslatingRoller(self.distance, self.roller_radius, self.offset)


class FlatFacedTable(FollowerTable):
    """A flat face across a rod."""

    kind: ClassVar[str] = "flat-faced"

    distance: float = si("m", "distance of the face from the cam's centre where the law is zero", gt=0)

    def follower(self) -> FlatFaced:
        """The follower."""
        return FlatFaced(self.distance)


FOLLOWERS: Mapping[str, type[FollowerTable]] = {
    t.kind: t for t in (OscillatingRollerTable, TranslatingRollerTable, FlatFacedTable)
}
