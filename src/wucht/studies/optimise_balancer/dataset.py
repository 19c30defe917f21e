"""Findings -> the Dataset of a search: the front and its check by the full equations, all candidates, the damping curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, Evaluated
from wucht.dynamics.balancers.damping_optimum import DampingCurve
from wucht.dynamics.sampling.searches import not_dominated
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.results.formatting import percent
from wucht.results.quantities import Quantity, answer
from wucht.studies.optimise_balancer.computation import Checked, Findings, Plan
from wucht.studies.optimise_balancer.spec import OBJECTIVES

if TYPE_CHECKING:
    import xarray as xr

_FAR = 0.1  # relative: times that differ by more cause a warning, if chance does not explain it
_PEAK = 0.2  # likewise; the largest of few
_RESIDUAL = 0.01  # of the greatest unbalance
_UNDECIDED = "share of runs without a verdict"
_PARTS = {
    "bodies": ("number of bodies", ""),
    "parameters": ("parameters", ""),
    "objectives": ("objectives by the search", ""),
    "undecided": (_UNDECIDED, ""),
    "checked": ("objectives by the check", ""),
    "checked_undecided": (f"{_UNDECIDED}, by the check", ""),
}
_CHANCE = 2.6  # standard deviations: a hundredth of what chance does


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a search."""
    front = findings.front
    checked = np.array([_numbers(p.checked) for p in front]).reshape(len(front), len(OBJECTIVES))
    holds = _holds(plan, checked)
    quantities = [
        *_of_front(plan, findings, checked, holds),
        *_of_tried(plan, findings),
        *_of_machine(plan, findings),
        *_of_question(plan),
        *_of_damping(plan, findings.curve),
    ]
    return answer(quantities, _sentence(findings, holds), _warnings(plan, findings, checked))


def _of_front(plan: Plan, findings: Findings, checked: np.ndarray, holds: np.ndarray) -> list[Quantity]:
    """Return the front by the search and by the check; runs without a verdict may lower the capture probability."""
    front, width, words = findings.front, len(plan.variables), _in_words(plan)
    search, check = [p.seen for p in front], [None if p.checked is None else p.checked.seen for p in front]
    values, bodies = _of(search, "numbers", width), np.array([p.bodies for p in front], int)
    objectives, dimensions = _of(search, "objectives", len(OBJECTIVES)), "point objective"
    outcomes, outcomes_of_check = (_of(c, "outcomes", len(OUTCOMES)) for c in (search, check))
    rows = [
        _candidate(plan, p.bodies, p.numbers, p.seen, p.checked) | {"holds": None if p.checked is None else bool(h)}
        for p, h in zip(front, holds, strict=True)
    ]
    parts = _PARTS | {"holds": ("whether no other checked point dominates it", "")}
    return [
        Quantity("front", rows, "points of the front", parts=parts),
        Quantity("found", findings.found, "number of points of the front"),
        Quantity("front_value", values, "values, in SI", "", "point variable"),
        Quantity("front_bodies", bodies, "number of bodies", "", "point"),
        Quantity("front_objective", objectives, f"by the search: {words}", "", dimensions),
        Quantity("front_checked", checked, f"by the check: {words}", "", dimensions),
        Quantity("front_outcome", outcomes, "share of the runs", "", "point outcome"),
        Quantity("front_checked_outcome", outcomes_of_check, "share, by the check", "", "point outcome"),
        Quantity("front_undecided", _of(search, "undecided"), _UNDECIDED, "", "point"),
        Quantity("front_checked_undecided", _of(check, "undecided"), f"{_UNDECIDED}, by the check", "", "point"),
        Quantity("front_holds", holds.astype(np.int8), "not dominated by the check", "", "point"),
    ]


def _of_tried(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return all evaluated candidates."""
    generations, dimensions = [g for _, g in findings.tried], "candidate objective"
    bodies = np.array([n for n, g in findings.tried for _ in g.numbers], int)
    values, objectives = _of(generations, "numbers", len(plan.variables)), _of(generations, "objectives", len(OBJECTIVES))
    return [
        Quantity("candidates", len(bodies), "number of evaluated candidates"),
        Quantity("tried_value", values, "values, in SI", "", "candidate variable"),
        Quantity("tried_bodies", bodies, "number of bodies", "", "candidate"),
        Quantity("tried_objective", objectives, _in_words(plan), "", dimensions),
        Quantity("tried_undecided", _of(generations, "undecided"), _UNDECIDED, "", "candidate"),
    ]


def _of_machine(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the machine as it is."""
    own, words = findings.own, f"machine as it is, by the {{}}: {_in_words(plan)}"
    as_it_is = _candidate(plan, len(plan.machine.group(plan.machine.rotor)) - 1, plan.numbers, own.seen, own.checked)
    return [
        Quantity("as_it_is", as_it_is, "machine as it is", parts=_PARTS),
        Quantity("own_objective", own.seen.objectives[0], words.format("search"), "", "objective"),
        Quantity("own_checked", _numbers(own.checked), words.format("check"), "", "objective"),
    ]


def _of_question(plan: Plan) -> list[Quantity]:
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
        Quantity("runs", plan.runs, "number of runs in all"),
        Quantity("integration", plan.way, "way of integration"),
    ]


def _of_damping(plan: Plan, curve: DampingCurve | None) -> list[Quantity]:
    """Return the damping curve, and its optimum."""
    if curve is None or plan.curve is None:
        return [Quantity("damping", None, "best damping of the bodies")]
    unit, time, ends = plan.curve[0].variables[0].unit, plan.machine.units.time, [float(curve.damping[k]) for k in (0, -1)]
    optimum, of_rates = (x if np.isfinite(x) else None for x in (curve.optimum, curve.of_rates))
    alike = bool(np.ptp(curve.through) == 0)
    best = {"optimum": optimum, "of_rates": of_rates, "as_many": alike, "range": ends, "unit": unit}
    parts = {
        "optimum": ("damping of the shortest settling time", unit), "of_rates": ("damping of the greatest rate of decay", unit),
        "as_many": ("whether the share of captured runs is the same with each damping", ""),
        "range": ("least and greatest damping", unit), "unit": ("unit of the damping", ""),
    }  # fmt: skip
    return [
        Quantity("damping", best, "best damping of the bodies", parts=parts),
        Quantity("damping", curve.damping, "damping of the bodies", unit, "damping"),
        Quantity("settling_time", curve.settling_time, "median settling time", time, "damping"),
        Quantity("through", curve.through, "share of the runs that pass", "", "damping"),
        Quantity("decay_rate", curve.rate, "slowest rate of decay, linearised", f"1/{time}", "damping"),
    ]


def _in_words(plan: Plan) -> str:
    return ", ".join(f"{o} in {u or 1}" for o, u in _units(plan).items())


def _units(plan: Plan) -> dict[str, str]:
    return dict(zip(OBJECTIVES, (plan.machine.units.time, "kg m", plan.machine.orbit_unit, ""), strict=True))


def _of(several: Sequence[Evaluated | None], name: str, width: int | None = None) -> np.ndarray:
    """Stack an attribute of candidates, (P,) or (P, width); nan for one that is None."""
    none = np.full(1 if width is None else (1, width), np.nan)
    parts = [none if one is None else getattr(one, name) for one in several]
    return np.concatenate(parts) if parts else none[:0]


def _numbers(checked: Checked | None) -> np.ndarray:
    """Return the objectives (4,) by the check, with the residual of the stable state."""
    if checked is None:
        return np.full(len(OBJECTIVES), np.nan)
    numbers = checked.seen.objectives[0].copy()
    numbers[RESIDUAL] = checked.residual
    return np.asarray(numbers)


def _holds(plan: Plan, checked: np.ndarray) -> np.ndarray:
    """True for points (N,) that remain on the front of the checked ones."""
    asked = checked[:, plan.asked]
    known = np.isfinite(asked).all(axis=1)
    holds = np.zeros(len(checked), bool)
    holds[known] = not_dominated(asked[known])
    return holds


def _named(numbers: np.ndarray) -> dict[str, float | None]:
    return {o: float(x) if np.isfinite(x) else None for o, x in zip(OBJECTIVES, numbers, strict=True)}


def _candidate(plan: Plan, bodies: int, numbers: np.ndarray, seen: Evaluated, checked: Checked | None) -> dict[str, Any]:
    """Return a candidate with its objectives by the search and by the check, and the shares of runs without a verdict."""
    return {
        "bodies": bodies,
        "parameters": {v.name: float(x) for v, x in zip(plan.variables, numbers, strict=True)},
        "objectives": _named(seen.objectives[0]),
        "undecided": float(seen.undecided[0]),
        "checked": None if checked is None else _named(_numbers(checked)),
        "checked_undecided": None if checked is None else float(checked.seen.undecided[0]),
    }


def _unbalance(plan: Plan) -> tuple[float, float]:
    """Return the ends of the rotor's unbalance, in kg m."""
    if plan.spec.unbalance is not None:
        return plan.spec.unbalance
    values, name = plan.machine.values, plan.machine.rotor.name
    own = values.get(f"{name}.unbalance", values.get(f"{name}.eccentricity", 0.0) * values[f"{name}.mass"])
    return own, own


def _sentence(findings: Findings, holds: np.ndarray) -> str:
    candidates = sum(len(g.numbers) for _, g in findings.tried)
    if not findings.front:
        return "there is no front yet" if not candidates else "no candidate has all objectives"
    held = [bool(h) for p, h in zip(findings.front, holds, strict=True) if p.checked is not None]
    points = "1 point" if findings.found == 1 else f"{findings.found} points"
    named = f"a front of {points} from {candidates} candidates"
    return f"{named}; {sum(held)} of {len(held)} checked points are confirmed"


def _warnings(plan: Plan, findings: Findings, checked: np.ndarray) -> list[str]:
    warnings = [*plan.warnings, *_apart(plan, findings, checked)]
    if why := next((p.checked.why for p in findings.front if p.checked is not None and p.checked.why), ""):
        warnings.append(f"the residual unbalance is not checked with the full equations: {why}")
    warnings += _undecided(plan, findings)
    if findings.front and len(findings.front) < findings.found:
        warnings.append(f"{len(findings.front)} points, spread over the front, represent its {findings.found}")
    done, whole = sum(len(g.numbers) for _, g in findings.tried), len(plan.trials) * plan.generations * plan.spec.population
    if not findings.front and done and done >= whole:
        warnings.append(
            "no candidate has all objectives: all its runs are captured, or the parts do not allow it; try other ranges"
        )
    return warnings


def _undecided(plan: Plan, findings: Findings) -> list[str]:
    shares = _of([findings.own.seen, *(g for _, g in findings.tried)], "undecided")
    if not shares.any():
        return []
    what = "the stated settling time is a lower bound, the capture probability an upper one"
    longer = "; a longer study.until may decide" if plan.spec.until is not None else "; a smaller study.tolerance may decide"
    count = int((shares > 0).sum())
    which = "1 candidate has" if count == 1 else f"{count} candidates have"
    return [f"{which} runs without a verdict, up to {percent(shares.max())}: {what}{longer}"]


def _apart(plan: Plan, findings: Findings, checked: np.ndarray) -> list[str]:
    """Return warnings on objectives in which the check differs from the search by more than chance."""
    points = [(k, p.seen, p.checked.seen) for k, p in enumerate(findings.front) if p.checked is not None and not p.checked.why]
    told = []
    for column in plan.asked:
        name, unit = OBJECTIVES[column], _units(plan)[OBJECTIVES[column]]
        off = {k: abs(checked[k, column] - a.objectives[0, column]) / _allowed(plan, a, b)[column] for k, a, b in points}
        off = {k: np.nan_to_num(x, nan=np.inf) for k, x in off.items()}  # the check has none
        apart = [k for k, x in off.items() if x > 1]
        if not apart:
            continue
        worst = max(apart, key=off.__getitem__)
        ours, theirs = findings.front[worst].seen.objectives[0, column], checked[worst, column]
        known = f"{theirs:.4g} {unit}".rstrip() if np.isfinite(theirs) else "none"
        numbers = f"at point {worst + 1} {ours:.4g} {unit}".rstrip() + f" by the search, {known} by the check"
        places = f"at {len(apart)} of {len(points)} points"
        told.append(f"the full equations, from other phases, give another {name} {places}: {numbers}")
    return told


def _allowed(plan: Plan, search: Evaluated, check: Evaluated) -> np.ndarray:
    """Return the difference of the objectives (4,) of a candidate that chance explains between two draws of phases."""
    count, share = plan.spec.samples, (search.objectives[0, CAPTURE] + check.objectives[0, CAPTURE]) / 2
    allowed = np.empty(len(OBJECTIVES))
    allowed[SETTLING] = _FAR * search.objectives[0, SETTLING] + _CHANCE * np.hypot(search.error[0], check.error[0])
    allowed[RESIDUAL] = _RESIDUAL * max(_unbalance(plan))
    allowed[PEAK] = _PEAK * search.objectives[0, PEAK]
    allowed[CAPTURE] = 1 / count + _CHANCE * np.sqrt(2 * share * (1 - share) / count)
    return allowed
