"""The question of a response."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import BalancingBodies, Interval, Spec, Start, Whole


class Response(Spec):
    """Amplitude, phase, self-centring and torque demand over the speed, at a steady speed.

    Every body turns in the sense of the drive of its rotor.
    """

    kind: ClassVar[str] = "response"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion(
            "the speeds at which the motor, its load and the vibration are in balance", {"study.kind": "torque-balance"}
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("speed", "amplitude"), ("speed", "required_torque"))
    solves: ClassVar[str] = "steady vibration of a linear carrier, in closed form"

    range: SI[Interval | None] = si("rad/s", "speed", default=None, help=(
        "lowest and highest speed, not negative; by default from 0.02 to 3 times the highest natural frequency, or to 1.5 "
        "times the speed that the drive reaches without vibration where that is more"
    ))  # fmt: skip
    points: Whole = Field(default=600, ge=2, le=100_000, description=(
        "number of speeds, evenly spaced over the range, to which those that resolve the resonances are added"
    ))  # fmt: skip
    bodies: BalancingBodies = None
    start: Composite[Start] = composite(default_factory=dict, description=(
        "phases of bodies that are held; of several rotors in steady phases, those that select the nearest stable configuration"
    ))  # fmt: skip

    def check(self) -> None:
        """Refuse negative speeds."""
        if self.range is not None and self.range[0] < 0:
            requirement = "must be a pair [low, high] of speeds of at least 0; bodies turn in the sense of their drives"
            raise InputError("study.range", list(self.range), requirement)

    def turning(self) -> str:
        """See ``Spec``."""
        return "all bodies turn at each speed of the range"
