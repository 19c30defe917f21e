"""Spec of the study ``approximation``: 002, 5.6."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import (
    AVERAGED_EQUATIONS,
    DEFAULT_TOLERANCE,
    FULL_EQUATIONS,
    Engine,
    Inertia,
    Order,
    Pair,
    Spec,
    Start,
    Tolerance,
    Values,
    Whole,
)

DEFAULT_POINTS, MOST_POINTS = 7, 200
UNTIL_PHI = 100.0  # rad: 1/epsilon of Table 5.1, over which 002, 5.6.1 expects the averaged equations to hold
_ALONG_KEYS = ("range", "values", "points", "spacing")
_PATHS = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}


def _paths(raw: Any) -> Any:
    paths = raw if isinstance(raw, list | tuple) else [raw]
    if not paths or not all(isinstance(p, str) for p in paths) or len(set(paths)) < len(paths):
        raise ValueError("must be the path of a parameter, or a list of different ones")
    return tuple(paths)


class Approximation(Spec):
    """Run-ups of both models, at the machine's nominal values and over the range of a parameter."""

    kind: ClassVar[str] = "approximation"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("value", "speed_deviation"), ("value", "amplitude_deviation"))
    solves: ClassVar[str] = f"{FULL_EQUATIONS}, compared with {AVERAGED_EQUATIONS}"
    from_start: ClassVar[bool] = True
    without_inertia: ClassVar[bool] = True

    along: Composite[Annotated[tuple[str, ...], BeforeValidator(_paths), WithJsonSchema(_PATHS)]] = composite(
        default=(), title="path of a parameter, or of several",
        description="path of a parameter, or of several that are multiplied by one factor (such as beta_p and beta_r for b_r "
        "in 002, 5.6.2)",
    )  # fmt: skip
    range: Composite[Pair | None] = composite(default=None, description="pair [low, high] of the parameter, or of the factor")
    values: Composite[Values] = composite(
        default=(), description="values of the parameter, or of the factor, instead of a range"
    )
    points: Whole = Field(default=DEFAULT_POINTS, description="number of points in the range")
    spacing: Literal["linear", "log"] | None = Field(
        default=None, description='spacing of the points, `"linear"` or `"log"` (the default over a decade or more)'
    )
    until_phi: SI[float] = si("rad", "angle", default=UNTIL_PHI, gt=0, help="rotor angle up to which deviations count")
    start: Composite[Start] = composite(
        default_factory=dict, description="initial state of the run-ups, which decide the outcomes"
    )
    until: SI[float | None] = si(
        "s", "time", default=None, gt=0, help="time at which the run-ups end, by default when the machine has settled"
    )
    inertia: Inertia | None = None
    order: Order = 1
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """Check that the parameter is varied once: by a range, or by values."""
        given_keys = [key for key in _ALONG_KEYS if key in self.model_fields_set]
        if not self.along:
            if given_keys:
                raise InputError(
                    f"study.{given_keys[0]}", getattr(self, given_keys[0]), "allowed only together with along = PATH"
                )
            return
        if "values" in given_keys:
            if not 0 < len(self.values) <= MOST_POINTS:
                raise InputError("study.values", list(self.values), f"must be a list of 1 to {MOST_POINTS} values")
            if len(given_keys) > 1:
                raise InputError("study.values", None, "give either values, or range with points and spacing")
        elif self.range is None:
            raise InputError(
                "study.range", None, "this key is missing; it must be a pair [low, high] of the parameter", code="missing"
            )
        if not 2 <= self.points <= MOST_POINTS:
            raise InputError("study.points", self.points, f"must be a whole number from 2 to {MOST_POINTS}")

    @property
    def settings(self) -> RunSettings:
        """Settings of the run-ups of both models."""
        return RunSettings(
            self.until, model="both", inertia=self.inertia, order=self.order, tolerance=self.tolerance, engine=self.engine
        )
