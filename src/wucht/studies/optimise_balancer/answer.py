"""The answer of a search for the best balancer: the present machine, the recommendation, the front, and the damping curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from wucht.dynamics.balancers.balancer_candidate import BalancerCandidate
from wucht.dynamics.balancers.balancer_search import BalancerSearch, Evaluations
from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, CandidateResults
from wucht.dynamics.balancers.damping_optimum import DampingCurve
from wucht.dynamics.balancers.recommendation import CHECK_SAMPLES, Recommendation
from wucht.dynamics.sampling.ensemble_run import integration_note
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.results.formatting import number_text, percent
from wucht.studies.answer import Answer, Column
from wucht.studies.optimise_balancer.recommendation_answer import (
    design_in_words,
    finite_or_none,
    parameters_by_name,
    state_recommendation,
)

Objective = Literal["settling-time", "residual", "peak", "capture-probability"]
OBJECTIVES: tuple[Objective, ...] = get_args(Objective)  # in the order of their columns
_HEADINGS = ("min settling", "min residual", "min peak", "min capture")
_GAIN = 0.005  # relative: smaller changes from the present machine are not worth a word
_UNDECIDED_SHARE = "share of runs without a verdict"


def state_search(
    a: Answer,
    search: BalancerSearch,
    unbalance: tuple[float, float],
    doubts: Sequence[str],
    as_it_is: BalancerCandidate,
    curve: DampingCurve | None = None,
    evaluations: Evaluations = (),
    front: Sequence[BalancerCandidate] = (),
    front_size: int = 0,
    recommendation: Recommendation | None = None,
) -> None:
    """State what is known of a search.

    unbalance: ends of the rotor's, in kg m. doubts: about averaged equations and the question. front: empty until the search is
    finished; front_size: its points, of which some are checked. recommendation: None until it is complete.
    """
    a.warn(*doubts)
    results = CandidateResults.join(
        [CandidateResults.unknown(0, len(search.variables), search.as_it_is.samples), *(one for _, one in evaluations)]
    )
    count = len(results.numbers)
    _state_question(a, search, unbalance, count)
    with a.group("as_it_is", "present machine"):
        for name, ((value,), what) in _columns(search, [as_it_is]).items():
            a.number(name, value, what)
    a.line("present", _candidate_in_words(search, as_it_is))
    clause = state_recommendation(a, search, curve, front, recommendation)
    holds = search.is_confirmed(front)
    a.number("found", front_size, "number of points of the front")
    _state_front(a, search, front, holds)
    _state_best_points(a, search, as_it_is, front)
    _warn_of_deviations(a, search, front, max(unbalance))
    words, bodies = _units_in_words(search), np.array([n for n, one in evaluations for _ in one.numbers], int)
    a.curve("tried_value", results.numbers, "values, in SI", "", "candidate variable")
    a.curve("tried_bodies", bodies, "number of bodies", "", "candidate")
    a.curve("tried_objective", results.objectives, words, "", "candidate objective")
    a.curve("tried_undecided", results.undecided_share, _UNDECIDED_SHARE, "", "candidate")
    a.curve("own_objective", as_it_is.evaluation.objectives[0], f"present machine, by the search: {words}", "", "objective")
    a.curve("own_checked", as_it_is.checked_objectives, f"present machine, by the check: {words}", "", "objective")
    _state_damping(a, search, curve)
    integration = integration_note(search.as_it_is.question(search.model))
    a.line("integrated", a.number("integration", integration, "way of integration"))
    _warn_of_undecided_runs(a, search, np.r_[as_it_is.evaluation.undecided_share, results.undecided_share])
    if front and len(front) < front_size:
        a.warn(f"{len(front)} points, spread over the front, represent its {front_size}")
    if not front and count and count >= search.candidates:
        a.warn("no candidate has all objectives: all its runs are captured, or the parts do not allow it; try other ranges")
    if not front:
        a.sentence = "no candidate has all objectives" if count else "there is no front yet"
        return
    points, checks = "1 point" if front_size == 1 else f"{front_size} points", sum(p.check is not None for p in front)
    verdicts = f"{holds.sum()} of {checks} checked points are confirmed"
    a.sentence = "; ".join(filter(None, [clause, f"a front of {points} from {count} candidates", verdicts]))


def _units(search: BalancerSearch) -> dict[str, str]:
    """Return the units of the objectives."""
    return dict(zip(OBJECTIVES, (search.machine.units.time, "kg m", search.machine.orbit_unit, ""), strict=True))


def _units_in_words(search: BalancerSearch) -> str:
    return ", ".join(f"{objective} in {unit or 1}" for objective, unit in _units(search).items())


def _state_question(a: Answer, search: BalancerSearch, unbalance: tuple[float, float], count: int) -> None:
    """State the objectives, the variables, and the runs. count: of the candidates so far."""
    variables, trials, samples = search.variables, search.as_it_is, search.as_it_is.samples
    a.curve("objective", np.array(OBJECTIVES, str), "objective")
    a.curve("variable", np.array([v.name for v in variables], str), "variable")
    a.curve("outcome", np.array(OUTCOMES, str), "outcome")
    a.number("candidates", count, "number of evaluated candidates")
    a.number("objectives", [OBJECTIVES[k] for k in search.objectives], "objectives of the search")
    a.number("units", _units(search), "units of the objectives")
    a.number("model", search.model, "equations of the search")
    a.number(
        "variables", {v.name: {"paths": list(v.paths), "range": [v.low, v.high], "unit": v.unit} for v in variables},
        "variables, with their ranges", parts={v.name: (v.name, v.unit) for v in variables},
    )  # fmt: skip
    a.number("numbers_of_bodies", list(search.trials), "numbers of bodies in the search")
    ends = [end / trials.ends[0] * unbalance[0] for end in trials.ends]
    a.number("unbalance", ends, "least and greatest unbalance of the rotor", "kg m")
    a.number("samples", samples, "number of runs of a candidate")
    a.number("runs", search.runs, "number of runs before the recommendation, at most")
    unbalance_text = " to ".join(dict.fromkeys(f"{end:.4g}" for end in ends))
    equations = "evaluated with the averaged equations" if search.model == "slow" else "evaluated with the full equations"
    runs = f"{samples} runs each from random phases, unbalance {unbalance_text} kg m"
    a.line("searched", f"{count} candidates, {runs}; {equations}")


def _columns(search: BalancerSearch, candidates: Sequence[BalancerCandidate]) -> dict[str, Column]:
    """Return the columns of candidates: objectives by the search and by the check, shares of runs without a verdict."""
    checks = [candidate.check for candidate in candidates]
    return {
        "bodies": ([c.bodies for c in candidates], "number of bodies"),
        "parameters": ([parameters_by_name(search, c.numbers) for c in candidates], "parameters"),
        "objectives": ([_objectives_by_name(c.evaluation.objectives[0]) for c in candidates], "objectives by the search"),
        "undecided": ([float(c.evaluation.undecided_share[0]) for c in candidates], _UNDECIDED_SHARE),
        "checked": ([None if c is None else _objectives_by_name(c.objectives[0]) for c in checks], "objectives by the check"),
        "checked_undecided": (
            [None if c is None else float(c.undecided_share[0]) for c in checks],
            f"{_UNDECIDED_SHARE}, by the check",
        ),
        "fails": ([c.most_failing for c in candidates], "share of runs that do not end compensated"),
        "balances": ([c.balances for c in candidates], "whether more than half of the runs end compensated"),
    }  # fmt: skip


def _objectives_by_name(objectives: np.ndarray) -> dict[str, float | None]:
    return dict(zip(OBJECTIVES, map(finite_or_none, objectives), strict=True))


def _state_front(a: Answer, search: BalancerSearch, front: Sequence[BalancerCandidate], holds: np.ndarray) -> None:
    """State the front by the search and by the check. holds: points (N,) that no other checked one dominates."""
    words, dimensions = _units_in_words(search), "point objective"
    verdicts = [None if p.check is None else bool(h) for p, h in zip(front, holds, strict=True)]
    columns = _columns(search, front) | {"holds": (verdicts, "whether no other checked point dominates it")}
    a.table_of("front", "points of the front", columns)
    samples, k = search.as_it_is.samples, len(search.variables)
    results = CandidateResults.join([CandidateResults.unknown(0, k, samples), *(p.evaluation for p in front)])
    no_rows, unknown_row = (CandidateResults.unknown(count, k, CHECK_SAMPLES * samples) for count in (0, 1))
    check = CandidateResults.join([no_rows, *(unknown_row if p.check is None else p.check for p in front)])
    a.curve("front_value", results.numbers, "values, in SI", "", "point variable")
    a.curve("front_bodies", np.array([p.bodies for p in front], int), "number of bodies", "", "point")
    a.curve("front_objective", results.objectives, f"by the search: {words}", "", dimensions)
    a.curve("front_checked", check.objectives, f"by the check: {words}", "", dimensions)
    a.curve("front_outcome", results.outcomes, "share of the runs", "", "point outcome")
    a.curve("front_checked_outcome", check.outcomes, "share, by the check", "", "point outcome")
    a.curve("front_undecided", results.undecided_share, _UNDECIDED_SHARE, "", "point")
    a.curve("front_checked_undecided", check.undecided_share, f"{_UNDECIDED_SHARE}, by the check", "", "point")
    a.curve("front_holds", holds.astype(np.int8), "not dominated by the check", "", "point")


def _state_best_points(
    a: Answer, search: BalancerSearch, as_it_is: BalancerCandidate, front: Sequence[BalancerCandidate]
) -> None:
    """State the best point in each objective; one that is the best in several is told once."""
    best_points = {column: search.best_point(front, column) for column in search.objectives}
    for column, k in best_points.items():
        if k is not None and column == next(first for first, place in best_points.items() if place == k):
            a.line(_HEADINGS[column], f"{_candidate_in_words(search, front[k])}{_gain(search, front[k], as_it_is)}")


def _candidate_in_words(search: BalancerSearch, candidate: BalancerCandidate) -> str:
    """Return a candidate with its objectives, by the check where there is one."""
    units, undecided_share = _units(search), float(candidate.results.undecided_share[0])
    least = "at least " if undecided_share else ""
    settling_time, residual, peak, capture = candidate.objectives.tolist()
    words = {
        SETTLING: f"median settling time {least}{settling_time:.3g} {units['settling-time']}",
        RESIDUAL: f"{residual:.3g} {units['residual']} residual unbalance",
        PEAK: f"peak {number_text(peak, 'm', '', search.machine.dimensionless)}",
        CAPTURE: f"{_capture_in_words(capture, undecided_share)} captured",
    }
    clauses = [words[k] for k in search.objectives if np.isfinite(candidate.objectives[k])] or ["no objective is known"]
    clauses += [] if candidate.balances else ["does not balance"]
    design = design_in_words(search, candidate.bodies, parameters_by_name(search, candidate.numbers))
    return f"{design}: {', '.join(clauses)}"


def _capture_in_words(most: float, undecided_share: float) -> str:
    if not undecided_share:
        return percent(most)
    return f"{percent(max(most - undecided_share, 0.0))} to {percent(most)} (the rest without a verdict)"


def _gain(search: BalancerSearch, candidate: BalancerCandidate, as_it_is: BalancerCandidate) -> str:
    """Return the relative changes from the present machine."""
    ours, before, words = _objectives_by_name(candidate.objectives), _objectives_by_name(as_it_is.objectives), list[str]()
    for column, noun in ((SETTLING, "time"), (RESIDUAL, "residual unbalance"), (PEAK, "peak")):
        new, old = ours[OBJECTIVES[column]], before[OBJECTIVES[column]]
        if column in search.objectives and new is not None and old:
            change = new / old - 1
            words += [f"{noun} {'-' if change < 0 else '+'}{100 * abs(change):.0f} %"] if abs(change) >= _GAIN else []
    if RESIDUAL in search.objectives and before["residual"] == 0 and ours["residual"]:
        words.append("residual unbalance where there was none")
    return f" ({', '.join(words)})" if words else ""


def _warn_of_deviations(a: Answer, search: BalancerSearch, front: Sequence[BalancerCandidate], unbalance: float) -> None:
    """Warn of objectives in which the check differs from the search by more than chance. unbalance: the greatest, in kg m."""
    samples = search.as_it_is.samples
    off = {k: p.deviations(unbalance, samples) for k, p in enumerate(front) if p.check is not None and not p.doubt}
    for column in search.objectives:
        if not (deviating := [k for k, deviations in off.items() if deviations[column] > 1]):
            continue
        name, unit = OBJECTIVES[column], _units(search)[OBJECTIVES[column]]
        worst = max(deviating, key=lambda k: float(off[k][column]))
        by_search, by_check = front[worst].evaluation.objectives[0, column], front[worst].objectives[column]
        check_text = f"{by_check:.4g} {unit}".rstrip() if np.isfinite(by_check) else "none"
        numbers = f"at point {worst + 1} {by_search:.4g} {unit}".rstrip() + f" by the search, {check_text} by the check"
        places = f"at {len(deviating)} of {len(off)} points"
        a.warn(f"the full equations, from other phases, give another {name} {places}: {numbers}")
    if reason := next((p.doubt for p in front if p.doubt), ""):
        a.warn(f"the residual unbalance is not checked with the full equations: {reason}")


def _warn_of_undecided_runs(a: Answer, search: BalancerSearch, shares: np.ndarray) -> None:
    """Warn of runs without a verdict. shares: of those of the present machine, and of each candidate."""
    if not shares.any():
        return
    consequence = "the stated settling time is a lower bound, the capture probability an upper one"
    is_limited = search.as_it_is.until is not None
    longer = "; a longer study.until may decide" if is_limited else "; a smaller study.tolerance may decide"
    count = int((shares > 0).sum())
    subject = "1 candidate has" if count == 1 else f"{count} candidates have"
    a.warn(f"{subject} runs without a verdict, up to {percent(shares.max())}: {consequence}{longer}")


def _state_damping(a: Answer, search: BalancerSearch, curve: DampingCurve | None) -> None:
    """State the damping curve, and its optimum."""
    if curve is None or search.curve is None:
        a.number("damping", None, "best damping of the bodies")
        return
    unit, ends = search.curve[0].variables[0].unit, [float(curve.damping[k]) for k in (0, -1)]
    with a.group("damping", "best damping of the bodies"):
        optimum = a.number("optimum", finite_or_none(curve.optimum), "damping of the shortest settling time", unit)
        of_rates = a.number("of_rates", finite_or_none(curve.rate_optimum), "damping of the greatest rate of decay", unit)
        what = "whether the share of captured runs is the same with each damping"
        is_alike = a.number("as_many", bool(np.ptp(curve.share_through) == 0), what)
        a.number("range", ends, "least and greatest damping", unit)
        a.number("unit", unit, "unit of the damping")
    a.curve("damping", curve.damping, "damping of the bodies", unit)
    a.curve("settling_time", curve.settling_time, "median settling time", "time", "damping")
    a.curve("through", curve.share_through, "share of the runs that pass", "", "damping")
    a.curve("decay_rate", curve.rate, "slowest rate of decay, linearised", "1/time", "damping")
    text = "of the present machine, {damping.optimum:.3g} settles fastest from random phases"
    text += "" if is_alike else ", of those with the fewest captured runs"
    if optimum in ends:
        text += f", the {'lowest' if optimum == ends[0] else 'highest'} of the curve"
    a.line("damping", text if of_rates is None else text + "; small deviations decay fastest with {damping.of_rates:.3g}")
