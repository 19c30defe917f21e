"""The answer on the recommendation of a search: what it was compared with, its cliff, and what to write into the file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wucht.dynamics.balancers.balancer_candidate import BalancerCandidate
from wucht.dynamics.balancers.balancer_search import AS_IT_IS, CURVE, BalancerSearch
from wucht.dynamics.balancers.damping_optimum import DampingCurve
from wucht.dynamics.balancers.recommendation import Design, Recommendation, motor_sets, motor_time
from wucht.dynamics.sampling.choice import Cliff
from wucht.dynamics.sampling.searches import balancer_names, values_at
from wucht.results.formatting import bodies_in_words, percent
from wucht.studies.answer import Answer

_RECOMMENDED_NAME, _DUEL_NAME = "recommended balancer", "the best one against the present machine"
_COMPARED_NAME = "candidates compared by the same fresh runs of the full equations"
_RELATIONS = {
    AS_IT_IS: "the present machine",
    "damping curve": "the best of the damping curve",
    "damping alone": "that damping, which is not varied,",
    "neighbour": "neighbours",
    "other candidate": "others",
}


def state_recommendation(
    a: Answer,
    search: BalancerSearch,
    curve: DampingCurve | None,
    front: Sequence[BalancerCandidate],
    recommendation: Recommendation | None,
) -> str:
    """State the recommended balancer, which there is none of where nothing balances, and the comparison from which it follows.

    Return the clause on it, empty before the comparison.
    """
    if recommendation is None:
        a.number("recommended", None, _RECOMMENDED_NAME)
        a.number("duel", None, _DUEL_NAME)
        a.number("compared", [], _COMPARED_NAME)
        return ""
    settling_time, bodies = recommendation.settling_time, _bodies(search, recommendation.chosen)
    is_balancing = recommendation.balances and bool(np.isfinite(settling_time))
    if is_balancing:
        changes, motor_sets_time = _state_recommended(a, search, front, recommendation)
    else:
        a.number("recommended", None, _RECOMMENDED_NAME)
    comparison = _state_compared(a, search, curve, recommendation)
    _state_duel(a, search, recommendation)
    _warn_of_damping(a, search, recommendation)
    if not is_balancing:
        return "nothing that was compared balances in more than half of its runs"
    a.line("compared", comparison)
    duel = "in {runs:.0f} further runs the best one {settling_time:.3g}, the present machine {as_it_is:.3g}, "
    a.line("", duel + "the difference to {difference_error:.2g}", at="duel")
    _state_changes(a, changes, bodies, len(balancer_names(search.machine)))
    if motor_sets_time:
        times = "sets the settling time of {settling_time:.3g}, not the balancer: without vibration it needs {motor_time:.3g}"
        a.line("motor", times, at="recommended")
    keep = "nothing is better beyond chance than the present machine, keep it: " if recommendation.is_kept else ""
    unit = search.machine.units.time
    share, time = _failing_share(recommendation), f"{settling_time:.3g} {unit}".rstrip()
    at_least = "at least " if " to " in share else ""
    clause = f"{keep}{bodies_in_words(bodies)}: median settling time {at_least}{time}, {share} fail"
    cliff = recommendation.cliff
    return clause if cliff is None else f"{clause}; {_cliff_in_words(cliff, recommendation.failing_shares[1], unit)}"


def _state_recommended(
    a: Answer,
    search: BalancerSearch,
    front: Sequence[BalancerCandidate],
    recommendation: Recommendation,
) -> tuple[dict[str, str], bool]:
    """State the recommended balancer. Return what it changes in the machine, and whether the motor sets the settling time."""
    chosen, cliff, scores = recommendation.chosen, recommendation.cliff, recommendation.final.scores
    bodies, settling_time, (least, most) = _bodies(search, chosen), recommendation.settling_time, recommendation.failing_shares
    numbers, machine, changes, point = _numbers(search, chosen), search.machine, dict[str, str](), None
    if not recommendation.is_kept:
        trials = search.trials[bodies]
        values = values_at(trials.machine, trials.variables, numbers.tolist())
        changes = {path: f"{x:.4g} {trials.machine.parameters[path].unit}".rstrip() for path, x in values.items()}
        machine = trials.candidate_machine(numbers.tolist())
        point = next((k for k, candidate in enumerate(front) if candidate.design == chosen), None)
    of_cliff = None if cliff is None else {
        "parameter": cliff.parameter, "value": cliff.value, "distance": cliff.distance, "inside": cliff.inside,
        "settling_time": finite_or_none(cliff.cost), "fails": cliff.failing_share,
    }  # fmt: skip
    error = finite_or_none(scores.standard_error(recommendation.score))
    at_most = "share of runs that do not end compensated, those without a verdict among them"
    at_cliff = "nearest value at which a tenth more of the runs fail, or the settling time is twice as long"
    with a.group("recommended", _RECOMMENDED_NAME):
        a.number("point", point, "its index in the front, none for the present machine")
        a.number("bodies", bodies, "number of bodies")
        parameters = a.number("parameters", parameters_by_name(search, numbers), "parameters")
        a.number("changes", changes, "values to be set in the machine, by path")
        a.number("settling_time", settling_time, "median settling time", "time")
        a.number("error", error, "standard error of the settling time", "time")
        a.number("runs", scores.costs.shape[1], "number of runs from which it follows, of its own")
        a.number("fails", most, at_most)
        a.number("fails_for_certain", least, "the same without them")
        a.number("cliff", of_cliff, at_cliff)
        time = motor_time(machine, search.as_it_is.start)
        a.number("motor_time", time, "time in which the motor reaches its speed without vibration", "time")
        is_set_by_motor = motor_sets(time, settling_time)
        a.number("motor_sets_time", is_set_by_motor, "whether the motor, not the balancer, sets the settling time")
    keep = "to keep the present machine, " if recommendation.is_kept else ""
    share = f"{_failing_share(recommendation)} do not end compensated" if most else "all end compensated"
    a.line("recommended", f"{keep}{design_in_words(search, bodies, parameters)}: of its runs {share}")
    return changes, is_set_by_motor


def _state_compared(a: Answer, search: BalancerSearch, curve: DampingCurve | None, recommendation: Recommendation) -> str:
    """State all that was compared in the end, the best first. Return it in words."""
    contest = recommendation.beside or recommendation.final
    scores, order = contest.scores, contest.scores.order.tolist()
    designs = [contest.candidates[k] for k in order]
    names = dict.fromkeys(recommendation.neighbours, "neighbour")
    names |= dict.fromkeys(search.best_dampings(curve)[0][:1], "damping curve")
    names |= {recommendation.chosen: "recommended", search.present: AS_IT_IS}
    relations = ["damping alone" if d.group == CURVE else names.get(d, "other candidate") for d in designs]
    times, fails = [finite_or_none(scores.medians[k]) for k in order], [float(scores.failing_shares[k]) for k in order]
    differences = [scores.difference(k, recommendation.score) for k in order]
    a.table(
        "compared", _COMPARED_NAME,
        what=(relations, "what it is"), bodies=([_bodies(search, d) for d in designs], "number of bodies"),
        parameters=([_parameters(search, d) for d in designs], "parameters"),
        settling_time=(times, "median settling time", "time"),
        error=([finite_or_none(scores.standard_error(k)) for k in order], "standard error of the settling time", "time"),
        fails=(fails, "share of runs that do not end compensated"),
        difference=(
            [finite_or_none(x) for x, _ in differences], "settling time minus that of the recommended one", "time"
        ),
        difference_error=(
            [finite_or_none(x) for _, x in differences], "standard error of the difference, from the same starts", "time"
        ),
    )  # fmt: skip
    unit, final_scores = search.machine.units.time, recommendation.final.scores
    error = final_scores.standard_error(recommendation.score)
    spread = f"{recommendation.settling_time:.3g}{f' ± {error:.2g}' if np.isfinite(error) else ''} {unit}".rstrip()
    clauses, as_reliable = list[str](), [share <= recommendation.failing_shares[1] for share in fails]
    for relation, words in _RELATIONS.items():
        mine = [t for t, r, is_reliable in zip(times, relations, as_reliable, strict=True) if r == relation and is_reliable]
        clauses += [f"{words} {_ends_in_words(mine, unit)}"] if mine else []
    clauses += [] if all(as_reliable) else [f"{as_reliable.count(False)} fail more often"]
    runs = f"settling time {spread} in {final_scores.costs.shape[1]} runs of its own; from the same starts "
    return runs + ", ".join(clauses)


def _ends_in_words(times: Sequence[float | None], unit: str) -> str:
    finite = [t for t in times if t is not None]
    ends = dict.fromkeys(f"{t:.3g}" for t in (min(finite), max(finite))) if finite else {}
    return f"{' to '.join(ends)} {unit}".rstrip() if ends else "none"


def _state_duel(a: Answer, search: BalancerSearch, recommendation: Recommendation) -> None:
    """State the further runs that decide between the best one and the present machine, none where they are not needed."""
    row, time = None, search.machine.units.time
    if recommendation.duel is not None:
        scores, k = recommendation.duel.scores, recommendation.duel.candidates.index(search.present)
        row = {
            "runs": scores.costs.shape[1], "settling_time": finite_or_none(scores.medians[1 - k]),
            "as_it_is": finite_or_none(scores.medians[k]),
            "difference_error": finite_or_none(scores.difference(1 - k, k)[1]),
        }  # fmt: skip
    parts = {
        "runs": ("number of further runs of each", ""), "settling_time": ("median settling time of the best one", time),
        "as_it_is": ("that of the present machine", time), "difference_error": ("standard error of the difference", time),
    }  # fmt: skip
    a.number("duel", row, _DUEL_NAME, parts=parts)


def _state_changes(a: Answer, changes: dict[str, str], bodies: int, present_bodies: int) -> None:
    """State the lines of a study file that change the machine into the recommended one."""
    lines = ["[machine.set]", *(f'"{path}" = "{value}"' for path, value in changes.items())] if changes else []
    if changes and bodies != present_bodies:
        names = dict.fromkeys(path.partition(".")[0] for path in changes)
        lines.insert(0, f"# with {bodies_in_words(bodies)}, each like the first one: {', '.join(names)}")
    for k, line in enumerate(lines):
        a.line("" if k else "to paste", line)


def _warn_of_damping(a: Answer, search: BalancerSearch, recommendation: Recommendation) -> None:
    """Warn where the damping, which is not varied, would gain more than what is."""
    if recommendation.beside is None:
        return
    scores, beside = recommendation.beside.scores, recommendation.beside.candidates[-1]
    k, unit = len(scores.medians) - 1, search.machine.units.time
    if scores.is_better(k, recommendation.score):
        damping = f"{beside.numbers[0]:.3g} {search.groups[CURVE].variables[0].unit}".rstrip()
        times = f"{scores.medians[k]:.3g} {unit} instead of {scores.medians[recommendation.score]:.3g} {unit}".rstrip()
        a.warn(f"a damping of {damping} alone, which is not varied, settles sooner: {times}; vary it in study.vary")


def _failing_share(recommendation: Recommendation) -> str:
    least, most = map(percent, recommendation.failing_shares)
    return most if least == most else f"{least} to {most}"


def _cliff_in_words(cliff: Cliff, most_failing: float, unit: str) -> str:
    """Return the nearest cliff of a balancer, of whose runs such a share fails: ``with 40 % less mass 50 % fail``."""
    change = f"{100 * abs(cliff.distance):.2g} % {'less' if cliff.distance < 0 else 'more'} {cliff.parameter}"
    if cliff.failing_share > most_failing or not np.isfinite(cliff.cost):
        return f"with {change} {percent(cliff.failing_share)} fail"
    return f"with {change} the settling time is {cliff.cost:.3g} {unit}".rstrip()


def _bodies(search: BalancerSearch, design: Design) -> int:
    return len(balancer_names(search.machine)) if design.group in (AS_IT_IS, CURVE) else int(design.group)


def _numbers(search: BalancerSearch, design: Design) -> np.ndarray:
    return search.numbers if design.group == AS_IT_IS else np.array(design.numbers)


def _parameters(search: BalancerSearch, design: Design) -> dict[str, float]:
    numbers = _numbers(search, design)
    return {"damping": float(numbers[0])} if design.group == CURVE else parameters_by_name(search, numbers)


def parameters_by_name(search: BalancerSearch, numbers: np.ndarray) -> dict[str, float]:
    """Return values of the variables (k,) by their names."""
    return {v.name: float(x) for v, x in zip(search.variables, numbers, strict=True)}


def design_in_words(search: BalancerSearch, bodies: int, parameters: dict[str, float]) -> str:
    """Return the number of bodies, and the values of the variables, in words."""
    units = {v.name: v.unit for v in search.variables}
    values = [f"{name} {x:.3g} {units[name]}".rstrip() for name, x in parameters.items()]
    return f"{bodies_in_words(bodies)}, {', '.join(values)}"


def finite_or_none(x: float) -> float | None:
    """Return a number; None where it is not finite."""
    return float(x) if np.isfinite(x) else None
