"""Plan -> findings: the candidates, the front, the curve over the damping, and the recommendation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.balancers.candidates import (
    CAPTURE,
    SETTLING,
    BalancerTrials,
    CandidateResults,
    SettlingRuns,
    evaluate_candidates,
    evaluate_runs,
    power_of_two,
    units_of_work,
)
from wucht.dynamics.balancers.damping_optimum import DampingCurve, compensated_state, damping_curve, decay_rates
from wucht.dynamics.balancers.recommendation import (
    CHECK_SAMPLES,
    CHECK_STREAM,
    BalancerMerit,
    Design,
    Recommendation,
    fresh_trials,
    recommend,
)
from wucht.dynamics.sampling.ensembles import Report, subprogress
from wucht.dynamics.sampling.searches import (
    Variable,
    balancer_names,
    generations,
    is_pareto_optimal,
    spread_selection,
)
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.results.formatting import bodies_in_words
from wucht.studies.optimise_balancer.balancer_plan import AS_IT_IS, CURVE, Plan, prepare

__all__ = ["Baseline", "Findings", "FrontPoint", "FullCheck", "Plan", "prepare", "run"]

_ENTRANTS = 3  # of the front, of the search, and of the damping curve, that compete for the recommendation
_SAME = 1e-9  # relative
_RUNS = 0.8  # of the progress; the rest are steady states
_RECOMMENDATION = 0.7  # the share of the work after which candidates are compared for the recommendation


def _shares(plan: Plan) -> tuple[float, float, float]:
    """Return the completed share of the work after the machine as it is, the damping curve, and the search.

    Each unit of work counts as much: a few runs take nearly as long as those that fill the batches.
    """
    generation = units_of_work(plan.spec.population, plan.spec.samples)
    search, curve = len(plan.trials) * plan.generations * generation, 0
    if plan.curve is not None:
        curve = units_of_work(len(plan.curve[1]), plan.spec.samples)
    candidates = len(plan.trials) * plan.generations * plan.spec.population
    sizes = np.cumsum([2, curve, search, min(plan.spec.points, candidates)])
    first, second, third, _ = (_RECOMMENDATION * sizes / sizes[-1]).tolist()
    return first, second, third


@dataclass(frozen=True)
class FullCheck:
    """A candidate in the full equations. residual: the least of a stable state, at the worse end of the unbalances,
    nan: there is none, or it cannot be computed, for the ``reason``. runs: of the candidate."""

    evaluation: CandidateResults
    residual: float
    reason: str = ""
    runs: SettlingRuns | None = None


@dataclass(frozen=True)
class Baseline:
    """The machine as it is, by the equations of the search and by the full ones."""

    evaluation: CandidateResults
    check: FullCheck


@dataclass(frozen=True)
class FrontPoint:
    """A point of the front: number of bodies, and the candidate as evaluated by the search. The recommended candidate is one,
    too, the last one if the search has not evaluated it."""

    bodies: int
    evaluation: CandidateResults
    check: FullCheck | None = None

    @property
    def numbers(self) -> np.ndarray:
        """Return the values of the variables (k,)."""
        return np.asarray(self.evaluation.numbers[0])


@dataclass(frozen=True)
class Findings:
    """The findings of a search.

    evaluated_generations: with their number of bodies. front: empty until the search is finished. recommendation: None until it
    is complete.
    """

    baseline: Baseline
    curve: DampingCurve | None = None
    evaluated_generations: tuple[tuple[int, CandidateResults], ...] = ()
    front: tuple[FrontPoint, ...] = ()
    front_size: int = 0
    recommendation: Recommendation | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings after each generation and each point of the front."""
    baseline, curve, search = _shares(plan)
    findings = Findings(_evaluate_baseline(plan, work.part("as it is", 0.0, baseline)))
    yield findings
    if plan.curve is not None:
        findings = replace(findings, curve=_follow_curve(plan, *plan.curve, work.part("curve", baseline, curve)))
        yield findings
    for evaluated_generations in _search_generations(plan, findings.baseline, work.part("search", curve, search)):
        findings = replace(findings, evaluated_generations=evaluated_generations)
        yield findings
    front, front_size = front_of(plan, findings)
    findings = replace(findings, front=front, front_size=front_size)
    yield findings
    checks = {f"{k}": partial(verify_candidate, plan.trials[p.bodies], p.numbers) for k, p in enumerate(front)}
    for name, check in work.part("front", search, _RECOMMENDATION).units(checks, "check with the full equations"):
        points = list(findings.front)
        points[int(name)] = replace(points[int(name)], check=check)
        findings = replace(findings, front=tuple(points))
        yield findings
    if front:
        findings = _recommend(plan, findings, work.part("recommendation ", _RECOMMENDATION, 1.0))
    work.report(1.0)
    yield findings


def present_design(plan: Plan) -> Design:
    """Return the machine as it is as a candidate, one of the search where its bodies are equal."""
    count, machine = len(balancer_names(plan.machine)), plan.machine
    if count not in plan.trials or not all(_have_same_values(machine, v) for v in plan.variables):
        return Design(AS_IT_IS, ())
    return Design(str(count), tuple(plan.numbers.tolist()))


def _have_same_values(machine: Machine, variable: Variable) -> bool:
    values = np.array([machine.values[path] for path in variable.paths])
    return bool(np.ptp(values) <= _SAME * np.abs(values).max())


def curve_designs(plan: Plan, curve: DampingCurve | None, present: Design) -> tuple[list[Design], Design | None]:
    """Return the dampings that settle fastest, the machine otherwise as it is, as candidates of the search; where damping is
    not varied, the fastest one alone, that is not."""
    if curve is None or not np.isfinite(curve.optimum):
        return [], None
    times = np.where(curve.share_through >= curve.share_through.max(), curve.settling_time, np.nan)
    best = [float(curve.damping[k]) for k in np.argsort(times)[:_ENTRANTS] if np.isfinite(times[k])]
    assert plan.curve is not None
    column = next((k for k, v in enumerate(plan.variables) if set(v.paths) == set(plan.curve[0].variables[0].paths)), None)
    if column is None:
        return [], Design(CURVE, (best[0],))
    if present.group == AS_IT_IS:
        return [], None
    numbers = [(*plan.numbers[:column].tolist(), b, *plan.numbers[column + 1 :].tolist()) for b in best]
    return [Design.of(present.group, n) for n in numbers], None


def _luckiest(plan: Plan, findings: Findings) -> list[Design]:
    """Return the best candidates by the search: the fewest failing runs, then the settling time, then the number of bodies."""
    results = [
        (count, evaluation.pick(int(k)))
        for count, evaluation in findings.evaluated_generations
        for k in np.flatnonzero(eligible_candidates(plan, evaluation, findings.baseline))
    ]

    def order(one: tuple[int, CandidateResults]) -> tuple[float, float, int]:
        count, result = one
        time = float(result.objectives[0, SETTLING])
        return BalancerMerit.of(count, time, result.outcomes[0]).most_failing, time if np.isfinite(time) else np.inf, count

    return [Design.of(str(count), result.numbers[0].tolist()) for count, result in sorted(results, key=order)[:_ENTRANTS]]


def _recommend(plan: Plan, findings: Findings, work: Work) -> Findings:
    """Choose the recommended candidate, and add it to the points of the front if it is none of them."""
    present, part = present_design(plan), work.part("", 0.0, 0.9)
    dampings, beside = curve_designs(plan, findings.curve, present)
    checks = {present: findings.baseline.check} | {_design(p): p.check for p in findings.front if p.check is not None}
    runs_of_check = {design: check.runs for design, check in checks.items() if check.runs is not None}
    entrants = _luckiest(plan, findings)
    recommendation = recommend(plan.groups, runs_of_check, entrants, dampings, present, beside, plan.spec.samples, part)
    findings = replace(findings, recommendation=recommendation)
    if recommendation.is_kept or recommended_point(findings) is not None:
        return findings
    bodies, numbers = int(recommendation.chosen.group), np.array(recommendation.chosen.numbers)
    trials, last = plan.trials[bodies], work.part("point ", 0.9, 1.0)
    evaluation = evaluate_candidates(trials, plan.spec.model, numbers[None], last.part("", 0.0, 0.5), "the recommended one")
    tasks = {"check": partial(verify_candidate, trials, numbers)}
    ((_, check),) = last.part("", 0.5, 1.0).units(tasks, "the recommended one")
    return replace(findings, front=(*findings.front, FrontPoint(bodies, evaluation, check)))


def recommended_point(findings: Findings) -> int | None:
    """Return the index of the recommended candidate in the front; None where it is none of its points."""
    if findings.recommendation is None:
        return None
    chosen = findings.recommendation.chosen
    return next((k for k, point in enumerate(findings.front) if _design(point) == chosen), None)


def _design(point: FrontPoint) -> Design:
    return Design.of(str(point.bodies), point.numbers.tolist())


def _evaluate_baseline(plan: Plan, work: Work) -> Baseline:
    # Bodies that are not equal stay as they are: nothing is varied.
    as_it_is, no_values, activity = replace(plan.as_it_is, variables=()), np.zeros(0), "the machine as it is"
    if plan.one_by_one:
        activity = f"{plan.runs} run-ups at most before the recommendation, integrated one by one, which takes long"
    evaluation = evaluate_candidates(as_it_is, plan.spec.model, no_values[None], work.part("", 0.0, 0.5), activity)
    ((_, check),) = work.part("", 0.5, 1.0).units({"full": partial(verify_candidate, as_it_is, no_values)}, activity)
    return Baseline(evaluation, check)


def _follow_curve(plan: Plan, trials: BalancerTrials, dampings: np.ndarray, work: Work) -> DampingCurve:
    evaluation = evaluate_candidates(trials, plan.spec.model, dampings[:, None], work.part("", 0.0, _RUNS), "damping curve")
    return damping_curve(dampings, evaluation, work.unit("rates", partial(decay_rates, trials, dampings)))


def verify_candidate(trials: BalancerTrials, numbers: np.ndarray, report: Report) -> FullCheck:
    """Check a candidate (k,) in the full equations, from other phases: the search has adapted it to those of its runs."""
    fresh = fresh_trials(trials, CHECK_SAMPLES * trials.settings.samples, CHECK_STREAM)
    evaluation, runs = evaluate_runs(fresh, "full", numbers[None], subprogress(report, 0.0, _RUNS))
    residuals, machine = list[float](), trials.candidate_machine(numbers.tolist())
    for end in dict.fromkeys(trials.ends):
        try:
            state = compensated_state(machine.with_values({trials.unbalance: end}), full=True)
        except InputError as error:
            return FullCheck(evaluation, np.nan, error.explanation, runs)
        residuals.append(np.nan if state is None or state.residual is None else state.residual)
    return FullCheck(evaluation, float(np.max(residuals)), runs=runs)


def _search_generations(plan: Plan, baseline: Baseline, work: Work) -> Iterator[tuple[tuple[int, CandidateResults], ...]]:
    """Yield the generations so far, of one number of bodies after the other."""
    evaluated_generations: tuple[tuple[int, CandidateResults], ...] = ()
    for place, (count, trials) in enumerate(plan.trials.items()):
        part = work.part(f"{count} bodies", place / len(plan.trials), (place + 1) / len(plan.trials))
        latest: list[CandidateResults] = []

        def value(
            number: int,
            shares: np.ndarray,
            trials: BalancerTrials = trials,
            part: Work = part,
            latest: list[CandidateResults] = latest,
        ) -> tuple[np.ndarray, np.ndarray]:
            here = part.part(f"generation {number}", number / plan.generations, (number + 1) / plan.generations)
            numbers = np.stack([v.value_at(shares[:, k]) for k, v in enumerate(trials.variables)], axis=1)
            activity = f"{bodies_in_words(len(balancer_names(trials.machine)))}, generation {number + 1} of {plan.generations}"
            evaluation = evaluate_candidates(trials, plan.spec.model, numbers, here, activity)
            latest.append(evaluation)
            return evaluation.objectives[:, plan.objective_columns], eligible_candidates(plan, evaluation, baseline)

        for _ in generations(
            plan.generations, _first_generation(plan, count, trials), len(plan.objective_columns), plan.spec.seed, value
        ):
            evaluated_generations = (*evaluated_generations, (count, latest[-1]))
            yield evaluated_generations


def _first_generation(plan: Plan, count: int, trials: BalancerTrials) -> np.ndarray:
    """Return the first generation (P, k): scrambled Sobol' points, and the machine as it is, where it lies in the ranges."""
    from scipy.stats import qmc

    size = plan.spec.population
    sobol = qmc.Sobol(len(trials.variables), scramble=True, rng=np.random.default_rng([plan.spec.seed, count]))
    shares = sobol.random(power_of_two(size))[:size]
    machine_shares = np.array([v.share(x) for v, x in zip(trials.variables, plan.numbers, strict=True)])
    if ((machine_shares >= 0) & (machine_shares <= 1)).all():
        shares[0] = machine_shares
    return np.asarray(shares)


def eligible_candidates(plan: Plan, evaluation: CandidateResults, baseline: Baseline) -> np.ndarray:
    """True for eligible candidates (P,): where capture is no objective, they are not captured more often than the machine is,
    neither for certain nor with the runs without a verdict."""
    if CAPTURE in plan.objective_columns:
        return evaluation.is_allowed
    more = (evaluation.captured_share > baseline.evaluation.captured_share[0]) | (
        evaluation.objectives[:, CAPTURE] > baseline.evaluation.objectives[0, CAPTURE]
    )
    return np.asarray(evaluation.is_allowed & ~more)


def front_of(plan: Plan, findings: Findings) -> tuple[tuple[FrontPoint, ...], int]:
    """Return the front of all candidates, thinned evenly to the points to be checked, and its number of points."""
    points = [
        FrontPoint(count, evaluation.pick(int(i)))
        for count, evaluation in findings.evaluated_generations
        for i in np.flatnonzero(
            eligible_candidates(plan, evaluation, findings.baseline)
            & np.isfinite(evaluation.objectives[:, plan.objective_columns]).all(axis=1)
        )
    ]
    if not points:
        return (), 0
    objectives = np.array([p.evaluation.objectives[0, plan.objective_columns] for p in points])
    _, once = np.unique(objectives, axis=0, return_index=True)  # the first of those with equal objectives
    best = np.sort(once)[is_pareto_optimal(objectives[np.sort(once)])]
    front_indices = best[spread_selection(objectives[best], plan.spec.points)]
    order = sorted(front_indices.tolist(), key=lambda k: tuple(objectives[k]))
    return tuple(points[k] for k in order), len(best)
