"""The question of a sweep."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from wucht.dynamics.sweeps.jumps import JUMP_TOLERANCE
from wucht.schema import Composite, composite
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, Engine, Pair, Path, Spec, Start, Tolerance, Value, Whole


class Sweep(Spec):
    """Move the parameter ``along``, the swept parameter, through ``range``, so slowly that the machine follows."""

    kind: ClassVar[str] = "sweep"
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion(
            "all branches of steady operation, also those that a sweep jumps over",
            {"study.kind": "speed-curve", "study.along": "{along}", "study.range": "{range}"},
        ),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("value", "speed"), ("value", "amplitude"))
    curves_of_equations: ClassVar[tuple[tuple[str, str], ...]] = (("value", "high"), ("value", "low"))
    solves: ClassVar[str] = FULL_EQUATIONS
    from_start: ClassVar[bool] = True

    along: Path = Field(description="path of the parameter that is swept")
    range: Composite[Pair]
    rate: Value | None = Field(default=None, title="rate of the parameter", description=(
        "rate of the parameter, in its unit per unit of time; by default the range takes a thousand times as long as the "
        "response of the machine"
    ))  # fmt: skip
    direction: Literal["both", "up", "down"] = Field(
        default="both", description='direction of the sweep: `"both"` (up, then down again), `"up"` or `"down"`'
    )
    start: Composite[Start] = composite(default_factory=dict, description=(
        "initial state; the machine starts there with the parameter at its first value, and settles"
    ))  # fmt: skip
    jump_tolerance: float = Field(
        default=JUMP_TOLERANCE, ge=1e-8, le=0.1, description="relative tolerance of the values of jumps"
    )
    points: Whole = Field(
        default=101, ge=11, le=10_000, description="number of values of the parameter, of the equations of a table [system]"
    )
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None
