"""Findings -> the quantities of a map: outcomes, settling times, amplitudes, shares; and its lines in a report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.sampling.label_maps import error_bound, share, uncertainty
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.results.formatting import percent, report_lines
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.basin.computation import MISSING, Findings, Level, MapAxis, Plan
from wucht.studies.basin.system_basin import SystemBasinFindings, SystemBasinPlan
from wucht.studies.basin.system_basin_result import system_basin_dataset, system_basin_report

if TYPE_CHECKING:
    import xarray as xr


_NOT_COMPUTED = "not-computed"
_MOST_FAILURES = 3  # listed individually
_HEADLINES = ("compensated", "passed", "captured", "captured-modulated")


def dataset(plan: Plan | SystemBasinPlan, findings: Findings | SystemBasinFindings) -> xr.Dataset:
    """Build the Dataset of a map.

    Its dimensions have the names of the axes, such as psi and delta. With refined borders it has all variables once more on the
    finer cells (``refined_outcome``), where the parts of a coarser cell inherit its values.
    """
    if isinstance(findings, SystemBasinFindings):
        return system_basin_dataset(findings)
    assert isinstance(plan, Plan)
    base, last = findings.levels[0], findings.last
    quantities = _level_quantities(plan, base, "")
    if last is not base:
        cells, words = " ".join(_axes(plan, "refined_")[::-1]), "halvings after which the run was made (-1: not computed)"
        quantities += [
            *_level_quantities(plan, last, "refined_"),
            Quantity("refined_level", last.halvings_of, words, "", cells),
        ]
    names = {
        f"{k}_{word}": value for k, axis in zip("xy", plan.axes, strict=True) for word, value in _axis_attributes(axis).items()
    }
    summary = _summary_quantities(plan, findings)
    return result_dataset([*quantities, *summary], _sentence(summary), _warnings(plan, findings), **names)


def _axis_attributes(axis: MapAxis) -> dict[str, Any]:
    return {"axis": axis.name, "low": axis.low, "high": axis.high, "is_angle": int(axis.is_angle)}


def _axes(plan: Plan, prefix: str) -> list[str]:
    return [f"{prefix}{axis.name}" for axis in plan.axes]


def _level_quantities(plan: Plan, level: Level, prefix: str) -> list[Quantity]:
    """Coordinates and variables of a map on one level."""
    names, units = _axes(plan, prefix), plan.machine.units
    cells, length = " ".join(reversed(names)), plan.machine.orbit_unit
    of_mean = ", without ripple" if plan.spec.model == "slow" else ""  # the amplitude of the averaged vibration
    flags = {
        "flag_values": np.array([MISSING, *range(len(OUTCOMES))], np.int8),
        "flag_meanings": " ".join([_NOT_COMPUTED, *OUTCOMES]),
    }
    return [
        *(
            Quantity(name, axis.centres(level.halvings), axis.description, axis.unit, name)
            for name, axis in zip(names, plan.axes, strict=True)
        ),
        Quantity(f"{prefix}outcome", level.outcome, "outcome", "", cells, attributes=flags),
        Quantity(f"{prefix}settling_time", level.settling_time, "settling time", units.time, cells),
        Quantity(f"{prefix}peak_amplitude", level.peak_amplitude, f"peak amplitude{of_mean}", length, cells),
        Quantity(f"{prefix}end_time", level.end_time, "time until which the motion was integrated", units.time, cells),
    ]


def _summary_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    levels = [_shares(plan, level) for level in findings.levels]
    last, finest, time = findings.last, plan.shape(plan.spec.refine), plan.machine.units.time
    present = [OUTCOMES[k] for k in np.unique(last.outcome) if k != MISSING]
    time_ranges = {name: [float(f(last.end_time[_outcome_mask(last, name)])) for f in (np.min, np.max)] for name in present}
    axes = {
        axis.name: {"range": [axis.low, axis.high], "cells": axis.cells, "unit": axis.unit, "periodic": axis.is_periodic}
        for axis in plan.axes
    }
    failures = sum(len(t.members.failures) for level in findings.levels for t in level.tiles)
    return [
        Quantity("axes", axes, "axes of the map"),
        Quantity("model", plan.spec.model, "equations"),
        Quantity("fractions", levels[-1]["fractions"], "shares of the map by outcome", headline=_HEADLINES),
        Quantity("uncertainty", levels[-1]["uncertainty"], "uncertainty of the shares, in 19 of 20 cases"),
        Quantity("bound", levels[-1]["bound"], "largest error of the shares if the map resolves the borders"),
        Quantity("missing", levels[-1]["missing"], "share of the map that is not computed"),
        Quantity("runs", last.total_runs, "number of runs"),
        Quantity("runs_of_dense_map", finest[0] * finest[1], "number of cells of the finest map"),
        Quantity("levels", levels, "shares on each level of refinement"),
        Quantity("until", plan.spec.until, "time until which each motion is integrated", time),
        Quantity("followed", time_ranges, "least and greatest time until which motions of an outcome were integrated", time),
        Quantity("failures", failures, "number of runs that failed"),
        Quantity("integration", plan.way, "method of integration"),
        Quantity("amplitude_unit", plan.machine.orbit_unit, "unit of amplitudes"),
        Quantity("time_unit", time, "unit of times"),
    ]


def _outcome_mask(level: Level, outcome: Outcome) -> np.ndarray:
    return np.asarray(level.outcome == OUTCOMES.index(outcome))


def _shares(plan: Plan, level: Level) -> dict[str, Any]:
    """Shares of the outcomes on one level, with their uncertainty."""
    present = [OUTCOMES[k] for k in np.unique(level.outcome) if k != MISSING]
    inside = {str(name): _outcome_mask(level, name) for name in present}
    return {
        "cells": [level.shape[1], level.shape[0]],
        "runs": level.runs,
        "fractions": {name: share(cells) for name, cells in inside.items()},
        "uncertainty": {name: uncertainty(cells, plan.periodic) for name, cells in inside.items()},
        "bound": {name: error_bound(cells, plan.periodic) for name, cells in inside.items()},
        "missing": share(level.outcome == MISSING),
    }


def _sentence(summary: Sequence[Quantity]) -> str:
    fractions, off, missing = (next(q.value for q in summary if q.name == n) for n in ("fractions", "uncertainty", "missing"))
    order = sorted(fractions, key=lambda name: -fractions[name])
    parts = [f"{name} {percent(fractions[name], off[name])}" for name in order]
    parts += [f"{100 * missing:.3g} % not computed yet"] if missing else []
    return ", ".join(parts)


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    last, warnings = findings.last, list(plan.warnings)
    missing = int((last.outcome == MISSING).sum())
    if missing:
        warnings.append(f"{missing} of the {last.outcome.size} cells of the map are not computed; the shares are of all cells")
    elif last.halvings < plan.spec.refine:
        warnings.append(f"the borders are refined {last.halvings} of {plan.spec.refine} times")
    if (unknown := _outcome_mask(last, Outcome.UNIDENTIFIED)).any():
        low, high = (f"{f(last.end_time[unknown]):.4g}" for f in (np.min, np.max))
        unit = f" {plan.machine.units.time}" if plan.machine.units.time else ""
        until = f"{low}{unit}" if low == high else f"{low} to {high}{unit}"
        longer = "; a longer study.until may identify them" if plan.spec.until is not None else ""
        warnings.append(f"{100 * share(unknown):.3g} % of the map are unidentified, integrated until {until}{longer}")
    failures = [
        (level, int(t.cells[m]), reason) for level in findings.levels for t in level.tiles for m, reason in t.members.failures
    ]
    for level, cell, reason in failures[:_MOST_FAILURES]:
        at = zip(plan.axes, plan.place(cell, level.halvings), strict=True)
        place = ", ".join(f"{axis.name} = {value:.6g}" for axis, value in at)
        warnings.append(f"the run at {place} failed: {reason}")
    if len(failures) > _MOST_FAILURES:
        warnings.append(f"{len(failures) - _MOST_FAILURES} more runs failed")
    return warnings


_UNIDENTIFIED_KEY = "unidentified"


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a map of basins."""
    s = result.wucht.summary
    if "attractors" in s:
        return system_basin_report(result)
    levels = s["levels"]
    first, last = (" x ".join(map(str, levels[k]["cells"])) for k in (0, -1))
    refinement = f", at the borders halved to those of {last}" if len(levels) > 1 else ""
    lines = [("map", f"{first} cells over {' and '.join(s['axes'])}{refinement}"), ("runs", _runs(s))]
    if s["fractions"]:
        largest = 100 * max(s["bound"].values())
        most = f"the error is at most {largest:.2g} % if the map resolves the borders"
        lines.append(("shares", f"± holds in 19 of 20 cases; {most}"))
    if len(levels) > 1:
        for k, name in enumerate(s["fractions"]):
            shares = ", ".join(f"{100 * level['fractions'].get(name, 0.0):.4g} %" for level in levels)
            lines.append(("" if k else "by level", f"{name} {shares}"))
    lines.append(("integrated", s["integration"]))
    if _UNIDENTIFIED_KEY in s["fractions"]:
        low, high = (f"{t:.4g}" for t in s["followed"][_UNIDENTIFIED_KEY])
        until = (low if low == high else f"{low} to {high}") + (f" {s['time_unit']}" if s["time_unit"] else "")
        lines.append(("unidentified", f"{100 * s['fractions'][_UNIDENTIFIED_KEY]:.3g} % of the map, integrated until {until}"))
    if s["failures"]:
        lines.append(("failed", f"{s['failures']} run{'s' if s['failures'] > 1 else ''}: see the warnings"))
    return report_lines(result, s["sentence"] or "nothing is computed yet", lines)


def _runs(s: dict[str, Any]) -> str:
    if s["runs"] == s["runs_of_dense_map"]:
        return str(s["runs"])
    return f"{s['runs']}, instead of {s['runs_of_dense_map']} with one in each cell of the finest map"
