"""Spec of the study ``activation``."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, Engine, Spec, Start, Tolerance, Whole

MOST_RUNS = 5000
Variant = Literal["switchable", "balanced", "rigid", "none"]


def _nonempty_list(raw: Any) -> Any:
    if not isinstance(raw, list | tuple) or not raw:
        raise ValueError('must be a list of at least one of these, such as ["90 deg", "180 deg"] or ["150 rad/s"]')
    return raw


Several = Annotated[tuple[float, ...], BeforeValidator(_nonempty_list)]
_ORIENTATIONS = tuple(math.pi * k / 4 for k in range(1, 5))


class Activation(Spec):
    """Run up with switchable pendulums: the peak amplitude over their relative orientation and over their activation speed."""

    kind: ClassVar[str] = "activation"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("curve_speed", "curve_amplitude"),)
    solves: ClassVar[str] = FULL_EQUATIONS

    until: SI[float] = si("s", "time", gt=0, help="time of each run")
    orientations: SI[Several] = si("rad", "orientation", default=_ORIENTATIONS, help=(
        "angle from each switchable pendulum to the next at the start; at 0 only symmetry keeps equal ones together, and "
        "rounding errors decide the motion"
    ))  # fmt: skip
    phases: Whole = Field(default=4, ge=1, le=360, description=(
        "number of their mean phases to the rotor, evenly spaced over a turn, with which each orientation is run"
    ))  # fmt: skip
    activation_speeds: SI[Several] = si("rad/s", "activation speed", default=(), help=(
        'speeds at which the `"switchable"` pendulums open, set by their preload; by default as in the machine'
    ))  # fmt: skip
    variants: Composite[tuple[Variant, ...]] = composite(
        default=("switchable", "rigid", "none"),
        min_length=1,
        title="variants",
        description=(
            'variants to run up: the machine with its `"switchable"` pendulums; with these `"balanced"`, without their '
            'permanent unbalances; with the same `"rigid"`, their masses at the outer stops; with `"none"`, their masses on '
            "the rotor"
        ),
    )
    start: Composite[Start] = composite(default_factory=dict, description="rest of the initial state")
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """Check that speeds are above zero, that nothing is given twice, and that there are not too many runs."""
        if any(not w > 0 for w in self.activation_speeds):
            raise InputError("study.activation_speeds", list(self.activation_speeds), "must be speeds greater than 0")
        for key in ("orientations", "activation_speeds", "variants"):
            values = getattr(self, key)
            if len(set(values)) < len(values):
                raise InputError(f"study.{key}", list(values), "one of these is given twice; give each once")
        runs = len(self.orientations) * self.phases * max(len(self.activation_speeds), 1)
        if runs > MOST_RUNS:
            requirement = f"orientations times phases times activation speeds must be at most {MOST_RUNS} runs"
            raise InputError("study.phases", self.phases, requirement)
