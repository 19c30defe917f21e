"""Findings -> the Dataset of a map: outcomes, settling times, amplitudes, and the shares of the outcomes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.sampling.label_maps import bound, share, uncertainty
from wucht.dynamics.sampling.member_outcomes import OUTCOMES
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.results.conventions import Variable, answered, variable
from wucht.results.formatting import percent
from wucht.studies.basin.map_axes import Axis
from wucht.studies.basin.prepare import Plan
from wucht.studies.basin.run import MISSING, Findings, Level

if TYPE_CHECKING:
    import xarray as xr

_NOT_COMPUTED = "not-computed"
_MOST_FAILURES = 3  # told one by one


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a map.

    Its dimensions have the names of the axes, such as psi and delta, and their coordinates are the centres of its cells.
    Variables (second axis, first axis): outcome, a flag, with its words in ``flag_meanings`` (-1: not computed); settling_time,
    not a number where the motion has not settled; peak_amplitude; end_time, until when it was followed. With refined borders
    the same on the finer cells: refined_psi, refined_delta, refined_outcome, ...: what a coarser cell hands down stands in each
    of its parts; refined_level, after how many halvings a cell's run was made.
    """
    import xarray as xr_

    base, last = findings.levels[0], findings.last
    coordinates, data = _of_level(plan, base, "")
    if last is not base:
        more, refined = _of_level(plan, last, "refined_")
        coordinates, data = coordinates | more, data | refined
        words = "halvings after which the run was made (-1: not computed)"
        data["refined_level"] = variable(" ".join(refined["refined_outcome"][0]), last.halvings_of, words)
    summary = _summary(plan, findings)
    names = {f"{k}_{word}": value for k, axis in zip("xy", plan.axes, strict=True) for word, value in _of_axis(axis).items()}
    return answered(xr_.Dataset(data, coords=coordinates), summary, summary["sentence"], _warnings(plan, findings), **names)


def _of_axis(axis: Axis) -> dict[str, Any]:
    return {"axis": axis.name, "low": axis.low, "high": axis.high, "is_angle": int(axis.angle)}


def _of_level(plan: Plan, level: Level, prefix: str) -> tuple[dict[str, Variable], dict[str, Variable]]:
    """Coordinates and variables of a map."""
    columns, rows = (f"{prefix}{axis.name}" for axis in plan.axes)
    coordinates = {
        name: variable(name, axis.centres(level.halvings), axis.what, axis.unit)
        for name, axis in zip((columns, rows), plan.axes, strict=True)
    }
    cells, units = f"{rows} {columns}", plan.machine.units
    of_mean = ", without ripple" if plan.spec.model == "slow" else ""  # that of the averaged vibration
    outcome = variable(cells, level.outcome, "outcome")
    outcome[2]["flag_values"] = np.array([MISSING, *range(len(OUTCOMES))], np.int8)  # type: ignore[assignment]
    outcome[2]["flag_meanings"] = " ".join([_NOT_COMPUTED, *OUTCOMES])
    data = {
        "outcome": outcome,
        "settling_time": variable(cells, level.settling_time, "settling time", units.time),
        "peak_amplitude": variable(cells, level.peak_amplitude, f"peak amplitude{of_mean}", plan.machine.orbit_unit),
        "end_time": variable(cells, level.end_time, "time until which the motion was followed", units.time),
    }
    return coordinates, {f"{prefix}{name}": values for name, values in data.items()}


def _summary(plan: Plan, findings: Findings) -> dict[str, Any]:
    levels = [_shares(plan, level) for level in findings.levels]
    last, finest = findings.last, plan.shape(plan.spec.refine)
    present = [OUTCOMES[k] for k in np.unique(last.outcome) if k != MISSING]
    of = {name: [float(f(last.end_time[_where(last, name)])) for f in (np.min, np.max)] for name in present}
    summary = {
        "sentence": "",
        "axes": {
            axis.name: {"range": [axis.low, axis.high], "cells": axis.cells, "unit": axis.unit, "periodic": axis.periodic}
            for axis in plan.axes
        },
        "model": plan.spec.model,
        "fractions": levels[-1]["fractions"],
        "uncertainty": levels[-1]["uncertainty"],
        "bound": levels[-1]["bound"],
        "missing": levels[-1]["missing"],
        "runs": last.total_runs,
        "runs_of_dense_map": finest[0] * finest[1],
        "levels": levels,
        "until": plan.spec.until,
        "followed": of,
        "failures": sum(len(t.members.failures) for level in findings.levels for t in level.tiles),
        "integration": plan.way,
        "amplitude_unit": plan.machine.orbit_unit,
        "time_unit": plan.machine.units.time,
    }
    return summary | {"sentence": _sentence(summary)}


def _where(level: Level, outcome: Outcome) -> np.ndarray:
    return np.asarray(level.outcome == OUTCOMES.index(outcome))


def _shares(plan: Plan, level: Level) -> dict[str, Any]:
    """Of the outcomes on one level, with their uncertainty."""
    present = [OUTCOMES[k] for k in np.unique(level.outcome) if k != MISSING]
    inside = {str(name): _where(level, name) for name in present}
    return {
        "cells": [level.shape[1], level.shape[0]],
        "runs": level.runs,
        "fractions": {name: share(cells) for name, cells in inside.items()},
        "uncertainty": {name: uncertainty(cells, plan.periodic) for name, cells in inside.items()},
        "bound": {name: bound(cells, plan.periodic) for name, cells in inside.items()},
        "missing": share(level.outcome == MISSING),
    }


def _sentence(summary: dict[str, Any]) -> str:
    fractions, off = summary["fractions"], summary["uncertainty"]
    order = sorted(fractions, key=lambda name: -fractions[name])
    parts = [f"{name} {percent(fractions[name], off[name])}" for name in order]
    parts += [f"{100 * summary['missing']:.3g} % not computed yet"] if summary["missing"] else []
    return ", ".join(parts)


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    last, warnings = findings.last, list(plan.warnings)
    missing = int((last.outcome == MISSING).sum())
    if missing:
        warnings.append(f"{missing} of the {last.outcome.size} cells of the map are not computed; the shares are of all cells")
    elif last.halvings < plan.spec.refine:
        warnings.append(f"the borders are refined {last.halvings} of {plan.spec.refine} times")
    if (unknown := _where(last, Outcome.UNIDENTIFIED)).any():
        low, high = (f"{f(last.end_time[unknown]):.4g}" for f in (np.min, np.max))
        unit = f" {plan.machine.units.time}" if plan.machine.units.time else ""
        until = f"{low}{unit}" if low == high else f"{low} to {high}{unit}"
        longer = "; a longer study.until may tell" if plan.spec.until is not None else ""
        warnings.append(f"{100 * share(unknown):.3g} % of the map are unidentified, followed until {until}{longer}")
    failures = [
        (level, int(t.cells[m]), why) for level in findings.levels for t in level.tiles for m, why in t.members.failures
    ]
    for level, cell, why in failures[:_MOST_FAILURES]:
        at = zip(plan.axes, plan.place(cell, level.halvings), strict=True)
        place = ", ".join(f"{axis.name} = {value:.6g}" for axis, value in at)
        warnings.append(f"the run at {place} failed: {why}")
    if len(failures) > _MOST_FAILURES:
        warnings.append(f"{len(failures) - _MOST_FAILURES} more runs failed")
    return warnings
