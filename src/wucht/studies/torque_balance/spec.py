"""The question of a torque balance."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.schema import si
from wucht.studies.spec import BalancingBodies, Interval, Spec, Start, Whole


class TorqueBalance(Spec):
    """The drive's characteristic, the load line and the vibration torque over the speed, and the working points."""

    kind: ClassVar[str] = "torque-balance"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("speed", "drive_torque"), ("speed", "surplus_torque"))
    solves: ClassVar[str] = "steady vibration of a linear carrier, in closed form"

    range: Interval | None = si("rad/s", "speed", default=None, help=(
        "lowest and highest speed, signed; by default from 0 to 1.2 times the speed that the drive reaches without vibration; "
        "where it reaches none, or one beyond 20 times the highest natural frequency (and 3000 rad/s), to 3 times that "
        "frequency, and to 1.2 times the fastest working point up to there"
    ))  # fmt: skip
    on: str | None = Field(None, title="rotor", description=(
        "name of the rotor whose shaft is balanced, by default the main one; other rotors turn with it at the same speed"
    ))  # fmt: skip
    points: Whole = Field(1200, ge=2, le=100_000, description=(
        "number of speeds, evenly spaced over the range, to which those are added that resolve resonances and breakdown"
    ))  # fmt: skip
    bodies: BalancingBodies = None
    start: Start = Field(default_factory=dict, description="phases of balancing bodies that are held, and of other rotors")

    def turning(self) -> str:
        """See ``Spec``."""
        return "all bodies turn at one speed; the drive as its characteristic says"
