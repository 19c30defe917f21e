"""The question of a coast-down."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from wucht.errors import InputError
from wucht.schema import si
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL, BalancingBodies, Engine, Spec, Start, Tolerance


class CoastDown(Spec):
    """Let the machine run without its drives; loads, bearings and dampers stay."""

    kind: ClassVar[str] = "coast-down"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("time", "speed"), ("speed", "amplitude"))
    solves: ClassVar[str] = FULL

    until: float | None = si("s", "time", default=None, gt=0, help=(
        "time at which the run ends; none: until it has stopped, swings, or turns at a hundredth of its speed"
    ))  # fmt: skip
    start: Start = Field(default_factory=dict, description=(
        "initial state; rotors for which it gives no speed start with the speed that their drive reaches, and the bodies about "
        "them turn along"
    ))  # fmt: skip
    bodies: BalancingBodies = Field(None, description=(
        'where balancing bodies start: `"steady"`, in a stable steady configuration of that speed (one that compensates before '
        'others); or `"held"`, at the phases of `start`, by default at 0. By default steady where `start` names none of them '
        "and these phases are known, else held, with a warning where this key is not given"
    ))  # fmt: skip
    vibration: Literal["steady", "none"] | None = Field(None, description=(
        'vibration of the carrier at the start: `"steady"`, as it vibrates while all bodies turn with their speeds at the '
        'start, in the phases of the start; or `"none"`, at rest, so that what it does at first is a transient. Where `start` '
        "says how the carrier moves, it starts like that"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """See ``Spec``."""
        if self.vibration is not None and "carrier" in self.start:
            raise InputError("study.vibration", self.vibration, "not allowed: study.start.carrier says how the carrier starts")

    def turning(self) -> str:
        """See ``Spec``."""
        return "without its drives"
