"""The question of a branch of orbits."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from wucht.dynamics.branches.orbit_problem import OrbitSettings
from wucht.errors import InputError
from wucht.schema import SI, Composite, Conversion, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import Ranges
from wucht.studies.spec import AVERAGED_EQUATIONS, Inertia, Pair, Path, Spec, Start, TrueOrFalse, Values


def _ensure_list(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else [value]


_SeveralValues = Annotated[Values | None, BeforeValidator(_ensure_list)]


class OrbitBranch(Spec):
    """Modulated motions over a parameter: branches of periodic orbits of the averaged equations, and their ends.

    Of forced equations, with the phase of the forcing as a state, this is the nonlinear frequency response: the amplitude over
    the frequency, with folds where it jumps.

    002, sections 5.2 and 6.2, figures 5.6, 5.7, A.3.
    """

    kind: ClassVar[str] = "orbit-branch"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion(
            "all branches of steady operation over the same parameter",
            {"study.kind": "speed-curve", "study.along": "{along}", "study.range": "{range}"},
        ),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    solves: ClassVar[str] = AVERAGED_EQUATIONS
    from_start: ClassVar[bool] = True
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    meaning: ClassVar[tuple[str, ...]] = (*Spec.meaning, "at", "show", "ranges", "together", "until", "longest", "switch")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("value", "period"), ("value", "mean_speed"))
    curves_of_equations: ClassVar[tuple[tuple[str, str], ...]] = (("value", "period"),)

    along: Path = Field(description="path of the parameter over which branches are followed")
    range: Composite[Pair]
    at: Conversion[_SeveralValues, float | str | list[Any]] = composite(default=None, description=(
        "values at which a run searches for a first orbit, from `start`; by default several, until there is one, and then the "
        "Hopf points of the steady states"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict)
    until: SI[float | None] = si("s", "time", default=None, gt=0, help="longest time of such a run")
    values: Composite[Values | None] = composite(
        default=None, description="values with orbits and exact exponents; by default ten along each branch"
    )
    longest: SI[float | None] = si("s", "period", default=None, gt=0, help=(
        "period up to which a branch is followed, by default twenty times that of the first orbit; raise it where the "
        "branch ends at this period"
    ))  # fmt: skip
    switch: TrueOrFalse = Field(
        default=False, description="whether branches from branch points and period doublings are followed"
    )
    together: TrueOrFalse = Field(default=False, description="whether equal balancing bodies keep equal phases")
    show: str | None = Field(default=None, description="state of a system that is drawn")
    ranges: Composite[Ranges | None] = composite(default=None)
    inertia: Inertia | None = Field(default=None, description=(
        "whether the averaged equations keep the inertia of the balancing bodies; false: strongly damped, 002 (4.60)-(4.62), "
        "the default of the dimensionless machines where all are damped"
    ))  # fmt: skip

    @property
    def settings(self) -> OrbitSettings:
        """Return the settings of the search for orbits and of their continuation."""
        keys = ("start", "until", "longest", "switch", "together", "show", "ranges", "inertia")
        return OrbitSettings(**{key: getattr(self, key) for key in keys})

    def check(self) -> None:
        """Check that given lists are not empty."""
        for key in ("at", "values"):
            values = getattr(self, key)
            if values is not None and not values:
                raise InputError(f"study.{key}", [], "must have at least one value")
