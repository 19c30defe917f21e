"""The answer of a map of outcomes: the number of each cell, the shares with their uncertainty, and doubts."""

from __future__ import annotations

from typing import Any

import numpy as np

from wucht.dynamics.sampling.ensemble_run import integration_note
from wucht.dynamics.sampling.label_maps import error_bound, share, uncertainty
from wucht.dynamics.sampling.outcome_maps import MISSING, Level, OutcomeMap
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.results.formatting import percent
from wucht.studies.answer import Answer

_NOT_COMPUTED = "not-computed"
_MOST_FAILURES = 3  # listed individually
_HEADLINES = ("compensated", "passed", "captured", "captured-modulated")


def state_outcomes(map_: OutcomeMap, omissions: tuple[str, ...], refine: int, last: Level, a: Answer) -> None:
    """State the answer as far as it is known on the last of ``refine`` levels.

    The dimensions have the names of the axes, such as psi and delta. With refined borders there are all variables once more on
    the finer cells (``refined_outcome``), where the parts of a coarser cell inherit its values.
    """
    machine, levels = map_.question.machine, last.with_coarser_ones
    _state_cells(a, map_, levels[0], "")
    if last.coarser is not None:
        cells, words = _state_cells(a, map_, last, "refined_"), "halvings after which the run was made (-1: not computed)"
        a.curve("refined_level", last.halvings_of, words, "", cells)
    for k, axis in zip("xy", map_.axes, strict=True):
        ends = {"axis": axis.name, "low": axis.low, "high": axis.high, "is_angle": int(axis.is_angle)}
        a.attribute(**{f"{k}_{word}": value for word, value in ends.items()})
    axes = {
        axis.name: {"range": [axis.low, axis.high], "cells": axis.cells, "unit": axis.unit, "periodic": axis.is_periodic}
        for axis in map_.axes
    }
    a.number("axes", axes, "axes of the map")
    _state_shares(a, map_, refine, levels)
    a.number("model", map_.question.model, "equations")
    a.line("integrated", a.number("integration", integration_note(map_.question), "method of integration"))
    a.number("amplitude_unit", machine.orbit_unit, "unit of amplitudes")
    a.number("time_unit", a.unit("time"), "unit of times")
    a.number("until", map_.question.until, "time until which each motion is integrated", "time")
    a.warn(*omissions)
    _warn_of_missing_cells(a, refine, last)
    _state_times(a, map_, last)
    _state_failures(a, map_, levels)


def _state_cells(a: Answer, map_: OutcomeMap, level: Level, prefix: str) -> str:
    """State coordinates and variables of a map on one level, and return their dimensions."""
    cells = f"{prefix}{map_.axes[1].name} {prefix}{map_.axes[0].name}"
    of_mean = ", without ripple" if map_.question.model == "slow" else ""  # the amplitude of the averaged vibration
    flags = {
        "flag_values": np.array([MISSING, *range(len(OUTCOMES))], np.int8),
        "flag_meanings": " ".join([_NOT_COMPUTED, *OUTCOMES]),
    }
    for axis in map_.axes:
        a.curve(f"{prefix}{axis.name}", axis.centres(level.halvings), axis.description, axis.unit)
    length = map_.question.machine.orbit_unit
    a.curve(f"{prefix}outcome", level.outcome, "outcome", "", cells, attributes=flags)
    a.curve(f"{prefix}settling_time", level.settling_time, "settling time", "time", cells)
    a.curve(f"{prefix}peak_amplitude", level.peak_amplitude, f"peak amplitude{of_mean}", length, cells)
    a.curve(f"{prefix}end_time", level.end_time, "time until which the motion was integrated", "time", cells)
    return cells


def _outcome_mask(level: Level, outcome: Outcome) -> np.ndarray:
    return np.asarray(level.outcome == OUTCOMES.index(outcome))


def _outcome_masks(level: Level) -> dict[str, np.ndarray]:
    """The cells of each outcome that occurs."""
    return {str(OUTCOMES[k]): level.outcome == k for k in np.unique(level.outcome) if k != MISSING}


def _shares(map_: OutcomeMap, level: Level) -> dict[str, Any]:
    """Shares of the outcomes on one level, with their uncertainty."""
    inside = _outcome_masks(level)
    return {
        "cells": [level.shape[1], level.shape[0]],
        "runs": level.runs,
        "fractions": {name: share(cells) for name, cells in inside.items()},
        "uncertainty": {name: uncertainty(cells, map_.periodic) for name, cells in inside.items()},
        "bound": {name: error_bound(cells, map_.periodic) for name, cells in inside.items()},
        "missing": share(level.outcome == MISSING),
    }


def _state_shares(a: Answer, map_: OutcomeMap, refine: int, levels: tuple[Level, ...]) -> None:
    """State the shares of the outcomes on each level, and the answer in one sentence."""
    shares, (rows, columns), runs = [_shares(map_, level) for level in levels], map_.shape(refine), levels[-1].total_runs
    last = shares[-1]
    fractions, errors, missing = last["fractions"], last["uncertainty"], last["missing"]
    a.number("fractions", fractions, "shares of the map by outcome", headline=_HEADLINES)
    a.number("uncertainty", errors, "uncertainty of the shares, in 19 of 20 cases")
    a.number("bound", last["bound"], "largest error of the shares if the map resolves the borders")
    a.number("missing", missing, "share of the map that is not computed")
    a.number("runs", runs, "number of runs")
    a.number("runs_of_dense_map", rows * columns, "number of cells of the finest map")
    a.number("levels", shares, "shares on each level of refinement")
    order = sorted(fractions, key=lambda name: -fractions[name])
    clauses = [f"{name} {percent(fractions[name], errors[name])}" for name in order]
    a.sentence = ", ".join([*clauses, *([f"{100 * missing:.3g} % not computed yet"] if missing else [])])
    first_cells, last_cells = (" x ".join(map(str, one["cells"])) for one in (shares[0], last))
    refinement = f", at the borders halved to those of {last_cells}" if len(levels) > 1 else ""
    a.line("map", f"{first_cells} cells over {' and '.join(axis.name for axis in map_.axes)}{refinement}")
    dense = f", instead of {rows * columns} with one in each cell of the finest map"
    a.line("runs", f"{runs}{dense if runs != rows * columns else ''}")
    if fractions:
        most = f"the error is at most {100 * max(last['bound'].values()):.2g} % if the map resolves the borders"
        a.line("shares", f"± holds in 19 of 20 cases; {most}")
    for k, name in enumerate(fractions if len(levels) > 1 else ()):
        by_level = ", ".join(f"{100 * one['fractions'].get(name, 0.0):.4g} %" for one in shares)
        a.line("" if k else "by level", f"{name} {by_level}")


def _warn_of_missing_cells(a: Answer, refine: int, last: Level) -> None:
    missing = int((last.outcome == MISSING).sum())
    if missing:
        a.warn(f"{missing} of the {last.outcome.size} cells of the map are not computed; the shares are of all cells")
    elif last.halvings < refine:
        a.warn(f"the borders are refined {last.halvings} of {refine} times")


def _state_times(a: Answer, map_: OutcomeMap, last: Level) -> None:
    """State how long motions were integrated, and warn of those that this was too short for."""
    times = {name: [float(f(last.end_time[cells])) for f in (np.min, np.max)] for name, cells in _outcome_masks(last).items()}
    a.number("followed", times, "least and greatest time until which motions of an outcome were integrated", "time")
    cells = _outcome_mask(last, Outcome.UNIDENTIFIED)
    if not cells.any():
        return
    low, high = (f"{t:.4g}" for t in times[Outcome.UNIDENTIFIED])
    until = f"{low if low == high else f'{low} to {high}'} {a.unit('time')}".rstrip()
    part = f"{100 * share(cells):.3g} % of the map"
    longer = "; a longer study.until may identify them" if map_.question.until is not None else ""
    a.warn(f"{part} are unidentified, integrated until {until}{longer}")
    a.line("unidentified", f"{part}, integrated until {until}")


def _state_failures(a: Answer, map_: OutcomeMap, levels: tuple[Level, ...]) -> None:
    failures = [
        (map_.place(int(tile.cells[m]), level.halvings), reason)
        for level in levels
        for tile in level.tiles
        for m, reason in tile.members.failures
    ]
    count = a.number("failures", len(failures), "number of runs that failed")
    for place, reason in failures[:_MOST_FAILURES]:
        location = ", ".join(f"{axis.name} = {value:.6g}" for axis, value in zip(map_.axes, place, strict=True))
        a.warn(f"the run at {location} failed: {reason}")
    if count > _MOST_FAILURES:
        a.warn(f"{count - _MOST_FAILURES} more runs failed")
    if count:
        a.line("failed", f"{count} run{'s' if count > 1 else ''}: see the warnings")
