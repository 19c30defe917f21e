"""Plan -> findings: the machine as it is, the generations of the search, the points of the front in the full equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.balancers.candidates import CAPTURE, Evaluated, Trials, evaluated, power_of_two, tried
from wucht.dynamics.balancers.compensated_states import compensated_state
from wucht.dynamics.balancers.damping_optimum import DampingCurve, damping_curve, rates_of
from wucht.dynamics.sampling.ensemble_question import Report, part_of
from wucht.dynamics.sampling.pareto_search import generations, not_dominated, spread_out
from wucht.dynamics.sampling.search_variables import balancing
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.results.formatting import bodies_in_words
from wucht.studies.optimise_balancer.prepare import Plan

_RUNS = 0.8  # of the progress; the rest are steady states
_OWN, _CURVE, _SEARCH = 0.05, 0.15, 0.7  # shares of the work after each


@dataclass(frozen=True)
class Checked:
    """A candidate in the full equations. residual: of the stable state that leaves least, at the worse end of the unbalances,
    nan: none was found, or it cannot be asked, which ``why`` says."""

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
    """A point of the front: number of bodies, and the candidate as the search has it."""

    bodies: int
    seen: Evaluated
    checked: Checked | None = None

    @property
    def numbers(self) -> np.ndarray:
        """The values of the variables (k,)."""
        return np.asarray(self.seen.numbers[0])


@dataclass(frozen=True)
class Findings:
    """tried: generations with their number of bodies. front: empty until the search is finished."""

    own: Own
    curve: DampingCurve | None = None
    tried: tuple[tuple[int, Evaluated], ...] = ()
    front: tuple[Point, ...] = ()
    found: int = 0


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """What is found, after each generation and each point of the front."""
    findings = Findings(_own(plan, work.part("as it is", 0.0, _OWN)))
    yield findings
    if plan.curve is not None:
        findings = replace(findings, curve=_curve(plan, *plan.curve, work.part("curve", _OWN, _CURVE)))
        yield findings
    for tried_ in _searched(plan, findings.own, work.part("search", _CURVE, _SEARCH)):
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
        what = f"{plan.runs} run-ups at most, one by one, which takes long"
    seen = tried(as_it_is, plan.spec.model, none[None], work.part("", 0.0, 0.5), what)
    ((_, check),) = work.part("", 0.5, 1.0).units({"full": partial(checked, as_it_is, none)}, what)
    return Own(seen, check)


def _curve(plan: Plan, trials: Trials, dampings: np.ndarray, work: Work) -> DampingCurve:
    seen = tried(trials, plan.spec.model, dampings[:, None], work.part("", 0.0, _RUNS), "damping curve")
    return damping_curve(dampings, seen, work.unit("rates", partial(rates_of, trials, dampings)))


def checked(trials: Trials, numbers: np.ndarray, report: Report) -> Checked:
    """A candidate (k,) in the full equations, from other phases: the search has chosen what suits its own."""
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
    """The generations so far, of one number of bodies after the other."""
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
    """The first generation (P, k): scrambled Sobol' points, and the machine as it is, where it lies in the ranges."""
    from scipy.stats import qmc

    size = plan.spec.population
    sobol = qmc.Sobol(len(trials.variables), scramble=True, rng=np.random.default_rng([plan.spec.seed, count]))
    shares = sobol.random(power_of_two(size))[:size]
    own = np.array([v.share(x) for v, x in zip(trials.variables, plan.numbers, strict=True)])
    if ((own >= 0) & (own <= 1)).all():
        shares[0] = own
    return np.asarray(shares)


def allowed(plan: Plan, seen: Evaluated, own: Own) -> np.ndarray:
    """Which candidates (P,) count: where capture is no objective, none may be captured more often than the machine as it is,
    neither for certain nor with the runs that have no verdict."""
    if CAPTURE in plan.asked:
        return seen.allowed
    more = (seen.captured > own.seen.captured[0]) | (seen.objectives[:, CAPTURE] > own.seen.objectives[0, CAPTURE])
    return np.asarray(seen.allowed & ~more)


def front_of(plan: Plan, findings: Findings) -> tuple[tuple[Point, ...], int]:
    """The front of all candidates that were tried, spread out to as many points as are checked; and how many it has."""
    points = [
        Point(count, seen.taken(int(i)))
        for count, seen in findings.tried
        for i in np.flatnonzero(allowed(plan, seen, findings.own) & np.isfinite(seen.objectives[:, plan.asked]).all(axis=1))
    ]
    if not points:
        return (), 0
    objectives = np.array([p.seen.objectives[0, plan.asked] for p in points])
    _, once = np.unique(objectives, axis=0, return_index=True)  # of those that are the same in all, the first
    best = np.sort(once)[not_dominated(objectives[np.sort(once)])]
    chosen = best[spread_out(objectives[best], plan.spec.points)]
    order = sorted(chosen.tolist(), key=lambda k: tuple(objectives[k]))
    return tuple(points[k] for k in order), len(best)
