"""The question of a sweep."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from wucht.dynamics.sweeps.jumps import JUMP_TOLERANCE
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL, Engine, Pair, Path, Quantity, Spec, Start, Tolerance


class Sweep(Spec):
    """Move the parameter ``along``, the swept parameter, through ``range``, so slowly that the machine follows.

    rate: in the parameter's unit a unit of time; None: the range takes a thousand times as long as the machine takes to answer.
    direction: ``"both"`` (up, then down again), ``"up"`` or ``"down"``. start: the initial state, see ``initial_state``; the
    machine starts there with the parameter at its first value, and settles. jump_tolerance: relative, of the values at which
    it jumps. tolerance: of the integration. engine: see ``RunUp``.
    """

    kind: ClassVar[str] = "sweep"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("value", "speed"), ("value", "amplitude"))
    headline: ClassVar[tuple[str, ...]] = ("peak_amplitude",)
    solves: ClassVar[str] = FULL
    from_start: ClassVar[bool] = True

    along: Path
    range: Pair
    rate: Quantity | None = Field(None, description="rate of the parameter")
    direction: Literal["both", "up", "down"] = Field("both", description="direction")
    start: Start = Field(default_factory=dict)
    jump_tolerance: Annotated[float, Field(ge=1e-8, le=0.1, description="tolerance of the jumps")] = JUMP_TOLERANCE
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None
