"""Findings -> the quantities of a load spectrum, and its lines in a report."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.bearing_loads import bearing_warnings, lives_of
from wucht.dynamics.run_ups.machine_signals import LoadHistory
from wucht.fatigue.counted_cycles import RangeMeanMatrix, frequency_distance
from wucht.results.attributes import text_in
from wucht.results.bearing_text import life_text
from wucht.results.formatting import report_lines, unit_in_print
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.bearing_variables import life_quantities
from wucht.studies.load_spectrum.computation import MOST_ROWS, CountedLoad, Plan, check_width, count_load

if TYPE_CHECKING:
    import xarray as xr


_MATRIX = 40  # classes of range and of mean
_COURSE, _IN_A_PART = 200, 8  # intervals of time with their least and greatest value, and turning points in one
_CONVERGENCE_LIMIT = 0.05  # of the cycles, and of the damage: largest change by the second half of a converged run
_PART_OF_A_RUN = 2.0  # the first half, repeated so often, is compared with the whole


def dataset(plan: Plan, findings: LoadHistory) -> xr.Dataset:
    """Return the Dataset of a load spectrum. Raises ``InputError`` for too narrow classes."""
    time, verdict = findings.time, findings.verdict
    begin = plan.spec.after if plan.spec.after is not None else float(time[0]) if len(time) else 0.0
    middle = (begin + findings.end_time) / 2
    inside = time >= begin
    values = findings.values[inside]
    check_width(values, plan.class_width)
    whole = count_load(plan, values)
    half = count_load(plan, values[time[inside] <= middle], whole.levels if len(whole.levels) else None)
    damages = None if plan.line is None else [float(plan.line.damages(load.cycles).sum()) for load in (whole, half)]
    convergence = {
        "spectrum": frequency_distance(half.cycles, whole.cycles, _PART_OF_A_RUN),
        "largest_range": half.cycles.largest / whole.cycles.largest if whole.cycles.largest else None,
        "damage": _PART_OF_A_RUN * damages[1] / damages[0] - 1 if damages and damages[0] else None,
    }
    parts = {
        "spectrum": ("change of the cumulative counts, as a share of all cycles", ""),
        "largest_range": ("largest range of the first half, as a share of that of the whole", ""),
        "damage": ("relative change of the damage", ""),
    }
    lives = {} if plan.case is None else lives_of(plan.case.machine, findings.duties)
    outcome, unit_of_time = None if verdict is None else str(verdict.outcome), _time(plan)
    quantities = [
        *_row_quantities(plan, whole, half),
        *_class_quantities(plan, whole),
        *_signal_quantities(plan, findings, values),
        *_damage_quantities(plan, damages, findings.end_time - begin),
        *life_quantities(lives),
        Quantity("counting", plan.spec.counting, "way of counting"),
        Quantity("residue", plan.spec.residue, "treatment of cycles that do not close"),
        Quantity("begin", begin, "time from which counting starts", unit_of_time),
        Quantity("half", middle, "time in the middle of the counted interval", unit_of_time),
        Quantity("end", findings.end_time, "time at which counting ends", unit_of_time),
        Quantity("outcome", outcome, "outcome of the run-up"),
        Quantity("convergence", convergence, "the whole compared with twice its first half", parts=parts),
    ]
    sentence = _sentence(plan, whole, damages)
    warnings = _warnings(plan, findings, whole, convergence) + bearing_warnings(lives)
    name = plan.signal.name[:1].upper() + plan.signal.name[1:]
    failure = findings.failure or _damage_overflow(plan, whole, damages)
    return result_dataset(
        quantities, sentence, warnings, (), failure, signal=name, **({} if outcome is None else {"outcome": outcome})
    )


def _row_quantities(plan: Plan, whole: CountedLoad, half: CountedLoad) -> list[Quantity]:
    """Return the spectrum: each range, or class of ranges, with mean and cycles; with a Woehler line, its damage."""
    unit, rows, line = plan.signal.unit, whole.rows, plan.line
    keys, columns = ("range", "mean", "count"), (rows.ranges.tolist(), rows.means.tolist(), rows.counts.tolist())
    spectrum = [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]
    parts = {"range": ("range", unit), "mean": ("mean", unit), "count": ("cycles", "")}
    least = np.full(len(rows.ranges), np.inf)  # of the cycles in each row
    np.minimum.at(least, whole.row, whole.cycles.ranges)
    twice = _PART_OF_A_RUN * half.cycles.cumulative_frequency(least)
    quantities = [
        Quantity("spectrum", spectrum, "ranges with their cycles, ascending", parts=parts),
        Quantity("range", rows.ranges, "range", unit, "row"),
        Quantity("mean", rows.means, "mean", unit, "row"),
        Quantity("count", rows.counts, "cycles", "", "row"),
        Quantity("cumulative", whole.cycles.cumulative_frequency(least), "cycles of at least this range", "", "row"),
        Quantity("half_cumulative", twice, "the same, twice those of the first half", "", "row"),
    ]
    if line is None:
        return quantities
    damages = np.bincount(whole.row, line.damages(whole.cycles), minlength=len(rows.ranges))
    line_parts = {"k": (line.k, ""), "ND": (line.ND, ""), "SD": (line.SD, unit), "k2": (line.k2, "")}
    quantities += [Quantity(f"woehler_{key}", x, f"Woehler line: {key}", u, "") for key, (x, u) in line_parts.items()]
    return [*quantities, Quantity("damage", damages, "damage", "", "row")]


def _class_quantities(plan: Plan, whole: CountedLoad) -> list[Quantity]:
    """Return the matrix of ranges and means, and the crossings of levels if they are counted."""
    unit, matrix = plan.signal.unit, RangeMeanMatrix.of(whole.cycles, _MATRIX)
    ranges, means = ((e[1:] + e[:-1]) / 2 for e in (matrix.range_edges, matrix.mean_edges))
    quantities = [
        Quantity("range_class", ranges, "range", unit, "range_class"),
        Quantity("mean_class", means, "mean", unit, "mean_class"),
        Quantity("matrix", matrix.counts, "cycles", "", "range_class mean_class"),
        Quantity("class_width", whole.class_width, "width of the classes of ranges, or distance of the levels", unit),
    ]
    if len(whole.levels):
        quantities += [
            Quantity("level", whole.levels, "level", unit, "level"),
            Quantity("crossings", whole.crossings, "crossings", "", "level"),
        ]
    return [
        *quantities,
        Quantity("cycles", whole.cycles.total, "number of cycles", headline=True),
        Quantity("largest_range", whole.cycles.largest, "largest range", unit),
    ]


def _damage_quantities(plan: Plan, damages: list[float] | None, duration: float) -> list[Quantity]:
    """Return Miner's sum of the whole and of its first half, and the life of the part in repetitions and in time."""
    damage = damages[0] if damages else None
    quantities = [
        Quantity("damage", damage, "Miner's sum", headline=True),
        Quantity("repetitions", 1 / damage if damage else None, "repetitions of this load until failure"),
        Quantity("life", duration / damage if damage else None, "life of the part under this load", _time(plan)),
    ]
    return [*quantities, Quantity("damage_of_half", damages[1], "Miner's sum of the first half")] if damages else quantities


def _time(plan: Plan) -> str:
    return "s" if plan.case is None else plan.case.machine.units.time


def _damage_overflow(plan: Plan, whole: CountedLoad, damages: list[float] | None) -> str | None:
    """Return the reason why the damage is no finite number, None if it is one."""
    if plan.line is None or damages is None or math.isfinite(damages[0]):
        return None
    times = f"{whole.cycles.largest / 2 / plan.line.SD:.3g} times study.woehler.SD"
    return f"the damage is too large for a number: the largest amplitude is {times}; check the units of both, and the slope k"


def _signal_quantities(plan: Plan, findings: LoadHistory, counted_values: np.ndarray) -> list[Quantity]:
    """Return the signal with its mean, least and greatest value in intervals of time; all turning points where they are few.

    The mean is that of straight lines through the turning points, as only these are kept.
    """
    time, values, unit = findings.time, findings.values, plan.signal.unit
    low, high, mean = values, values, values
    if len(values) > _COURSE * _IN_A_PART:
        edges = np.linspace(time[0], findings.end_time, _COURSE + 1)
        part = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, _COURSE - 1)
        low, high = np.full(_COURSE, np.inf), np.full(_COURSE, -np.inf)
        np.minimum.at(low, part, values)
        np.maximum.at(high, part, values)
        nonempty = np.isfinite(low)
        knots = np.union1d(time, edges)
        heights = np.interp(knots, time, values)
        integral = np.append(0.0, np.cumsum((heights[1:] + heights[:-1]) / 2 * np.diff(knots)))
        mean = np.diff(integral[np.searchsorted(knots, edges)]) / np.diff(edges)
        time, low, high, mean = (x[nonempty] for x in ((edges[1:] + edges[:-1]) / 2, low, high, mean))
    least, greatest = (float(f(counted_values)) if len(counted_values) else None for f in (np.min, np.max))
    return [
        Quantity("signal", plan.signal.name, "signal that is counted"),
        Quantity("unit", unit, "unit of the signal"),
        Quantity("min", least, "smallest value", unit),
        Quantity("max", greatest, "largest value", unit),
        Quantity("turning_points", len(counted_values), "number of turning points"),
        Quantity("course_time", time, "time", _time(plan), "part", coordinate=True),
        Quantity("lowest", low, "lowest value", unit, "part"),
        Quantity("highest", high, "highest value", unit, "part"),
        Quantity("average", mean, "mean value", unit, "part"),
        Quantity("counted_from", plan.spec.after, "time from which counting starts", _time(plan), ""),
    ]


def _sentence(plan: Plan, whole: CountedLoad, damages: list[float] | None) -> str:
    if not whole.cycles.total:
        return "there is no cycle to count"
    factor, unit = unit_in_print(plan.signal.unit)
    largest = f"{factor * whole.cycles.largest:.4g} {unit}".rstrip()
    counted_cycles = f"{whole.cycles.total:.10g} cycles, the largest of range {largest}"
    return counted_cycles if damages is None else f"{counted_cycles}; damage {damages[0]:.4g}"


def _warnings(plan: Plan, findings: LoadHistory, whole: CountedLoad, convergence: dict[str, Any]) -> list[str]:
    warnings = list(plan.warnings)
    if plan.case is not None:
        warnings += [*plan.case.horizon.warnings, *plan.case.models[0].warnings]
        warnings = [w for w in warnings if "samples a turn are stored" not in w]  # nothing is stored here
    warnings += [findings.failure] if findings.failure else []
    if plan.case is not None and findings.verdict is not None:
        unit = plan.case.machine.units.time
        warnings += plan.case.horizon.limit_warnings(findings.end_time, findings.verdict, unit)
    warnings += [findings.verdict.advice] if findings.verdict is not None and findings.verdict.advice else []
    if not whole.cycles.total:
        after = plan.spec.after
        late = "" if after is None else f" after study.after = {after:g}, and the run ends at {findings.end_time:g}"
        return [*warnings, f"the signal has no turning points{late}: nothing was counted"]
    if plan.class_width is None and whole.class_width is not None and plan.spec.counting != "level-crossing":
        width = f"{whole.class_width:.4g} {plan.signal.unit}".rstrip()
        classes = f"there are more than {MOST_ROWS} different ranges: the spectrum has classes of {width}"
        warnings.append(f"{classes}; the damage is that of the single cycles")
    change, damage = convergence["spectrum"], convergence["damage"]
    if findings.verdict is not None and max(change, abs(damage or 0.0)) > _CONVERGENCE_LIMIT:
        damage_change = "" if damage is None else f", and the damage by {100 * abs(damage):.1f} %"
        warnings.append(
            f"the spectrum is not converged: from half the time to the whole the cumulative counts change by "
            f"{100 * change:.1f} % of all cycles{damage_change}; run longer, or leave out more of the run-up with study.after"
        )
    return warnings


_MOST_RANGES = 6
_RESIDUES = {
    "half-cycles": "the residue counts as half cycles",
    "repeat": "the history is repeated, so that all cycles close",
    "drop": "the residue is left out",
}


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a load spectrum."""
    s = result.wucht.summary
    unit = f" {s['unit']}" if s["unit"] else ""
    time_unit = "" if result.attrs["dimensionless"] else " s"
    lines = [("signal", f"{text_in(result, 'signal')}, from {s['begin']:.6g} to {s['end']:.6g}{time_unit}")]
    if s["outcome"] is not None:
        lines.append(("machine", str(s["outcome"])))
    lines.append(("counting", f"{s['counting']}; {_RESIDUES[s['residue']]}"))
    if s["cycles"]:
        lines.append(("between", f"{s['min']:.5g} and {s['max']:.5g}{unit}"))
        rows = sorted(s["spectrum"], key=lambda row: -row["range"])
        for name, row in zip(["range"] + [""] * _MOST_RANGES, rows[:_MOST_RANGES], strict=False):
            lines.append((name, f"{row['range']:.5g}{unit}, mean {row['mean']:.5g}{unit}: {row['count']:.10g}"))
        if len(rows) > _MOST_RANGES:
            lines.append(("", f"and {len(rows) - _MOST_RANGES} smaller ones"))
    if s["damage"] is not None:
        lines.append(("damage", f"{s['damage']:.5g}"))
    if s["life"] is not None:
        hours = "" if result.attrs["dimensionless"] else f" ({s['life'] / 3600:.4g} h)"
        lines.append(("life", f"{s['repetitions']:.5g} repetitions, {s['life']:.5g}{time_unit}{hours}"))
    if life := life_text(s):
        lines.append(("bearing life", life))
    if s["cycles"]:
        c = s["convergence"]
        damage = "" if c["damage"] is None else f", and the damage by {100 * abs(c['damage']):.2f} %"
        lines.append(
            (
                "convergence",
                f"doubling the first half changes the counts by {100 * c['spectrum']:.2f} % of all cycles{damage}",
            )
        )
    return report_lines(result, result.attrs["sentence"], lines)
