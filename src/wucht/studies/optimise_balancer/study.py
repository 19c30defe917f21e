"""Best balancer: number, mass, place and damping of the balancing bodies of a machine, searched for several objectives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, Field

from wucht.analysis.averaged_equations import keeps_inertia
from wucht.dynamics.balancers.balancer_search import BalancerSearch
from wucht.dynamics.balancers.candidates import (
    PEAK,
    BalancerTrials,
    CandidateResults,
    unbalance_parameter,
    with_bodies,
)
from wucht.dynamics.balancers.damping_optimum import curve_trials
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensembles import omission_warnings
from wucht.dynamics.sampling.searches import Variable, balancer_names, require_pymoo, variables_of
from wucht.dynamics.work import Work
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.key_types import Interval, Tolerance, TrueOrFalse, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.optimise_balancer.answer import OBJECTIVES, Objective, state_search
from wucht.studies.optimise_balancer.figure import figure
from wucht.studies.shared_keys import EnsembleStudy, Vary
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS
from wucht.system import TIME

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Bodies that compensate in a family of states drift along it with the integration's error: at the 1e-6 of other ensembles up
# to half of the runs of four balls come to no verdict, and those cost more than the tolerance.
_TOLERANCE = 1e-10
_MOST_BODIES = 10
_MOST_RUNS = 10_000_000
_SLOW_PEAK = (
    "the peaks of the search are those of averaged equations, in which the vibration follows the speed at once: they are too "
    "high where a resonance is passed fast; the check has those of the full equations"
)
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


class OptimiseBalancer(EnsembleStudy):
    """Optimise the number, mass, place and damping of the balancing bodies of a machine: a Pareto front.

    000, section 6: between oscillation and creep there is a damping with which bodies settle fastest.

    Candidates are evaluated by the equations of ``model``, by default with the bodies' inertia: without it nothing oscillates.
    """

    kind = "optimise-balancer"
    next_questions = (NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),)
    without_inertia = False
    trials = ("compared",)
    meaning = (*EnsembleStudy.meaning, "vary", "objectives")
    curves = (("damping", "settling_time"),)

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
        "be captured more often than the present machine"
    ))  # fmt: skip
    bodies: Composite[BodyCounts | None] = composite(
        default=None, description="numbers of bodies to try, each like the first one of the machine"
    )
    unbalance: SI[Interval | None] = si("kg m", "unbalance", default=None, help=(
        "unbalance of the rotor, [low, high]: the runs of a candidate are spread evenly over it, both ends included; by "
        "default that of the machine"
    ))  # fmt: skip
    samples: Whole = Field(default=16, description=(
        "number of runs of a candidate, from the same random phases for all; a check has four times as many"
    ))  # fmt: skip
    evaluations: Whole = Field(default=192, description="number of candidates in all")
    population: Whole = Field(default=16, description="number of candidates of each generation")
    points: Whole = Field(default=12, description=(
        "number of points of the front, at most, that are checked with the full equations, from other random phases"
    ))  # fmt: skip
    seed: Whole = Field(default=1, description="seed of the random starts and of the search")
    tolerance: Tolerance = _TOLERANCE
    damping_curve: TrueOrFalse = Field(default=True, description=(
        "whether the settling time is also computed over the damping of all bodies, the machine otherwise unchanged"
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
        """Return the equations, see ``Study``."""
        search_equations = FULL_EQUATIONS if self.model == "full" else AVERAGED_EQUATIONS
        return f"{search_equations} for the search, {FULL_EQUATIONS} for the front"

    def prepare(self, subject: Machine) -> tuple[BalancerSearch, tuple[str, ...]]:
        """Return the search, and warnings. Raises ``InputError`` where the question does not fit the machine."""
        require_pymoo(self.kind)
        if not any(isinstance(p, Body) for p in subject.parts):
            reason = "not allowed: bodies, [[machine.bodies]], are needed, whose numbers are varied"
            raise InputError("machine.model", None, reason)
        balancing_bodies = balancer_names(subject)
        if not balancing_bodies:
            raise InputError("machine.bodies", None, f"there are no balancing bodies about {subject.rotor.name!r}")
        path, factor, _ = unbalance_parameter(subject)
        low, high = self.unbalance or (subject.values[path] / factor,) * 2
        if not low > 0:
            reason = "must be greater than 0, or study.unbalance = [low, high] must be given"
            raise InputError(path, subject.values[path], reason)
        inertia = keeps_inertia(subject, True if self.inertia is None else self.inertia)
        self._check_start(subject)
        as_it_is = BalancerTrials(
            subject, self._variables(subject, path, factor), path, (low * factor, high * factor), inertia,
            self.samples, self.seed, self.start, self.until, self.order, self.tolerance,
        )  # fmt: skip
        columns = self._columns(subject)
        as_it_is.check_ends()
        warnings = omission_warnings(as_it_is.question(self.model), self.start, (), ())
        trials = dict[int, BalancerTrials]()
        for count in self.bodies or (len(balancing_bodies),):
            machine = with_bodies(subject, count)
            trials[count] = replace(as_it_is, machine=machine, variables=self._variables(machine, path, factor))
        for of_count in trials.values():
            initial_state(of_count.machine, self.start)
        curve = curve_trials(as_it_is) if self.damping_curve else None
        if self.damping_curve and curve is None:
            warnings = (*warnings, "there is no damping curve: some balancing body has no damping that could be varied")
        if self.model == "slow" and PEAK in columns:
            warnings = (*warnings, _SLOW_PEAK)
        search = BalancerSearch(
            as_it_is, trials, curve, columns, self.model, self.evaluations // (len(trials) * self.population),
            self.population, self.points,
        )  # fmt: skip
        return search, warnings

    def _variables(self, machine: Machine, path: str, factor: float) -> tuple[Variable, ...]:
        """Return the variables. path, factor: of the rotor's unbalance, which is not varied. Raises ``InputError``."""
        variables = variables_of(machine, self.vary, self.bodies is not None)
        varied_paths = {p for v in variables for p in v.paths}
        if path in varied_paths:
            raise InputError(f"study.vary.{path}", None, "not allowed: the unbalance is given by study.unbalance")
        if (mass := f"{machine.rotor.name}.mass") in varied_paths and factor != 1.0:
            raise InputError("study.vary", mass, "allowed only where the rotor's unbalance itself is given")
        return variables

    def _columns(self, machine: Machine) -> tuple[int, ...]:
        """Return the columns of the objectives. Raises ``InputError`` for the peak of a rotor that passes no resonance."""
        prescribed_motion = machine.rotor.coordinate.prescribed_velocity
        is_held = prescribed_motion is not None and TIME not in prescribed_motion.free_symbols and not machine.schedules
        if is_held and "peak" in (self.objectives or ()):
            reason = "the drive holds the rotor's speed from the beginning, so that it passes no resonance on the way"
            raise InputError("study.objectives", "peak", f"not allowed: {reason}")
        objectives = self.objectives or tuple(o for o in OBJECTIVES if not (is_held and o == "peak"))
        return tuple(OBJECTIVES.index(o) for o in objectives)

    def _check_start(self, machine: Machine) -> None:
        """Refuse a start with phases of balancing bodies, which are random. Raises ``InputError``."""
        for name, value in self.start.items():
            speed_alone = isinstance(value, Mapping) and "angle" not in value
            if name in ("psi", "delta") or (name in balancer_names(machine) and not speed_alone):
                raise InputError(f"study.start.{name}", value, "not allowed: the phases of balancing bodies are random")

    def solve(self, subject: Machine, prepared: tuple[BalancerSearch, tuple[str, ...]], work: Work) -> Iterator[Answer]:
        """Evaluate the machine and generations of candidates, check their front, and compare what may be recommended."""
        search, doubts = prepared
        units, (machine_share, curve_share, search_share, front_share) = subject.units, search.shares
        as_it_is = search.evaluate_machine(work.part("as it is", 0.0, machine_share))
        unbalance = self.unbalance or (unbalance_parameter(subject)[2],) * 2
        state = partial(state_search, search=search, unbalance=unbalance, doubts=doubts, as_it_is=as_it_is)
        yield Answer(units, state)
        curve = search.follow_curve(work.part("curve", machine_share, curve_share))
        if curve is not None:
            state = partial(state, curve=curve)
            yield Answer(units, state)
        evaluations = list[tuple[int, CandidateResults]]()
        for generation in search.evaluate_generations(as_it_is, work.part("search", curve_share, search_share)):
            evaluations.append(generation)
            yield Answer(units, partial(state, evaluations=tuple(evaluations)))
        front, front_size = search.front(evaluations, as_it_is)
        state = partial(state, evaluations=tuple(evaluations), front_size=front_size)
        yield Answer(units, partial(state, front=tuple(front)))
        for _ in search.check_front(front, work.part("front", search_share, front_share)):
            yield Answer(units, partial(state, front=tuple(front)))
        if front:
            part = work.part("recommendation ", front_share, 1.0)
            recommendation = search.recommend(as_it_is, curve, evaluations, front, part.part("", 0.0, 0.9))
            last_point = search.evaluate_recommended(recommendation, front, part.part("point ", 0.9, 1.0))
            front += [] if last_point is None else [last_point]
            state = partial(state, recommendation=recommendation)
        work.report(1.0)
        yield Answer(units, partial(state, front=tuple(front)))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the front in each pair of objectives, and the damping curve."""
        return figure(result)
