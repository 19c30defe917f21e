"""Findings -> the Dataset of a search: the front and its check by the full equations, all candidates, the damping curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, CandidateResults
from wucht.dynamics.balancers.damping_optimum import DampingCurve
from wucht.dynamics.balancers.recommendation import CHECK_SAMPLES, BalancerMerit
from wucht.dynamics.sampling.searches import balancer_names, is_pareto_optimal
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.extending_0_1 import result_dataset
from wucht.results.formatting import percent
from wucht.results.quantities import Quantity
from wucht.studies.optimise_balancer.balancer_plan import Plan
from wucht.studies.optimise_balancer.computation import Findings, FullCheck
from wucht.studies.optimise_balancer.recommendation_rows import (
    recommendation_quantities,
    recommendation_sentence,
    recommendation_warnings,
    recommended_row,
)
from wucht.studies.optimise_balancer.spec import OBJECTIVES

if TYPE_CHECKING:
    import xarray as xr

_FAR = 0.1  # relative: times that differ by more cause a warning, if chance does not explain it
_PEAK = 0.2  # likewise; the largest of few
_RESIDUAL = 0.01  # of the greatest unbalance
_UNDECIDED_LABEL = "share of runs without a verdict"
_PARTS = {
    "bodies": ("number of bodies", ""),
    "parameters": ("parameters", ""),
    "objectives": ("objectives by the search", ""),
    "undecided": (_UNDECIDED_LABEL, ""),
    "checked": ("objectives by the check", ""),
    "checked_undecided": (f"{_UNDECIDED_LABEL}, by the check", ""),
    "fails": ("share of runs that do not end compensated", ""),
    "balances": ("whether more than half of the runs end compensated", ""),
}
_CHANCE = 2.6  # standard deviations: a hundredth of what chance does


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a search."""
    front = findings.front
    check_objectives = np.array([_check_numbers(p.check) for p in front]).reshape(len(front), len(OBJECTIVES))
    holds = _holds(plan, check_objectives)
    quantities = [
        *recommendation_quantities(plan, findings),
        *_front_quantities(plan, findings, check_objectives, holds),
        *_candidate_quantities(plan, findings),
        *_baseline_quantities(plan, findings),
        *_question_quantities(plan),
        *_damping_quantities(plan, findings.curve),
    ]
    return result_dataset(quantities, _sentence(plan, findings, holds), _warnings(plan, findings, check_objectives))


def _front_quantities(plan: Plan, findings: Findings, check_objectives: np.ndarray, holds: np.ndarray) -> list[Quantity]:
    """Return the front by the search and by the check; runs without a verdict may lower the capture probability."""
    front, width, words = findings.front, len(plan.variables), _objective_units(plan)
    search, check = [p.evaluation for p in front], [None if p.check is None else p.check.evaluation for p in front]
    values, bodies = _stack_attribute(search, "numbers", width), np.array([p.bodies for p in front], int)
    objectives, dimensions = _stack_attribute(search, "objectives", len(OBJECTIVES)), "point objective"
    outcomes, outcomes_of_check = (_stack_attribute(c, "outcomes", len(OUTCOMES)) for c in (search, check))
    rows = [
        _candidate_entry(plan, p.bodies, p.numbers, p.evaluation, p.check) | {"holds": None if p.check is None else bool(h)}
        for p, h in zip(front, holds, strict=True)
    ]
    parts = _PARTS | {"holds": ("whether no other checked point dominates it", "")}
    return [
        Quantity("front", rows, "points of the front", parts=parts),
        Quantity("found", findings.front_size, "number of points of the front"),
        Quantity("front_value", values, "values, in SI", "", "point variable"),
        Quantity("front_bodies", bodies, "number of bodies", "", "point"),
        Quantity("front_objective", objectives, f"by the search: {words}", "", dimensions),
        Quantity("front_checked", check_objectives, f"by the check: {words}", "", dimensions),
        Quantity("front_outcome", outcomes, "share of the runs", "", "point outcome"),
        Quantity("front_checked_outcome", outcomes_of_check, "share, by the check", "", "point outcome"),
        Quantity("front_undecided", _stack_attribute(search, "undecided_share"), _UNDECIDED_LABEL, "", "point"),
        Quantity(
            "front_checked_undecided",
            _stack_attribute(check, "undecided_share"),
            f"{_UNDECIDED_LABEL}, by the check",
            "",
            "point",
        ),
        Quantity("front_holds", holds.astype(np.int8), "not dominated by the check", "", "point"),
    ]


def _candidate_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return all evaluated candidates."""
    generations, dimensions = [g for _, g in findings.evaluated_generations], "candidate objective"
    bodies = np.array([n for n, g in findings.evaluated_generations for _ in g.numbers], int)
    values, objectives = (
        _stack_attribute(generations, "numbers", len(plan.variables)),
        _stack_attribute(generations, "objectives", len(OBJECTIVES)),
    )
    return [
        Quantity("candidates", len(bodies), "number of evaluated candidates"),
        Quantity("tried_value", values, "values, in SI", "", "candidate variable"),
        Quantity("tried_bodies", bodies, "number of bodies", "", "candidate"),
        Quantity("tried_objective", objectives, _objective_units(plan), "", dimensions),
        Quantity("tried_undecided", _stack_attribute(generations, "undecided_share"), _UNDECIDED_LABEL, "", "candidate"),
    ]


def _baseline_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the machine as it is."""
    baseline, words = findings.baseline, f"machine as it is, by the {{}}: {_objective_units(plan)}"
    as_it_is = _candidate_entry(plan, len(balancer_names(plan.machine)), plan.numbers, baseline.evaluation, baseline.check)
    return [
        Quantity("as_it_is", as_it_is, "machine as it is", parts=_PARTS),
        Quantity("own_objective", baseline.evaluation.objectives[0], words.format("search"), "", "objective"),
        Quantity("own_checked", _check_numbers(baseline.check), words.format("check"), "", "objective"),
    ]


def _question_quantities(plan: Plan) -> list[Quantity]:
    """Return the variables, the objectives, and the runs of the search."""
    variables = {v.name: {"paths": list(v.paths), "range": [v.low, v.high], "unit": v.unit} for v in plan.variables}
    unbalance = [end / plan.as_it_is.ends[0] * _unbalance(plan)[0] for end in plan.as_it_is.ends]
    units = {v.name: (v.name, v.unit) for v in plan.variables}
    return [
        Quantity("objective", np.array(OBJECTIVES, str), "objective", "", "objective"),
        Quantity("variable", np.array([v.name for v in plan.variables], str), "variable", "", "variable"),
        Quantity("outcome", np.array(OUTCOMES, str), "outcome", "", "outcome"),
        Quantity("objectives", list(plan.objectives), "objectives of the search"),
        Quantity("units", _units(plan), "units of the objectives"),
        Quantity("model", plan.spec.model, "equations of the search"),
        Quantity("variables", variables, "variables, with their ranges", parts=units),
        Quantity("numbers_of_bodies", list(plan.trials), "numbers of bodies in the search"),
        Quantity("unbalance", unbalance, "least and greatest unbalance of the rotor", "kg m"),
        Quantity("samples", plan.spec.samples, "number of runs of a candidate"),
        Quantity("runs", plan.runs, "number of runs before the recommendation, at most"),
        Quantity("integration", plan.way, "way of integration"),
    ]


def _damping_quantities(plan: Plan, curve: DampingCurve | None) -> list[Quantity]:
    """Return the damping curve, and its optimum."""
    if curve is None or plan.curve is None:
        return [Quantity("damping", None, "best damping of the bodies")]
    unit, time, ends = plan.curve[0].variables[0].unit, plan.machine.units.time, [float(curve.damping[k]) for k in (0, -1)]
    optimum, rate_optimum = (x if np.isfinite(x) else None for x in (curve.optimum, curve.rate_optimum))
    alike = bool(np.ptp(curve.share_through) == 0)
    best = {"optimum": optimum, "of_rates": rate_optimum, "as_many": alike, "range": ends, "unit": unit}
    parts = {
        "optimum": ("damping of the shortest settling time", unit), "of_rates": ("damping of the greatest rate of decay", unit),
        "as_many": ("whether the share of captured runs is the same with each damping", ""),
        "range": ("least and greatest damping", unit), "unit": ("unit of the damping", ""),
    }  # fmt: skip
    return [
        Quantity("damping", best, "best damping of the bodies", parts=parts),
        Quantity("damping", curve.damping, "damping of the bodies", unit, "damping"),
        Quantity("settling_time", curve.settling_time, "median settling time", time, "damping"),
        Quantity("through", curve.share_through, "share of the runs that pass", "", "damping"),
        Quantity("decay_rate", curve.rate, "slowest rate of decay, linearised", f"1/{time}", "damping"),
    ]


def _objective_units(plan: Plan) -> str:
    return ", ".join(f"{o} in {u or 1}" for o, u in _units(plan).items())


def _units(plan: Plan) -> dict[str, str]:
    return dict(zip(OBJECTIVES, (plan.machine.units.time, "kg m", plan.machine.orbit_unit, ""), strict=True))


def _stack_attribute(several: Sequence[CandidateResults | None], name: str, width: int | None = None) -> np.ndarray:
    """Stack an attribute of candidates, (P,) or (P, width); nan for one that is None."""
    missing = np.full(1 if width is None else (1, width), np.nan)
    parts = [missing if one is None else getattr(one, name) for one in several]
    return np.concatenate(parts) if parts else missing[:0]


def _check_numbers(check: FullCheck | None) -> np.ndarray:
    """Return the objectives (4,) by the check, with the residual of the stable state."""
    if check is None:
        return np.full(len(OBJECTIVES), np.nan)
    numbers = check.evaluation.objectives[0].copy()
    numbers[RESIDUAL] = check.residual
    return np.asarray(numbers)


def _holds(plan: Plan, check_objectives: np.ndarray) -> np.ndarray:
    """True for points (N,) that remain on the front of the checked ones."""
    objectives = check_objectives[:, plan.objective_columns]
    is_known = np.isfinite(objectives).all(axis=1)
    holds = np.zeros(len(check_objectives), bool)
    holds[is_known] = is_pareto_optimal(objectives[is_known])
    return holds


def _objective_values(numbers: np.ndarray) -> dict[str, float | None]:
    return {o: float(x) if np.isfinite(x) else None for o, x in zip(OBJECTIVES, numbers, strict=True)}


def _candidate_entry(
    plan: Plan, bodies: int, numbers: np.ndarray, evaluation: CandidateResults, check: FullCheck | None
) -> dict[str, Any]:
    """Return a candidate with its objectives by the search and by the check, and the shares of runs without a verdict."""
    results = evaluation if check is None else check.evaluation
    merit = BalancerMerit.of(bodies, float(results.objectives[0, SETTLING]), results.outcomes[0])
    return {
        "bodies": bodies,
        "parameters": {v.name: float(x) for v, x in zip(plan.variables, numbers, strict=True)},
        "objectives": _objective_values(evaluation.objectives[0]),
        "undecided": float(evaluation.undecided_share[0]),
        "checked": None if check is None else _objective_values(_check_numbers(check)),
        "checked_undecided": None if check is None else float(check.evaluation.undecided_share[0]),
        "fails": merit.most_failing,
        "balances": merit.balances,
    }


def _unbalance(plan: Plan) -> tuple[float, float]:
    """Return the ends of the rotor's unbalance, in kg m."""
    if plan.spec.unbalance is not None:
        return plan.spec.unbalance
    values, name = plan.machine.values, plan.machine.rotor.name
    unbalance = values.get(f"{name}.unbalance", values.get(f"{name}.eccentricity", 0.0) * values[f"{name}.mass"])
    return unbalance, unbalance


def _sentence(plan: Plan, findings: Findings, holds: np.ndarray) -> str:
    candidates = sum(len(g.numbers) for _, g in findings.evaluated_generations)
    if not findings.front:
        return "there is no front yet" if not candidates else "no candidate has all objectives"
    verdicts = [bool(h) for p, h in zip(findings.front, holds, strict=True) if p.check is not None]
    points = "1 point" if findings.front_size == 1 else f"{findings.front_size} points"
    front_text = f"a front of {points} from {candidates} candidates"
    front_sentence = f"{front_text}; {sum(verdicts)} of {len(verdicts)} checked points are confirmed"
    return recommendation_sentence(plan, findings, recommended_row(plan, findings), front_sentence)


def _warnings(plan: Plan, findings: Findings, check_objectives: np.ndarray) -> list[str]:
    warnings = [*plan.warnings, *recommendation_warnings(plan, findings)]
    warnings += _deviation_warnings(plan, findings, check_objectives)
    if reason := next((p.check.reason for p in findings.front if p.check is not None and p.check.reason), ""):
        warnings.append(f"the residual unbalance is not checked with the full equations: {reason}")
    warnings += _undecided_warnings(plan, findings)
    if findings.front and len(findings.front) < findings.front_size:
        warnings.append(f"{len(findings.front)} points, spread over the front, represent its {findings.front_size}")
    done, whole = (
        sum(len(g.numbers) for _, g in findings.evaluated_generations),
        len(plan.trials) * plan.generations * plan.spec.population,
    )
    if not findings.front and done and done >= whole:
        warnings.append(
            "no candidate has all objectives: all its runs are captured, or the parts do not allow it; try other ranges"
        )
    return warnings


def _undecided_warnings(plan: Plan, findings: Findings) -> list[str]:
    shares = _stack_attribute(
        [findings.baseline.evaluation, *(g for _, g in findings.evaluated_generations)], "undecided_share"
    )
    if not shares.any():
        return []
    consequence = "the stated settling time is a lower bound, the capture probability an upper one"
    longer = "; a longer study.until may decide" if plan.spec.until is not None else "; a smaller study.tolerance may decide"
    count = int((shares > 0).sum())
    subject = "1 candidate has" if count == 1 else f"{count} candidates have"
    return [f"{subject} runs without a verdict, up to {percent(shares.max())}: {consequence}{longer}"]


def _deviation_warnings(plan: Plan, findings: Findings, check_objectives: np.ndarray) -> list[str]:
    """Return warnings on objectives in which the check differs from the search by more than chance."""
    points = [
        (k, p.evaluation, p.check.evaluation)
        for k, p in enumerate(findings.front)
        if p.check is not None and not p.check.reason
    ]
    warnings = []
    for column in plan.objective_columns:
        name, unit = OBJECTIVES[column], _units(plan)[OBJECTIVES[column]]
        off = {
            k: abs(check_objectives[k, column] - a.objectives[0, column]) / _tolerances(plan, a, b)[column]
            for k, a, b in points
        }
        off = {k: np.nan_to_num(x, nan=np.inf) for k, x in off.items()}  # the check has none
        deviating = [k for k, x in off.items() if x > 1]
        if not deviating:
            continue
        worst = max(deviating, key=off.__getitem__)
        ours, theirs = findings.front[worst].evaluation.objectives[0, column], check_objectives[worst, column]
        check_text = f"{theirs:.4g} {unit}".rstrip() if np.isfinite(theirs) else "none"
        numbers = f"at point {worst + 1} {ours:.4g} {unit}".rstrip() + f" by the search, {check_text} by the check"
        places = f"at {len(deviating)} of {len(points)} points"
        warnings.append(f"the full equations, from other phases, give another {name} {places}: {numbers}")
    return warnings


def _tolerances(plan: Plan, search: CandidateResults, check: CandidateResults) -> np.ndarray:
    """Return the difference of the objectives (4,) of a candidate that chance explains between search and check."""
    count, share = plan.spec.samples, (search.objectives[0, CAPTURE] + check.objectives[0, CAPTURE]) / 2
    tolerances = np.empty(len(OBJECTIVES))
    tolerances[SETTLING] = _FAR * search.objectives[0, SETTLING] + _CHANCE * np.hypot(search.error[0], check.error[0])
    tolerances[RESIDUAL] = _RESIDUAL * max(_unbalance(plan))
    tolerances[PEAK] = _PEAK * search.objectives[0, PEAK]
    tolerances[CAPTURE] = 1 / count + _CHANCE * np.sqrt((1 + 1 / CHECK_SAMPLES) * share * (1 - share) / count)
    return tolerances
