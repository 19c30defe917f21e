"""Findings -> the Dataset of a search: the front, what the full equations say of it, all that was tried, the damping curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, Evaluated
from wucht.dynamics.balancers.damping_optimum import DampingCurve
from wucht.dynamics.sampling.member_outcomes import OUTCOMES
from wucht.dynamics.sampling.pareto_search import not_dominated
from wucht.results.conventions import Variable, answered, variable
from wucht.results.formatting import percent
from wucht.studies.optimise_balancer.prepare import Plan
from wucht.studies.optimise_balancer.run import Checked, Findings
from wucht.studies.optimise_balancer.spec import OBJECTIVES

if TYPE_CHECKING:
    import xarray as xr

_FAR = 0.1  # relative: times that differ by more are warned of, if chance does not explain it
_PEAK = 0.2  # likewise; the largest of few
_RESIDUAL = 0.01  # of the greatest unbalance
_CHANCE = 2.6  # standard deviations: a hundredth of what chance does


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a search.

    Coordinates: objective and variable (names), point (of the front), candidate (all that were tried), damping. Variables:
    front_value (point, variable) in SI, front_bodies, front_objective (point, objective) by the search, front_checked likewise
    by the check, front_outcome and front_checked_outcome (point, outcome) shares of the runs, front_undecided and
    front_checked_undecided (point) those of them without a verdict, by which a share that does not get through may be less;
    front_holds: whether no other checked point is better; tried_value, tried_bodies, tried_objective, tried_undecided;
    own_objective and own_checked of the machine as it is; settling_time, through and decay_rate over the damping.
    """
    import xarray as xr_

    front, columns = findings.front, len(OBJECTIVES)
    by_search, by_check = [p.seen for p in front], [None if p.checked is None else p.checked.seen for p in front]
    checked = np.array([_numbers(p.checked) for p in front]).reshape(len(front), columns)
    units, width, generations = _units(plan), len(plan.variables), [g for _, g in findings.tried]
    told = f"{', '.join(f'{o} in {u or 1}' for o, u in units.items())}"
    open_ = "share of runs without a verdict"
    data: dict[str, Variable] = {
        "front_value": variable("point variable", _of(by_search, "numbers", width), "values, in SI"),
        "front_bodies": variable("point", np.array([p.bodies for p in front], int), "number of bodies"),
        "front_objective": variable("point objective", _of(by_search, "objectives", columns), f"by the search: {told}"),
        "front_checked": variable("point objective", checked, f"by the check: {told}"),
        "front_outcome": variable("point outcome", _of(by_search, "outcomes", len(OUTCOMES)), "share of the runs"),
        "front_checked_outcome": variable("point outcome", _of(by_check, "outcomes", len(OUTCOMES)), "share, by the check"),
        "front_undecided": variable("point", _of(by_search, "undecided"), open_),
        "front_checked_undecided": variable("point", _of(by_check, "undecided"), f"{open_}, by the check"),
        "front_holds": variable("point", _holds(plan, checked).astype(np.int8), "not dominated by the check"),
        "tried_value": variable("candidate variable", _of(generations, "numbers", width), "values, in SI"),
        "tried_bodies": variable(
            "candidate", np.array([n for n, g in findings.tried for _ in g.numbers], int), "number of bodies"
        ),
        "tried_objective": variable("candidate objective", _of(generations, "objectives", columns), told),
        "tried_undecided": variable("candidate", _of(generations, "undecided"), open_),
        "own_objective": variable("objective", findings.own.seen.objectives[0], f"machine as it is, by the search: {told}"),
        "own_checked": variable("objective", _numbers(findings.own.checked), f"machine as it is, by the check: {told}"),
    }
    summary = _summary(plan, findings, checked)
    coordinates: dict[str, Any] = {
        "objective": variable("objective", np.array(OBJECTIVES, str), "objective"),
        "variable": variable("variable", np.array([v.name for v in plan.variables], str), "what is varied"),
        "outcome": variable("outcome", np.array(OUTCOMES, str), "outcome"),
    }
    if findings.curve is not None:
        c, time = findings.curve, plan.machine.units.time
        coordinates["damping"] = variable("damping", c.damping, "damping of the bodies", summary["damping"]["unit"])
        data["settling_time"] = variable("damping", c.settling_time, "settling time, of half of the runs", time)
        data["through"] = variable("damping", c.through, "share of the runs that get through")
        data["decay_rate"] = variable("damping", c.rate, "slowest rate of decay, linearised", f"1/{time}")
    warnings = _warnings(plan, findings, checked)
    return answered(xr_.Dataset(data, coords=coordinates), summary, summary["sentence"], warnings)


def _units(plan: Plan) -> dict[str, str]:
    return dict(zip(OBJECTIVES, (plan.machine.units.time, "kg m", plan.machine.orbit_unit, ""), strict=True))


def _of(several: Sequence[Evaluated | None], name: str, width: int | None = None) -> np.ndarray:
    """What candidates have (P,), or (P, width); nan for one that is None."""
    none = np.full(1 if width is None else (1, width), np.nan)
    parts = [none if one is None else getattr(one, name) for one in several]
    return np.concatenate(parts) if parts else none[:0]


def _numbers(checked: Checked | None) -> np.ndarray:
    """The objectives (4,) by the check; the residual of the state that stands there."""
    if checked is None:
        return np.full(len(OBJECTIVES), np.nan)
    numbers = checked.seen.objectives[0].copy()
    numbers[RESIDUAL] = checked.residual
    return np.asarray(numbers)


def _holds(plan: Plan, checked: np.ndarray) -> np.ndarray:
    """Which points (N,) are still on the front of those that are checked."""
    asked = checked[:, plan.asked]
    known = np.isfinite(asked).all(axis=1)
    holds = np.zeros(len(checked), bool)
    holds[known] = not_dominated(asked[known])
    return holds


def _named(numbers: np.ndarray) -> dict[str, float | None]:
    return {o: float(x) if np.isfinite(x) else None for o, x in zip(OBJECTIVES, numbers, strict=True)}


def _worth(seen: Evaluated, checked: Checked | None) -> dict[str, Any]:
    """The objectives of a candidate by the search and by the check, and the shares of runs without a verdict."""
    worth: dict[str, Any] = {"objectives": _named(seen.objectives[0]), "undecided": float(seen.undecided[0])}
    if checked is None:
        return worth | {"checked": None, "checked_undecided": None}
    return worth | {"checked": _named(_numbers(checked)), "checked_undecided": float(checked.seen.undecided[0])}


def _summary(plan: Plan, findings: Findings, checked: np.ndarray) -> dict[str, Any]:
    holds, curve = _holds(plan, checked), findings.curve
    front = [
        {
            "bodies": p.bodies,
            "parameters": {v.name: float(x) for v, x in zip(plan.variables, p.numbers, strict=True)},
            **_worth(p.seen, p.checked),
            "holds": bool(holds[k]) if p.checked is not None else None,
        }
        for k, p in enumerate(findings.front)
    ]
    own = findings.own
    summary = {
        "sentence": "",
        "front": front,
        "found": findings.found,
        "objectives": list(plan.objectives),
        "model": plan.spec.model,
        "as_it_is": {
            "bodies": len(plan.machine.group(plan.machine.rotor)) - 1,
            "parameters": {v.name: float(x) for v, x in zip(plan.variables, plan.numbers, strict=True)},
            **_worth(own.seen, own.checked),
        },
        "variables": {v.name: {"paths": list(v.paths), "range": [v.low, v.high], "unit": v.unit} for v in plan.variables},
        "numbers_of_bodies": list(plan.trials),
        "unbalance": [end / plan.as_it_is.ends[0] * _unbalance(plan)[0] for end in plan.as_it_is.ends],
        "candidates": sum(len(g.numbers) for _, g in findings.tried),
        "samples": plan.spec.samples,
        "runs": plan.runs,
        "units": _units(plan),
        "damping": _damping(plan, curve),
        "integration": plan.way,
    }
    return summary | {"sentence": _sentence(summary)}


def _damping(plan: Plan, curve: DampingCurve | None) -> dict[str, Any] | None:
    if curve is None or plan.curve is None:
        return None
    ends = [float(curve.damping[0]), float(curve.damping[-1])]
    found = {"optimum": curve.optimum, "of_rates": curve.of_rates}
    known = {k: x if np.isfinite(x) else None for k, x in found.items()}
    return known | {"as_many": bool(np.ptp(curve.through) == 0), "range": ends, "unit": plan.curve[0].variables[0].unit}


def _unbalance(plan: Plan) -> tuple[float, float]:
    """The ends of the rotor's unbalance, in kg m."""
    if plan.spec.unbalance is not None:
        return plan.spec.unbalance
    values, name = plan.machine.values, plan.machine.rotor.name
    own = values.get(f"{name}.unbalance", values.get(f"{name}.eccentricity", 0.0) * values[f"{name}.mass"])
    return own, own


def _sentence(summary: dict[str, Any]) -> str:
    if not summary["front"]:
        return "no front is known yet" if not summary["candidates"] else "no candidate has all objectives"
    checked = [p for p in summary["front"] if p["checked"] is not None]
    held = sum(bool(p["holds"]) for p in checked)
    points = "1 point" if summary["found"] == 1 else f"{summary['found']} points"
    named = f"a front of {points} from {summary['candidates']} candidates"
    return f"{named}; {held} of {len(checked)} checked ones are on it by the check too"


def _warnings(plan: Plan, findings: Findings, checked: np.ndarray) -> list[str]:
    warnings = [*plan.warnings, *_apart(plan, findings, checked)]
    if why := next((p.checked.why for p in findings.front if p.checked is not None and p.checked.why), ""):
        warnings.append(f"what the bodies leave is not checked with the full equations: {why}")
    warnings += _undecided(plan, findings)
    if findings.front and len(findings.front) < findings.found:
        warnings.append(f"{len(findings.front)} points, spread over the front, stand for its {findings.found}")
    done, whole = sum(len(g.numbers) for _, g in findings.tried), len(plan.trials) * plan.generations * plan.spec.population
    if not findings.front and done and done >= whole:
        warnings.append(
            "no candidate has all objectives: none of its runs gets through, or the parts do not allow it; try other ranges"
        )
    return warnings


def _undecided(plan: Plan, findings: Findings) -> list[str]:
    shares = _of([findings.own.seen, *(g for _, g in findings.tried)], "undecided")
    if not shares.any():
        return []
    what = "the settling time is at least, the share that does not get through at most what is told"
    longer = "; a longer study.until may tell" if plan.spec.until is not None else "; a smaller study.tolerance may tell"
    count = int((shares > 0).sum())
    which = "1 candidate has" if count == 1 else f"{count} candidates have"
    return [f"{which} runs without a verdict, up to {percent(shares.max())}: {what}{longer}"]


def _apart(plan: Plan, findings: Findings, checked: np.ndarray) -> list[str]:
    """In what, and at how many points, the check differs from the search by more than chance."""
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
    """By how much the objectives (4,) of a candidate may differ, from one draw of phases to another."""
    count, share = plan.spec.samples, (search.objectives[0, CAPTURE] + check.objectives[0, CAPTURE]) / 2
    allowed = np.empty(len(OBJECTIVES))
    allowed[SETTLING] = _FAR * search.objectives[0, SETTLING] + _CHANCE * np.hypot(search.error[0], check.error[0])
    allowed[RESIDUAL] = _RESIDUAL * max(_unbalance(plan))
    allowed[PEAK] = _PEAK * search.objectives[0, PEAK]
    allowed[CAPTURE] = 1 / count + _CHANCE * np.sqrt(2 * share * (1 - share) / count)
    return allowed
