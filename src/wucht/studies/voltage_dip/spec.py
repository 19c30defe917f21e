"""Spec of the study of a voltage dip."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, Engine, Spec, Start, Tolerance, Whole

MOST_POINTS = 200
_REQUIREMENT = "must be a time, or a pair [shortest, longest]"


def _parse_duration(raw: Any) -> Any:
    if isinstance(raw, list | tuple):
        if len(raw) != 2:
            raise ValueError(_REQUIREMENT)
        return tuple(raw)
    if raw is not None and (isinstance(raw, bool) or not isinstance(raw, int | float)):
        raise ValueError(_REQUIREMENT)
    return raw


Duration = Annotated[float | tuple[float, float] | None, BeforeValidator(_parse_duration)]


class VoltageDip(Spec):
    """The longest dip of the supply voltage after which the machine returns to operation by itself."""

    kind: ClassVar[str] = "voltage-dip"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion(
            "the speeds at which the motor, its load and the vibration are in balance", {"study.kind": "torque-balance"}
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("dip_duration", "dip_speed"), ("dip_duration", "dip_peak_amplitude"))
    meaning: ClassVar[tuple[str, ...]] = (*Spec.meaning, "duration")
    solves: ClassVar[str] = FULL_EQUATIONS
    from_start: ClassVar[bool] = True

    depth: SI[float] = si(
        "", "share of the voltage that is lost", gt=0, le=1, help="share of the voltage that is lost, up to 1, all of it"
    )
    duration: SI[Duration] = si("s", "duration of the dip", default=None, help=(
        "duration of a dip, of which the outcome is computed beside the critical duration; or a pair [shortest, longest] in "
        "which that is sought; by default it is sought up to the time at which the machine has settled at the low voltage"
    ))  # fmt: skip
    on: str | None = Field(default=None, title="body with the drive", description=(
        "body whose drive loses voltage; by default all drives do"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict, description=(
        "initial state of the run-up to the operating state; from rest by default"
    ))  # fmt: skip
    points: Whole = Field(default=8, ge=1, le=MOST_POINTS, description=(
        "number of durations that are tried before the bisection, evenly spaced in the speed that is lost"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """See ``Spec``."""
        if self.duration is None:
            return
        ends = self.duration if isinstance(self.duration, tuple) else (self.duration,)
        if not all(t > 0 for t in ends):
            raise InputError("study.duration", self.duration, "must be greater than 0 s", code="limits")
        if len(ends) == 2 and not ends[0] < ends[1]:
            raise InputError("study.duration", list(ends), f"{_REQUIREMENT}, the shortest first", code="pair")

    @property
    def limits(self) -> tuple[float, float] | None:
        """The range in which the critical duration is sought; None up to that at which the machine has settled."""
        return self.duration if isinstance(self.duration, tuple) else None

    @property
    def single_duration(self) -> float | None:
        """The duration of the one dip in question, if there is one."""
        return None if isinstance(self.duration, tuple) else self.duration
