"""Findings -> the Dataset of a load spectrum, and its summary."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.machine_signals import LoadHistory
from wucht.fatigue.load_classes import RangeMeanMatrix, distance
from wucht.results.conventions import answered, variable
from wucht.studies.load_spectrum.counted_load import MOST_ROWS, CountedLoad, counted
from wucht.studies.load_spectrum.prepare import Plan, check_width

if TYPE_CHECKING:
    import xarray as xr

_MATRIX = 40  # classes of range and of mean
_COURSE, _IN_A_PART = 200, 8  # parts of time whose smallest and largest value are kept, and turning points in one
_CONVERGED = 0.05  # of the cycles, and of the damage: so much the spectrum may change with the second half of the run
_PART_OF_A_RUN = 2.0  # the half of it stands for the whole


def dataset(plan: Plan, findings: LoadHistory) -> xr.Dataset:
    """The Dataset.

    Over row (ascending range, or class of ranges): range, mean, count, cumulative (cycles of at least this range),
    half_cumulative (twice those of the first half of the time), damage (with a Woehler line). Over range_class and mean_class:
    matrix. Over part (of time): course_time, lowest, highest. Over level: crossings. Raises ``InputError`` for too narrow
    classes.
    """
    import xarray as xr_

    unit, time = plan.signal.unit, findings.time
    begin = plan.spec.after if plan.spec.after is not None else float(time[0]) if len(time) else 0.0
    middle = (begin + findings.end_time) / 2
    inside = time >= begin
    values = findings.values[inside]
    check_width(values, plan.class_width)
    whole = counted(plan, values)
    half = counted(plan, values[time[inside] <= middle], whole.levels if len(whole.levels) else None)
    matrix = RangeMeanMatrix.of(whole.cycles, _MATRIX)
    rows, middles = whole.rows, [(e[1:] + e[:-1]) / 2 for e in (matrix.range_edges, matrix.mean_edges)]
    least = np.full(len(rows.ranges), np.inf)  # of the cycles in each row
    np.minimum.at(least, whole.row, whole.cycles.ranges)
    data = {
        "range": variable("row", rows.ranges, "range", unit),
        "mean": variable("row", rows.means, "mean", unit),
        "count": variable("row", rows.counts, "cycles"),
        "cumulative": variable("row", whole.cycles.exceeding(least), "cycles of at least this range"),
        "half_cumulative": variable(
            "row", _PART_OF_A_RUN * half.cycles.exceeding(least), "the same, twice those of the first half"
        ),
        "matrix": variable("range_class mean_class", matrix.counts, "cycles"),
        **_course(findings, unit, plan.spec.after),
    }
    damages = None
    if plan.line is not None:
        damages = np.bincount(whole.row, plan.line.damages(whole.cycles), minlength=len(rows.ranges))
        line = {"k": plan.line.k, "ND": plan.line.ND, "SD": plan.line.SD, "k2": plan.line.k2}
        data["damage"] = variable("row", damages, "damage")
        data |= {f"woehler_{key}": variable("", x, f"Woehler line: {key}", unit * (key == "SD")) for key, x in line.items()}
    coordinates = {
        "range_class": variable("range_class", middles[0], "range", unit),
        "mean_class": variable("mean_class", middles[1], "mean", unit),
    }
    if len(whole.levels):
        coordinates["level"] = variable("level", whole.levels, "level", unit)
        data["crossings"] = variable("level", whole.crossings, "crossings")
    summary = _summary(plan, findings, whole, values, (begin, middle)) | _damage(plan, whole, half, findings.end_time - begin)
    summary["convergence"] = {
        "spectrum": distance(half.cycles, whole.cycles, _PART_OF_A_RUN),
        "largest_range": half.cycles.largest / whole.cycles.largest if whole.cycles.largest else None,
        "damage": _change_of_damage(plan, whole, half),
    }
    name = plan.signal.name[:1].upper() + plan.signal.name[1:]
    result = xr_.Dataset(dict(data.items()), coords=coordinates)
    outcome = {} if findings.verdict is None else {"outcome": summary["outcome"]}
    failure = findings.failure or _without_bounds(plan, summary)
    return answered(
        result, summary, _sentence(summary), _warnings(plan, findings, whole, summary), failure, signal=name, **outcome
    )


def _summary(
    plan: Plan, findings: LoadHistory, whole: CountedLoad, values: np.ndarray, times: tuple[float, float]
) -> dict[str, Any]:
    rows, largest = whole.rows, whole.cycles.largest
    keys = ("range", "mean", "count")
    columns = (rows.ranges.tolist(), rows.means.tolist(), rows.counts.tolist())
    verdict = findings.verdict
    return {
        "spectrum": [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)],
        "cycles": whole.cycles.total,
        "largest_range": largest,
        "min": float(values.min()) if len(values) else None,
        "max": float(values.max()) if len(values) else None,
        "signal": plan.signal.name,
        "unit": plan.signal.unit,
        "counting": plan.spec.counting,
        "residue": plan.spec.residue,
        "class_width": whole.class_width,
        "turning_points": len(values),
        "begin": times[0],
        "half": times[1],
        "end": findings.end_time,
        "outcome": None if verdict is None else str(verdict.outcome),
    }


def _damage(plan: Plan, whole: CountedLoad, half: CountedLoad, duration: float) -> dict[str, Any]:
    """Miner's sum, and how often the part bears what was counted, and for how long; nothing without a Woehler line."""
    if plan.line is None:
        return {"damage": None, "repetitions": None, "life": None}
    damage = float(plan.line.damages(whole.cycles).sum())
    return {
        "damage": damage,
        "repetitions": 1 / damage if damage else None,
        "life": duration / damage if damage else None,
        "damage_of_half": float(plan.line.damages(half.cycles).sum()),
    }


def _without_bounds(plan: Plan, summary: dict[str, Any]) -> str | None:
    """Why the damage is no finite number, None if it is one."""
    if plan.line is None or math.isfinite(summary["damage"]):
        return None
    times = f"{summary['largest_range'] / 2 / plan.line.SD:.3g} times study.woehler.SD"
    return f"the damage is too large for a number: the largest amplitude is {times}; check their units, and the slope k"


def _change_of_damage(plan: Plan, whole: CountedLoad, half: CountedLoad) -> float | None:
    """By how much the damage differs from twice that of the first half, relative."""
    if plan.line is None:
        return None
    damage = float(plan.line.damages(whole.cycles).sum())
    return _PART_OF_A_RUN * float(plan.line.damages(half.cycles).sum()) / damage - 1 if damage else None


def _course(findings: LoadHistory, unit: str, after: float | None) -> dict[str, Any]:
    """The smallest and the largest value of the signal in parts of time; all turning points where they are few."""
    time, values = findings.time, findings.values
    low, high = values, values
    if len(values) > _COURSE * _IN_A_PART:
        edges = np.linspace(time[0], findings.end_time, _COURSE + 1)
        part = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, _COURSE - 1)
        low, high = np.full(_COURSE, np.inf), np.full(_COURSE, -np.inf)
        np.minimum.at(low, part, values)
        np.maximum.at(high, part, values)
        seen = np.isfinite(low)
        time, low, high = ((edges[1:] + edges[:-1])[seen] / 2, low[seen], high[seen])
    return {
        "course_time": variable("part", time, "time", "s"),
        "lowest": variable("part", low, "lowest value", unit),
        "highest": variable("part", high, "highest value", unit),
        "counted_from": variable("", after, "time from which on is counted", "s"),
    }


def _sentence(summary: dict[str, Any]) -> str:
    if not summary["cycles"]:
        return "there is no cycle to count"
    unit = f" {summary['unit']}" if summary["unit"] else ""
    said = f"{summary['cycles']:.10g} cycles, the largest of range {summary['largest_range']:.4g}{unit}"
    return said if summary["damage"] is None else f"{said}; damage {summary['damage']:.4g}"


def _warnings(plan: Plan, findings: LoadHistory, whole: CountedLoad, summary: dict[str, Any]) -> list[str]:
    warnings = list(plan.warnings)
    if plan.case is not None:
        warnings += [*plan.case.horizon.warnings, *plan.case.models[0].warnings]
        warnings = [w for w in warnings if "samples a turn are stored" not in w]  # nothing is stored here
    warnings += [findings.failure] if findings.failure else []
    warnings += [findings.verdict.advice] if findings.verdict is not None and findings.verdict.advice else []
    if not whole.cycles.total:
        after = (
            ""
            if plan.spec.after is None
            else f" after study.after = {plan.spec.after:g}, and the run ends at {findings.end_time:g}"
        )
        return [*warnings, f"the signal does not turn back{after}: nothing was counted"]
    if plan.class_width is None and whole.class_width is not None and plan.spec.counting != "level-crossing":
        width = f"{whole.class_width:.4g} {plan.signal.unit}".rstrip()
        classes = f"there are more than {MOST_ROWS} different ranges: the spectrum has classes of {width}"
        warnings.append(f"{classes}; the damage is that of the single cycles")
    change, damage = summary["convergence"]["spectrum"], summary["convergence"]["damage"]
    if findings.verdict is not None and max(change, abs(damage or 0.0)) > _CONVERGED:
        of_damage = "" if damage is None else f", and the damage by {abs(damage):.1%}"
        warnings.append(
            f"the spectrum is not converged: from half the time to the whole the cumulative counts change by {change:.1%} of "
            f"all cycles{of_damage}; run longer, or leave out more of the run-up with study.after"
        )
    return warnings
