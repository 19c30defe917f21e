"""The question of a sweep."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from wucht.dynamics.sweeps.jumps import JUMP_TOLERANCE
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL, Engine, Pair, Path, Quantity, Spec, Start, Tolerance

SENSE = {"up": "rising", "down": "falling"}  # of the swept parameter


class Sweep(Spec):
    """Move the parameter ``along``, the swept parameter, through ``range``, so slowly that the machine follows."""

    kind: ClassVar[str] = "sweep"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("value", "speed"), ("value", "amplitude"))
    solves: ClassVar[str] = FULL
    from_start: ClassVar[bool] = True

    along: Path = Field(description="path of the parameter that is swept")
    range: Pair
    rate: Quantity | None = Field(None, title="rate of the parameter", description=(
        "rate of the parameter, in its unit a unit of time; by default the range takes a thousand times as long as the machine "
        "takes to answer"
    ))  # fmt: skip
    direction: Literal["both", "up", "down"] = Field(
        "both", description='direction of the sweep: `"both"` (up, then down again), `"up"` or `"down"`'
    )
    start: Start = Field(default_factory=dict, description=(
        "initial state; the machine starts there with the parameter at its first value, and settles"
    ))  # fmt: skip
    jump_tolerance: float = Field(JUMP_TOLERANCE, ge=1e-8, le=0.1, description="relative tolerance of the values of jumps")
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None
