"""Question and machine -> plan -> findings: the variables, the candidates, the front, and the curve over the damping."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.averaged import keeps_inertia
from wucht.dynamics.balancers.candidates import (
    CAPTURE,
    Evaluated,
    Trials,
    TrialSettings,
    evaluated,
    power_of_two,
    tried,
    with_bodies,
)
from wucht.dynamics.balancers.damping_optimum import DampingCurve, compensated_state, damping_curve, rates_of
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_equations import why_one_by_one
from wucht.dynamics.sampling.ensemble_run import way_of
from wucht.dynamics.sampling.ensembles import Report, left_out, part_of
from wucht.dynamics.sampling.searches import Variable, balancing, generations, needed, not_dominated, spread_out, variables_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.results.formatting import bodies_in_words
from wucht.studies.optimise_balancer.spec import OBJECTIVES, Objective, OptimiseBalancer
from wucht.system import TIME

_CURVE = 25  # dampings
_DECADES = 1.5  # on either side of the machine's damping, where the question does not vary it
_SLOW_PEAK = (
    "the peaks of the search are those of averaged equations, in which the vibration follows the speed at once: they are too "
    "high where a resonance is passed fast; the check has those of the full equations"
)


@dataclass(frozen=True)
class Plan:
    """The plan of a search for the best balancer.

    objectives: the requested ones. trials: by the number of bodies; ``as_it_is``: of the machine as given. numbers: its
    values of the variables (k,). generations: of each number of bodies. curve: trials of the damping alone, and the
    dampings. way: the integration of the runs, as a phrase; one_by_one: True if each run is integrated separately.
    """

    spec: OptimiseBalancer
    machine: Machine
    objectives: tuple[Objective, ...]
    trials: dict[int, Trials]
    as_it_is: Trials
    numbers: np.ndarray
    generations: int
    curve: tuple[Trials, np.ndarray] | None
    way: str
    one_by_one: bool
    warnings: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Return the variables of the machine as given."""
        return self.as_it_is.variables

    @property
    def asked(self) -> list[int]:
        """Return the columns of the requested objectives."""
        return [k for k, o in enumerate(OBJECTIVES) if o in self.objectives]

    @property
    def runs(self) -> int:
        """Return the largest number of runs: of the machine as it is, the curve, the search, and the points of the front."""
        curve = 0 if self.curve is None else len(self.curve[1])
        searched = len(self.trials) * self.generations * self.spec.population
        return self.spec.samples * (2 + curve + searched + min(self.spec.points, searched))


def prepare(spec: OptimiseBalancer, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the question does not fit the machine."""
    needed(spec.kind)
    if not any(isinstance(p, Body) for p in machine.parts):
        raise InputError("machine.model", None, "not allowed: bodies, [[machine.bodies]], are needed, whose numbers are varied")
    own = balancing(machine)
    if not own:
        raise InputError("machine.bodies", None, f"there are no balancing bodies about {machine.rotor.name!r}")
    path, factor = _unbalance(machine)
    given = spec.unbalance or (machine.values[path] / factor,) * 2
    if not given[0] > 0:
        raise InputError(path, machine.values[path], "must be greater than 0, or study.unbalance = [low, high] must be given")
    inertia = keeps_inertia(machine, True if spec.inertia is None else spec.inertia)
    _check_start(spec, machine)

    settings = TrialSettings(spec.samples, spec.seed, spec.start, spec.until, spec.order, spec.tolerance)

    def trials(of: Machine) -> Trials:
        variables = variables_of(of, spec.vary, spec.bodies is not None)
        if path in {p for v in variables for p in v.paths}:
            raise InputError(f"study.vary.{path}", None, "not allowed: the unbalance is given by study.unbalance")
        if any(p == f"{machine.rotor.name}.mass" for v in variables for p in v.paths) and factor != 1.0:
            raise InputError(
                "study.vary", f"{machine.rotor.name}.mass", "allowed only where the rotor's unbalance itself is given"
            )
        return Trials(settings, of, variables, path, (given[0] * factor, given[1] * factor), inertia)

    as_it_is, objectives = trials(machine), _objectives(spec, machine)
    _check_ends(as_it_is)
    question = as_it_is.question(spec.model)
    warnings = left_out(question, spec.start, (), ())
    counts = spec.bodies or (len(own),)
    by_count = {n: trials(with_bodies(machine, n)) for n in counts}
    for n in counts:
        initial_state(by_count[n].machine, spec.start)
    curve = _curve(as_it_is) if spec.damping_curve else None
    if spec.damping_curve and curve is None:
        warnings = (*warnings, "there is no damping curve: some balancing body has no damping that could be varied")
    if spec.model == "slow" and "peak" in objectives:
        warnings = (*warnings, _SLOW_PEAK)
    numbers = np.array([machine.values[v.paths[0]] for v in as_it_is.variables])
    generations, alone = spec.evaluations // (len(counts) * spec.population), why_one_by_one(question) is not None
    return Plan(
        spec, machine, objectives, by_count, as_it_is, numbers, generations, curve, way_of(question), alone, warnings
    )  # fmt: skip


def _objectives(spec: OptimiseBalancer, machine: Machine) -> tuple[Objective, ...]:
    """Return the objectives. Raises ``InputError`` for the peak of a rotor that does not pass its resonance."""
    given = machine.rotor.coordinate.prescribed
    held = given is not None and TIME not in given.free_symbols and not machine.schedules
    if held and "peak" in (spec.objectives or ()):
        why = "the drive holds the rotor's speed from the beginning, so that it passes no resonance on the way"
        raise InputError("study.objectives", "peak", f"not allowed: {why}")
    return spec.objectives or tuple(o for o in OBJECTIVES if not (held and o == "peak"))


def _check_start(spec: OptimiseBalancer, machine: Machine) -> None:
    """Refuse a start with phases of balancing bodies, which are random. Raises ``InputError``."""
    for name, given in spec.start.items():
        speed_alone = isinstance(given, Mapping) and "angle" not in given
        if name in ("psi", "delta") or (name in balancing(machine) and not speed_alone):
            raise InputError(f"study.start.{name}", given, "not allowed: the phases of balancing bodies are random")


def _unbalance(machine: Machine) -> tuple[str, float]:
    """Return the path of the rotor's unbalance, and its value for 1 kg m. Raises ``InputError``."""
    name, values = machine.rotor.name, machine.values
    if f"{name}.unbalance" in values:
        return f"{name}.unbalance", 1.0
    if f"{name}.eccentricity" in values:
        return f"{name}.eccentricity", 1 / values[f"{name}.mass"]
    raise InputError("machine.bodies", name, "a main rotor with an unbalance or an eccentricity is required")


def _check_ends(trials: Trials) -> None:
    """Refuse an end of a range that the parts do not allow, all else unchanged. Raises ``InputError``."""
    for v in trials.variables:
        for end in (v.low, v.high):
            alone = replace(trials, variables=(v,))
            try:
                alone.of([end])
            except InputError as error:
                raise InputError(f"study.vary.{v.name}", end, error.allowed) from None


def _curve(trials: Trials) -> tuple[Trials, np.ndarray] | None:
    """Return trials with the damping of all bodies as the only variable, and the dampings (N,)."""
    machine, names = trials.machine, balancing(trials.machine)
    if any(f"{b}.damping" not in machine.values for b in names):
        return None
    asked = next((v for v in trials.variables if v.key == "damping" and len(v.paths) == len(names)), None)
    own = max(machine.values[f"{b}.damping"] for b in names)
    if asked is None and not own > 0:
        return None
    low, high = (own * 10**-_DECADES, own * 10**_DECADES) if asked is None else (asked.low, asked.high)
    if not low > 0:
        low = high * 10 ** (-2 * _DECADES)
    parameter = machine.parameters[f"{names[0]}.damping"]
    only = Variable("damping", "damping", tuple(f"{b}.damping" for b in names), low, high, parameter.unit, parameter.what)
    return replace(trials, variables=(only,)), np.geomspace(low, high, _CURVE)


_RUNS = 0.8  # of the progress; the rest are steady states
_OWN, _DAMPING, _SEARCH = 0.05, 0.15, 0.7  # shares of the work after each


@dataclass(frozen=True)
class Checked:
    """A candidate in the full equations. residual: the least of a stable state, at the worse end of the unbalances,
    nan: there is none, or it cannot be computed, for the ``reason``."""

    seen: Evaluated
    residual: float
    why: str = ""


@dataclass(frozen=True)
class Own:
    """The machine as it is, by the equations of the search and by the full ones."""

    seen: Evaluated
    checked: Checked


@dataclass(frozen=True)
class Point:
    """A point of the front: number of bodies, and the candidate as evaluated by the search."""

    bodies: int
    seen: Evaluated
    checked: Checked | None = None

    @property
    def numbers(self) -> np.ndarray:
        """Return the values of the variables (k,)."""
        return np.asarray(self.seen.numbers[0])


@dataclass(frozen=True)
class Findings:
    """The findings of a search.

    evaluated_generations: with their number of bodies. front: empty until the search is finished.
    """

    own: Own
    curve: DampingCurve | None = None
    tried: tuple[tuple[int, Evaluated], ...] = ()
    front: tuple[Point, ...] = ()
    found: int = 0


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings after each generation and each point of the front."""
    findings = Findings(_own(plan, work.part("as it is", 0.0, _OWN)))
    yield findings
    if plan.curve is not None:
        findings = replace(findings, curve=_followed_curve(plan, *plan.curve, work.part("curve", _OWN, _DAMPING)))
        yield findings
    for tried_ in _searched(plan, findings.own, work.part("search", _DAMPING, _SEARCH)):
        findings = replace(findings, tried=tried_)
        yield findings
    front, found = front_of(plan, findings)
    findings = replace(findings, front=front, found=found)
    yield findings
    checks = {f"{k}": partial(checked, plan.trials[p.bodies], p.numbers) for k, p in enumerate(front)}
    for name, seen in work.part("front", _SEARCH, 1.0).units(checks, "check with the full equations"):
        points = list(findings.front)
        points[int(name)] = replace(points[int(name)], checked=seen)
        findings = replace(findings, front=tuple(points))
        yield findings
    work.report(1.0)
    yield findings


def _own(plan: Plan, work: Work) -> Own:
    # Bodies that are not equal stay as they are: nothing is varied.
    as_it_is, none, what = replace(plan.as_it_is, variables=()), np.zeros(0), "the machine as it is"
    if plan.one_by_one:
        what = f"{plan.runs} run-ups at most, integrated one by one, which takes long"
    seen = tried(as_it_is, plan.spec.model, none[None], work.part("", 0.0, 0.5), what)
    ((_, check),) = work.part("", 0.5, 1.0).units({"full": partial(checked, as_it_is, none)}, what)
    return Own(seen, check)


def _followed_curve(plan: Plan, trials: Trials, dampings: np.ndarray, work: Work) -> DampingCurve:
    seen = tried(trials, plan.spec.model, dampings[:, None], work.part("", 0.0, _RUNS), "damping curve")
    return damping_curve(dampings, seen, work.unit("rates", partial(rates_of, trials, dampings)))


def checked(trials: Trials, numbers: np.ndarray, report: Report) -> Checked:
    """Check a candidate (k,) in the full equations, from other phases: the search has adapted it to those of its runs."""
    seen = evaluated(replace(trials, others=True), "full", numbers[None], part_of(report, 0.0, _RUNS))
    residuals, machine = list[float](), trials.of(numbers.tolist())
    for end in dict.fromkeys(trials.ends):
        try:
            state = compensated_state(machine.with_values({trials.unbalance: end}), full=True)
        except InputError as error:
            return Checked(seen, np.nan, error.allowed)
        residuals.append(np.nan if state is None or state.residual is None else state.residual)
    return Checked(seen, float(np.max(residuals)))


def _searched(plan: Plan, own: Own, work: Work) -> Iterator[tuple[tuple[int, Evaluated], ...]]:
    """Yield the generations so far, of one number of bodies after the other."""
    found: tuple[tuple[int, Evaluated], ...] = ()
    for place, (count, trials) in enumerate(plan.trials.items()):
        part = work.part(f"{count} bodies", place / len(plan.trials), (place + 1) / len(plan.trials))
        latest: list[Evaluated] = []

        def value(
            number: int, shares: np.ndarray, trials: Trials = trials, part: Work = part, latest: list[Evaluated] = latest
        ) -> tuple[np.ndarray, np.ndarray]:
            here = part.part(f"generation {number}", number / plan.generations, (number + 1) / plan.generations)
            numbers = np.stack([v.at(shares[:, k]) for k, v in enumerate(trials.variables)], axis=1)
            what = f"{bodies_in_words(len(balancing(trials.machine)))}, generation {number + 1} of {plan.generations}"
            seen = tried(trials, plan.spec.model, numbers, here, what)
            latest.append(seen)
            return seen.objectives[:, plan.asked], allowed(plan, seen, own)

        for _ in generations(plan.generations, _first(plan, count, trials), len(plan.asked), plan.spec.seed, value):
            found = (*found, (count, latest[-1]))
            yield found


def _first(plan: Plan, count: int, trials: Trials) -> np.ndarray:
    """Return the first generation (P, k): scrambled Sobol' points, and the machine as it is, where it lies in the ranges."""
    from scipy.stats import qmc

    size = plan.spec.population
    sobol = qmc.Sobol(len(trials.variables), scramble=True, rng=np.random.default_rng([plan.spec.seed, count]))
    shares = sobol.random(power_of_two(size))[:size]
    own = np.array([v.share(x) for v, x in zip(trials.variables, plan.numbers, strict=True)])
    if ((own >= 0) & (own <= 1)).all():
        shares[0] = own
    return np.asarray(shares)


def allowed(plan: Plan, seen: Evaluated, own: Own) -> np.ndarray:
    """True for eligible candidates (P,): where capture is no objective, they are not captured more often than the machine is,
    neither for certain nor with the runs without a verdict."""
    if CAPTURE in plan.asked:
        return seen.allowed
    more = (seen.captured > own.seen.captured[0]) | (seen.objectives[:, CAPTURE] > own.seen.objectives[0, CAPTURE])
    return np.asarray(seen.allowed & ~more)


def front_of(plan: Plan, findings: Findings) -> tuple[tuple[Point, ...], int]:
    """Return the front of all candidates, thinned evenly to the points to be checked, and its number of points."""
    points = [
        Point(count, seen.taken(int(i)))
        for count, seen in findings.tried
        for i in np.flatnonzero(allowed(plan, seen, findings.own) & np.isfinite(seen.objectives[:, plan.asked]).all(axis=1))
    ]
    if not points:
        return (), 0
    objectives = np.array([p.seen.objectives[0, plan.asked] for p in points])
    _, once = np.unique(objectives, axis=0, return_index=True)  # the first of those with equal objectives
    best = np.sort(once)[not_dominated(objectives[np.sort(once)])]
    chosen = best[spread_out(objectives[best], plan.spec.points)]
    order = sorted(chosen.tolist(), key=lambda k: tuple(objectives[k]))
    return tuple(points[k] for k in order), len(best)
