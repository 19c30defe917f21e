"""Plan -> findings: the machine as it is, the generations of the search, the points of the front in the full equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.errors import InputError
from wucht.studies.optimise_balancer.candidates import Evaluated, Trials, evaluated
from wucht.studies.optimise_balancer.damping_optimum import DampingCurve, damping_curve
from wucht.studies.optimise_balancer.pareto_search import generations, not_dominated, spread_out
from wucht.studies.optimise_balancer.prepare import Plan
from wucht.studies.optimise_balancer.spec import OBJECTIVES
from wucht.studies.optimise_balancer.standing_states import standing
from wucht.studies.work import Work

CAPTURE = OBJECTIVES.index("capture-probability")
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
    """A point of the front: number of bodies, values of the variables (k,), objectives (4,), outcomes (o,)."""

    bodies: int
    numbers: np.ndarray
    objectives: np.ndarray
    outcomes: np.ndarray
    checked: Checked | None = None


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
    findings = Findings(work.unit("as it is", partial(_own, plan, work.part("", 0.0, _OWN))))
    yield findings
    if plan.curve is not None:
        trials, dampings = plan.curve
        part = work.part("", _OWN, _CURVE)
        slow = plan.model == "slow"
        curve = work.unit("damping", lambda: damping_curve(trials, dampings, slow, lambda s: part.report(s, "damping curve")))
        findings = replace(findings, curve=curve)
        yield findings
    for tried in _searched(plan, findings.own, work.part("search", _CURVE, _SEARCH)):
        findings = replace(findings, tried=tried)
        yield findings
    front, found = front_of(plan, findings)
    findings = replace(findings, front=front, found=found)
    yield findings
    part = work.part("front", _SEARCH, 1.0)
    for k, point in enumerate(front):
        here = part.part(f"{k}", k / len(front), (k + 1) / len(front))
        trials = plan.trials[point.bodies]
        checked = here.unit("full", partial(_checked, plan, trials, point.numbers, here))
        findings = replace(findings, front=(*findings.front[:k], replace(point, checked=checked), *findings.front[k + 1 :]))
        yield findings
    work.report(1.0)
    yield findings


def _own(plan: Plan, work: Work) -> Own:
    # Bodies that are not equal stay as they are: nothing is varied.
    as_it_is, none = replace(plan.as_it_is, variables=()), np.zeros(0)
    seen = evaluated(as_it_is, plan.model, none[None], lambda s: work.report(s / 2, "the machine as it is"))
    return Own(seen, _checked(plan, as_it_is, none, work.part("", 0.5, 1.0), seen if plan.model == "full" else None))


def _checked(plan: Plan, trials: Trials, numbers: np.ndarray, work: Work, known: Evaluated | None = None) -> Checked:
    """A candidate (k,) in the full equations."""
    work.report(0.0, "full equations")
    seen = known or evaluated(trials, "full", numbers[None], lambda s: work.report(0.8 * s, "full equations"))
    residuals, machine = list[float](), trials.of(numbers.tolist())
    for end in dict.fromkeys(trials.ends):
        try:
            state = standing(machine.with_values({trials.unbalance: end}), full=True)
        except InputError as error:
            return Checked(seen, np.nan, error.allowed)
        residuals.append(np.nan if state is None or state.residual is None else state.residual)
    return Checked(seen, float(np.max(residuals)))


def _searched(plan: Plan, own: Own, work: Work) -> Iterator[tuple[tuple[int, Evaluated], ...]]:
    """The generations so far, of one number of bodies after the other."""
    tried: tuple[tuple[int, Evaluated], ...] = ()
    for place, (count, trials) in enumerate(plan.trials.items()):
        part = work.part(f"{count} bodies", place / len(plan.trials), (place + 1) / len(plan.trials))
        latest: list[Evaluated] = []

        def value(
            number: int, shares: np.ndarray, trials: Trials = trials, part: Work = part, latest: list[Evaluated] = latest
        ) -> tuple[np.ndarray, np.ndarray]:
            here = part.part("", number / plan.generations, (number + 1) / plan.generations)
            numbers = np.stack([v.at(shares[:, k]) for k, v in enumerate(trials.variables)], axis=1)
            what = (
                f"{len(trials.machine.group(trials.machine.rotor)) - 1} bodies, generation {number + 1} of {plan.generations}"
            )
            here.report(0.0, what)
            tell = lambda share: here.report(share, what)  # noqa: E731
            seen = part.unit(f"generation {number}", lambda: evaluated(trials, plan.model, numbers, tell))
            latest.append(seen)
            return seen.objectives[:, plan.asked], allowed(plan, seen, own)

        for _ in generations(plan.generations, _first(plan, count, trials), len(plan.asked), plan.spec.seed, value):
            tried = (*tried, (count, latest[-1]))
            yield tried


def _first(plan: Plan, count: int, trials: Trials) -> np.ndarray:
    """The first generation (P, k): scrambled Sobol' points, and the machine as it is, where it lies in the ranges."""
    from scipy.stats import qmc

    size = plan.spec.population
    sobol = qmc.Sobol(len(trials.variables), scramble=True, rng=np.random.default_rng([plan.spec.seed, count]))
    shares = sobol.random(1 << (size - 1).bit_length())[:size]
    own = np.array([v.share(x) for v, x in zip(trials.variables, plan.numbers, strict=True)])
    if ((own >= 0) & (own <= 1)).all():
        shares[0] = own
    return np.asarray(shares)


def allowed(plan: Plan, seen: Evaluated, own: Own) -> np.ndarray:
    """Which candidates (P,) count: where capture is no objective, none may be captured more often than the machine as it is."""
    if CAPTURE in plan.asked:
        return seen.allowed
    return np.asarray(seen.allowed & (seen.objectives[:, CAPTURE] <= own.seen.objectives[0, CAPTURE]))


def front_of(plan: Plan, findings: Findings) -> tuple[tuple[Point, ...], int]:
    """The front of all candidates that were tried, spread out to as many points as are checked; and how many it has."""
    points = [
        Point(count, seen.numbers[i], seen.objectives[i], seen.outcomes[i])
        for count, seen in findings.tried
        for i in np.flatnonzero(allowed(plan, seen, findings.own) & np.isfinite(seen.objectives[:, plan.asked]).all(axis=1))
    ]
    if not points:
        return (), 0
    objectives = np.array([p.objectives[plan.asked] for p in points])
    _, once = np.unique(objectives, axis=0, return_index=True)  # of those that are the same in all, the first
    best = np.sort(once)[not_dominated(objectives[np.sort(once)])]
    chosen = best[spread_out(objectives[best], plan.spec.points)]
    order = sorted(chosen.tolist(), key=lambda k: tuple(objectives[k]))
    return tuple(points[k] for k in order), len(best)
