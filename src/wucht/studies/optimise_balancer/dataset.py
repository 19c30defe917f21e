"""Findings -> the Dataset of a search: the front, what the full equations say of it, all that was tried, the damping curve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import Variable, answered, variable
from wucht.studies.ensembles.member_outcomes import OUTCOMES
from wucht.studies.optimise_balancer.pareto_search import not_dominated
from wucht.studies.optimise_balancer.prepare import Plan
from wucht.studies.optimise_balancer.run import Checked, Findings
from wucht.studies.optimise_balancer.spec import OBJECTIVES

if TYPE_CHECKING:
    import xarray as xr

_FAR = 0.2  # relative: times and amplitudes that differ by more are warned of
_RESIDUAL = 0.01  # of the greatest unbalance
_RUNS = 1.5  # of a candidate: shares that differ by more are warned of


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a search.

    Coordinates: objective and variable (names), point (of the front), candidate (all that were tried), damping. Variables:
    front_value (point, variable) in SI, front_bodies, front_objective (point, objective) by the equations of the search,
    front_checked likewise by the full ones, front_outcome (point, outcome) shares of the runs, front_holds: whether no other
    checked point is better by the full equations; tried_value, tried_bodies, tried_objective; own_objective and own_checked of
    the machine as it is; settling_time, well and decay_rate over the damping.
    """
    import xarray as xr_

    front, columns = findings.front, len(OBJECTIVES)
    checked = np.array([_numbers(p.checked) for p in front]).reshape(len(front), columns)
    units = _units(plan)
    told = f"{', '.join(f'{o} in {u or 1}' for o, u in units.items())}"
    data: dict[str, Variable] = {
        "front_value": variable("point variable", _stack([p.numbers for p in front], len(plan.variables)), "values, in SI"),
        "front_bodies": variable("point", np.array([p.bodies for p in front], int), "number of bodies"),
        "front_objective": variable(
            "point objective", _stack([p.objectives for p in front], columns), f"by the search: {told}"
        ),
        "front_checked": variable("point objective", checked, f"by the full equations: {told}"),
        "front_outcome": variable("point outcome", _stack([p.outcomes for p in front], len(OUTCOMES)), "share of the runs"),
        "front_holds": variable("point", _holds(plan, checked).astype(np.int8), "not dominated by the full equations"),
        "tried_value": variable(
            "candidate variable",
            _stack([row for _, g in findings.tried for row in g.numbers], len(plan.variables)),
            "values, in SI",
        ),
        "tried_bodies": variable(
            "candidate", np.array([n for n, g in findings.tried for _ in g.numbers], int), "number of bodies"
        ),
        "tried_objective": variable(
            "candidate objective", _stack([row for _, g in findings.tried for row in g.objectives], columns), told
        ),
        "own_objective": variable("objective", findings.own.seen.objectives[0], f"machine as it is, by the search: {told}"),
        "own_checked": variable("objective", _numbers(findings.own.checked), f"machine as it is, full equations: {told}"),
    }
    coordinates: dict[str, Any] = {
        "objective": variable("objective", np.array(OBJECTIVES, str), "objective"),
        "variable": variable("variable", np.array([v.name for v in plan.variables], str), "what is varied"),
        "outcome": variable("outcome", np.array(OUTCOMES, str), "outcome"),
    }
    if findings.curve is not None:
        c, time = findings.curve, plan.machine.units.time
        unit = plan.curve[0].variables[0].unit if plan.curve is not None else ""
        coordinates["damping"] = variable("damping", c.damping, "damping of the bodies", unit)
        data["settling_time"] = variable("damping", c.settling_time, "settling time, mean of the runs that end well", time)
        data["well"] = variable("damping", c.well, "share of the runs that end well")
        data["decay_rate"] = variable("damping", c.rate, "slowest rate of decay, linearised", f"1/{time}")
    summary, warnings = _summary(plan, findings, checked), _warnings(plan, findings, checked)
    return answered(xr_.Dataset(data, coords=coordinates), summary, summary["sentence"], warnings)


def _units(plan: Plan) -> dict[str, str]:
    return dict(zip(OBJECTIVES, (plan.machine.units.time, "kg m", plan.machine.orbit_unit, ""), strict=True))


def _stack(rows: list[np.ndarray], width: int) -> np.ndarray:
    return np.array(rows, float).reshape(len(rows), width)


def _numbers(checked: Checked | None) -> np.ndarray:
    """The objectives (4,) by the full equations; the residual of the state that stands there."""
    if checked is None:
        return np.full(len(OBJECTIVES), np.nan)
    numbers = checked.seen.objectives[0].copy()
    numbers[OBJECTIVES.index("residual")] = checked.residual
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


def _summary(plan: Plan, findings: Findings, checked: np.ndarray) -> dict[str, Any]:
    holds, curve = _holds(plan, checked), findings.curve
    front = [
        {
            "bodies": p.bodies,
            "parameters": {v.name: float(x) for v, x in zip(plan.variables, p.numbers, strict=True)},
            "objectives": _named(p.objectives),
            "checked": _named(checked[k]) if p.checked is not None else None,
            "holds": bool(holds[k]) if p.checked is not None else None,
        }
        for k, p in enumerate(findings.front)
    ]
    own = findings.own
    summary = {
        "sentence": "",
        "front": front,
        "found": findings.found,
        "objectives": list(plan.spec.objectives),
        "model": plan.model,
        "as_it_is": {
            "bodies": len(plan.machine.group(plan.machine.rotor)) - 1,
            "parameters": {v.name: float(x) for v, x in zip(plan.variables, plan.numbers, strict=True)},
            "objectives": _named(own.seen.objectives[0]),
            "checked": _named(_numbers(own.checked)),
            "captured": float(own.seen.captured[0]),
            "undecided": float(own.seen.undecided[0]),
        },
        "variables": {v.name: {"paths": list(v.paths), "range": [v.low, v.high], "unit": v.unit} for v in plan.variables},
        "numbers_of_bodies": list(plan.trials),
        "unbalance": [end / plan.as_it_is.ends[0] * _unbalance(plan)[0] for end in plan.as_it_is.ends],
        "candidates": sum(len(g.numbers) for _, g in findings.tried),
        "samples": plan.spec.samples,
        "units": _units(plan),
        "damping": None if curve is None else {"optimum": curve.optimum, "of_rates": curve.of_rates},
        "integration": plan.way,
    }
    return summary | {"sentence": _sentence(summary)}


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
    named = f"a front of {summary['found']} points from {summary['candidates']} candidates"
    return f"{named}; {held} of {len(checked)} checked ones are on it by the full equations too"


def _warnings(plan: Plan, findings: Findings, checked: np.ndarray) -> list[str]:
    warnings = [*plan.warnings, *_apart(plan, findings, checked)]
    if why := next((p.checked.why for p in findings.front if p.checked is not None and p.checked.why), ""):
        warnings.append(f"what the bodies leave is not checked with the full equations: {why}")
    undecided = findings.own.seen.undecided[0]
    if undecided:
        warnings.append(
            f"of the machine as it is, {100 * undecided:.3g} % of the runs end neither well nor captured, or too late to tell"
        )
    if findings.front and len(findings.front) < findings.found:
        warnings.append(f"{len(findings.front)} points, spread over the front, stand for its {findings.found}")
    done, whole = sum(len(g.numbers) for _, g in findings.tried), len(plan.trials) * plan.generations * plan.spec.population
    if not findings.front and done and done >= whole:
        warnings.append(
            "no candidate has all objectives: none of its runs ends well, or the parts do not allow it; try other ranges"
        )
    return warnings


def _apart(plan: Plan, findings: Findings, checked: np.ndarray) -> list[str]:
    """In what, and at how many points, the full equations differ from those of the search."""
    allowed = {"residual": _RESIDUAL * max(_unbalance(plan)), "capture-probability": _RUNS / plan.spec.samples}
    known = [k for k, p in enumerate(findings.front) if p.checked is not None and not p.checked.why]
    told = []
    for column in plan.asked:
        name, unit = OBJECTIVES[column], _units(plan)[OBJECTIVES[column]]
        ours = np.array([findings.front[k].objectives[column] for k in known])
        theirs = checked[known, column]
        apart = ~(np.abs(theirs - ours) <= allowed.get(name, _FAR * np.abs(ours)))
        if not apart.any():
            continue
        worst = int(np.argmax(np.where(apart, np.nan_to_num(np.abs(theirs - ours), nan=np.inf), -1.0)))
        full = f"{theirs[worst]:.4g} {unit}".rstrip() if np.isfinite(theirs[worst]) else "none"
        numbers = f"at point {known[worst] + 1} {ours[worst]:.4g} {unit}".rstrip() + f" by the search, {full} by the full ones"
        told.append(f"the full equations give another {name} at {apart.sum()} of {len(known)} points: {numbers}")
    return told
