"""The question of ``optimise-balancer``."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import BeforeValidator, Field

from wucht.errors import InputError, nearest
from wucht.extending_0_1 import Spec
from wucht.schema import SI, Composite, composite, si
from wucht.studies import key_types as common
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import EnsembleStudy, Vary
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS

Objective = Literal["settling-time", "residual", "peak", "capture-probability"]
OBJECTIVES: tuple[Objective, ...] = get_args(Objective)
# Bodies that compensate in a family of states drift along it with the integration's error: at the 1e-6 of other ensembles up
# to half of the runs of four balls come to no verdict, and those cost more than the tolerance.
_TOLERANCE = 1e-10
_MOST_BODIES = 10
_MOST_RUNS = 10_000_000
_LIMITS = {"samples": (2, 4096), "evaluations": (4, 1_000_000), "population": (4, 1000), "points": (1, 100), "seed": (0, 2**31)}


def _objectives(value: Any) -> Any:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError(f"must be a list of some of {', '.join(OBJECTIVES)}")
    for i, one in enumerate(value):
        if one not in OBJECTIVES:
            raise InputError(f"study.objectives[{i}]", one, f"unknown objective; {nearest(str(one), OBJECTIVES)}")
        if one in value[:i]:
            raise InputError(f"study.objectives[{i}]", one, "is listed twice")
    return tuple(o for o in OBJECTIVES if o in value)


def _bodies(value: Any) -> Any:
    whole = isinstance(value, list | tuple) and all(isinstance(n, int) and not isinstance(n, bool) for n in value)
    if not whole or not value or min(value) < 1 or max(value) > _MOST_BODIES or len(set(value)) < len(value):
        raise ValueError(f"must be a list of different numbers of bodies, from 1 to {_MOST_BODIES}")
    return tuple(sorted(value))


Objectives = Annotated[tuple[Objective, ...], BeforeValidator(_objectives), Field(title="quantities to minimise")]
BodyCounts = Annotated[tuple[int, ...], BeforeValidator(_bodies), Field(title="numbers of bodies to try")]


class OptimiseBalancer(EnsembleStudy, Spec):
    """Optimise the number, mass, place and damping of the balancing bodies of a machine: a Pareto front.

    000, section 6: between oscillation and creep there is a damping with which bodies settle fastest.

    Candidates are evaluated by the equations of ``model``, by default with the bodies' inertia: without it nothing oscillates.
    """

    kind: ClassVar[str] = "optimise-balancer"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    without_inertia: ClassVar[bool] = False
    meaning: ClassVar[tuple[str, ...]] = (*EnsembleStudy.meaning, "vary", "objectives")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("damping", "settling_time"),)

    vary: Composite[Vary] = composite(
        description="{KEY = [low, high]} of a key of the balancing bodies (`damping`, `mass`, `length`, "
        "`track_radius`), which is then the same for all of them; {KEY = {of = [BODY, ...], range = [low, "
        "high]}} for some; {BODY.KEY = [low, high]}, or any other path, for one. A wide range (tenfold) "
        "is searched by its logarithm. A pendulum's inertia keeps its ratio to m l^2"
    )
    objectives: Composite[Objectives | None] = composite(default=None, description=(
        "some of `settling-time` (median time until a run has passed and its bodies are at rest relative to the rotor; a run "
        "without a verdict takes at least as long as it was followed), `residual` (least unbalance that the bodies can leave, "
        "at the worse end of `unbalance`), `peak` (largest amplitude of all runs on the way to the speed), "
        "`capture-probability` (upper bound of the share of captured runs: those without a verdict could be among "
        "them). By default all, but `peak` for a rotor whose speed is held from the beginning. Without the last one, none may "
        "be captured more often than the machine as it is"
    ))  # fmt: skip
    bodies: Composite[BodyCounts | None] = composite(
        default=None, description="numbers of bodies to try, each like the first one of the machine"
    )
    unbalance: SI[common.Interval | None] = si("kg m", "unbalance", default=None, help=(
        "unbalance of the rotor, [low, high]: the runs of a candidate are spread evenly over it, both ends included; by "
        "default that of the machine"
    ))  # fmt: skip
    samples: common.Whole = Field(default=16, description=(
        "number of runs of a candidate, from the same random phases for all; a check has four times as many"
    ))  # fmt: skip
    evaluations: common.Whole = Field(default=192, description="number of candidates in all")
    population: common.Whole = Field(default=16, description="number of candidates of each generation")
    points: common.Whole = Field(default=12, description=(
        "number of points of the front, at most, that are checked with the full equations, from other random phases"
    ))  # fmt: skip
    seed: common.Whole = Field(default=1, description="seed of the random starts and of the search")
    tolerance: common.Tolerance = _TOLERANCE
    damping_curve: common.TrueOrFalse = Field(default=True, description=(
        "whether the settling time is also computed over the damping of all bodies, the machine otherwise as it is"
    ))  # fmt: skip

    def check(self) -> None:
        """Check that the numbers are feasible, and that keys of averaged equations come only with them."""
        super().check()
        for key, (low, high) in _LIMITS.items():
            if not low <= getattr(self, key) <= high:
                raise InputError(f"study.{key}", getattr(self, key), f"must be a whole number from {low} to {high}")
        least = self.population * len(self.bodies or (0,))
        if self.evaluations < least:
            reason = "a population for each number of bodies" if self.bodies else "one population"
            raise InputError("study.evaluations", self.evaluations, f"must be at least {least}: {reason}")
        if self.evaluations * self.samples > _MOST_RUNS:
            raise InputError(
                "study.evaluations", self.evaluations, f"must be at most {_MOST_RUNS // self.samples} with these samples"
            )
        if self.unbalance is not None and self.unbalance[0] <= 0:
            raise InputError("study.unbalance", list(self.unbalance), "must be unbalances greater than 0")

    def equations(self) -> str:
        """See ``Spec``."""
        search_equations = FULL_EQUATIONS if self.model == "full" else AVERAGED_EQUATIONS
        return f"{search_equations} for the search, {FULL_EQUATIONS} for the front"
