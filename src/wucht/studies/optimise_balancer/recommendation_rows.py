"""The recommendation of a search in the Dataset: what it was compared with, its cliff, its sentence and its warnings."""

from __future__ import annotations

from typing import Any

import numpy as np

from wucht.dynamics.balancers.recommendation import BalancerMerit, Design, Recommendation, motor_sets, motor_time
from wucht.dynamics.sampling.choice import Cliff
from wucht.dynamics.sampling.searches import balancer_names, values_at
from wucht.results.formatting import bodies_in_words, percent
from wucht.results.quantities import Quantity
from wucht.studies.optimise_balancer.balancer_plan import AS_IT_IS, CURVE, Plan
from wucht.studies.optimise_balancer.computation import Findings, curve_designs, present_design, recommended_point


def recommendation_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the recommended candidate, and the comparison from which it follows."""
    time, recommendation = plan.machine.units.time, findings.recommendation
    rows = [] if recommendation is None else _comparison_rows(plan, findings, recommendation)
    row_parts = {
        "what": ("what it is", ""), "bodies": ("number of bodies", ""), "parameters": ("parameters", ""),
        "settling_time": ("median settling time", time), "error": ("standard error of the settling time", time),
        "fails": ("share of runs that do not end compensated", ""),
        "difference": ("settling time minus that of the recommended one", time),
        "difference_error": ("standard error of the difference, from the same starts", time),
    }  # fmt: skip
    duel_parts = {
        "runs": ("number of further runs of each", ""), "settling_time": ("median settling time of the best one", time),
        "as_it_is": ("that of the machine as it is", time), "difference_error": ("standard error of the difference", time),
    }  # fmt: skip
    return [
        Quantity("recommended", recommended_row(plan, findings), "recommended balancer", parts=_recommendation_parts(plan)),
        Quantity("duel", _duel_row(plan, recommendation), "the best one against the machine as it is", parts=duel_parts),
        Quantity("compared", rows, "candidates compared by the same fresh runs of the full equations", parts=row_parts),
    ]


def _duel_row(plan: Plan, recommendation: Recommendation | None) -> dict[str, Any] | None:
    """Return the further runs that decide between the best one and the machine as it is; None where they are not needed."""
    if recommendation is None or recommendation.duel is None:
        return None
    duel, present = recommendation.duel, present_design(plan)
    k = duel.candidates.index(present)
    return {
        "runs": duel.scores.costs.shape[1], "settling_time": _finite(duel.scores.medians[1 - k]),
        "as_it_is": _finite(duel.scores.medians[k]), "difference_error": _finite(duel.scores.difference(1 - k, k)[1]),
    }  # fmt: skip


def recommended_row(plan: Plan, findings: Findings) -> dict[str, Any] | None:
    """Return the recommendation; None as long as it is not complete, and where nothing balances."""
    recommendation = findings.recommendation
    if recommendation is None:
        return None
    scores, k = recommendation.final.scores, recommendation.score
    bodies, numbers = _bodies(plan, recommendation.chosen), _numbers(plan, recommendation.chosen)
    merit = BalancerMerit.of(bodies, float(scores.medians[k]), recommendation.outcomes)
    if not merit.balances or not np.isfinite(merit.settling_time):
        return None
    machine, changes = plan.machine, dict[str, str]()
    if not recommendation.is_kept:
        trials = plan.trials[bodies]
        values = values_at(trials.machine, trials.variables, numbers.tolist())
        machine = trials.candidate_machine(numbers.tolist())
        changes = {path: f"{x:.4g} {trials.machine.parameters[path].unit}".rstrip() for path, x in values.items()}
    time = motor_time(machine, plan.spec.start)
    return {
        "point": None if recommendation.is_kept else recommended_point(findings),
        "bodies": bodies,
        "parameters": _parameters(plan, numbers),
        "changes": changes,
        "settling_time": merit.settling_time,
        "error": scores.standard_error(k),
        "runs": scores.costs.shape[1],
        "fails": merit.most_failing,
        "fails_for_certain": merit.failing_share,
        "cliff": None if recommendation.cliff is None else _cliff_row(recommendation.cliff),
        "motor_time": time,
        "motor_sets_time": motor_sets(time, merit.settling_time),
    }


def _cliff_row(cliff: Cliff) -> dict[str, Any]:
    return {
        "parameter": cliff.parameter, "value": cliff.value, "distance": cliff.distance, "inside": cliff.inside,
        "settling_time": cliff.cost if np.isfinite(cliff.cost) else None, "fails": cliff.failing_share,
    }  # fmt: skip


def _comparison_rows(plan: Plan, findings: Findings, recommendation: Recommendation) -> list[dict[str, Any]]:
    """Return all that was compared in the end, the best first."""
    final = recommendation.final if recommendation.beside is None else recommendation.beside
    rows, present = list[dict[str, Any]](), present_design(plan)
    kinds = dict.fromkeys(recommendation.neighbours, "neighbour")
    kinds |= dict.fromkeys(curve_designs(plan, findings.curve, present)[0][:1], "damping curve")
    kinds |= {recommendation.chosen: "recommended", present: AS_IT_IS}
    for k in final.scores.order.tolist():
        design = final.candidates[k]
        what = "damping alone" if design.group == CURVE else kinds.get(design, "other candidate")
        difference, error = final.scores.difference(k, recommendation.score)
        time, standard_error = float(final.scores.medians[k]), final.scores.standard_error(k)
        numbers = _numbers(plan, design)
        rows.append({
            "what": what,
            "bodies": _bodies(plan, design),
            "parameters": {"damping": float(numbers[0])} if design.group == CURVE else _parameters(plan, numbers),
            "settling_time": _finite(time), "error": _finite(standard_error), "fails": float(final.scores.failing_shares[k]),
            "difference": _finite(difference), "difference_error": _finite(error),
        })  # fmt: skip
    return rows


def _bodies(plan: Plan, design: Design) -> int:
    return len(balancer_names(plan.machine)) if design.group in (AS_IT_IS, CURVE) else int(design.group)


def _numbers(plan: Plan, design: Design) -> np.ndarray:
    return plan.numbers if design.group == AS_IT_IS else np.array(design.numbers)


def _parameters(plan: Plan, numbers: np.ndarray) -> dict[str, float]:
    return {v.name: float(x) for v, x in zip(plan.variables, numbers, strict=True)}


def _finite(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def _recommendation_parts(plan: Plan) -> dict[str, tuple[str, str]]:
    time = plan.machine.units.time
    return {
        "point": ("its index in the front, none for the machine as it is", ""),
        "bodies": ("number of bodies", ""),
        "parameters": ("parameters", ""),
        "changes": ("values to be set in the machine, by path", ""),
        "settling_time": ("median settling time", time),
        "error": ("standard error of the settling time", time),
        "runs": ("number of runs from which it follows, of its own", ""),
        "fails": ("share of runs that do not end compensated, those without a verdict among them", ""),
        "fails_for_certain": ("the same without them", ""),
        "cliff": ("nearest value at which a tenth more of the runs fail, or the settling time is twice as long", ""),
        "motor_time": ("time in which the motor reaches its speed without vibration", time),
        "motor_sets_time": ("whether the motor, not the balancer, sets the settling time", ""),
    }


def recommendation_sentence(plan: Plan, findings: Findings, recommendation: dict[str, Any] | None, front: str) -> str:
    """Return the sentence of a search. front: on its points, the last clause."""
    if recommendation is None:
        complete = findings.recommendation is not None
        return f"nothing that was compared balances in more than half of its runs; {front}" if complete else front
    words = recommendation_in_words(recommendation, plan.machine.units.time)
    clauses = [words, cliff_in_words(recommendation, plan.machine.units.time), front]
    sentence = "; ".join(clause for clause in clauses if clause)
    return (
        f"nothing is better beyond chance than the machine as it is, keep it: {sentence}"
        if recommendation["point"] is None
        else sentence
    )


def recommendation_in_words(recommendation: dict[str, Any], time_unit: str) -> str:
    """Return the recommended number of bodies, with its median settling time and the share of the runs that fail."""
    least, most = percent(recommendation["fails_for_certain"]), percent(recommendation["fails"])
    share = most if least == most else f"{least} to {most}"
    at_least = "" if least == most else "at least "
    time = f"{recommendation['settling_time']:.3g} {time_unit}".rstrip()
    return f"{bodies_in_words(recommendation['bodies'])}: median settling time {at_least}{time}, {share} fail"


def cliff_in_words(recommendation: dict[str, Any], time_unit: str) -> str:
    """Return the nearest cliff: ``with 40 % less mass 50 % fail``; empty where there is none."""
    if (cliff := recommendation["cliff"]) is None:
        return ""
    change = f"{100 * abs(cliff['distance']):.2g} % {'less' if cliff['distance'] < 0 else 'more'} {cliff['parameter']}"
    if cliff["fails"] > recommendation["fails"] or cliff["settling_time"] is None:
        return f"with {change} {percent(cliff['fails'])} fail"
    return f"with {change} the settling time is {cliff['settling_time']:.3g} {time_unit}".rstrip()


def recommendation_warnings(plan: Plan, findings: Findings) -> list[str]:
    """Return a warning where the damping, which is not varied, would gain more than what is."""
    recommendation = findings.recommendation
    if recommendation is None or recommendation.beside is None:
        return []
    scores, beside = recommendation.beside.scores, recommendation.beside.candidates[-1]
    k, unit = len(scores.medians) - 1, plan.machine.units.time
    if not scores.is_better(k, recommendation.score):
        return []
    damping = f"{beside.numbers[0]:.3g} {plan.groups[CURVE].variables[0].unit}".rstrip()
    times = f"{scores.medians[k]:.3g} {unit} instead of {scores.medians[recommendation.score]:.3g} {unit}".rstrip()
    return [f"a damping of {damping} alone, which is not varied, settles sooner: {times}; vary it in study.vary"]
