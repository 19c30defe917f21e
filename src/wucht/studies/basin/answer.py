"""The answer of a map of outcomes: the number of each cell, the shares with their uncertainty, and doubts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from wucht.dynamics.sampling.ensemble_run import integration_note
from wucht.dynamics.sampling.label_maps import share
from wucht.dynamics.sampling.outcome_maps import Level, OutcomeMap
from wucht.dynamics.sampling.outcome_runs import OutcomeRuns
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.results.formatting import percent
from wucht.studies.answer import Answer

_MOST_FAILURES = 3  # listed individually
_HEADLINES = ("compensated", "passed", "captured", "captured-modulated")

Labels = Mapping[int, str]  # by number
Shares = Mapping[str, Any]  # the numbers of a level, see ``_shares``
Details = Callable[[Answer, Any, Level, Labels, Shares], None]  # what the runs of a map, of their kind, state further


def state_outcome_map(
    map_: OutcomeMap, doubts: tuple[str, ...], state_details: Details, refine: int, last: Level, a: Answer
) -> None:
    """State the answer as far as it is known on the last of ``refine`` levels.

    The dimensions have the names of the axes, such as psi and delta; of equations x and y. With refined borders there are all
    variables once more on the finer cells (``refined_outcome``), where the parts of a coarser cell inherit its values.
    """
    levels, runs = last.with_coarser_ones, map_.runs.with_outcomes(last.members)
    labels = runs.labels(last.outcome)
    _state_cells(a, map_, levels[0], labels, "")
    if last.coarser is not None:
        cells = _state_cells(a, map_, last, labels, "refined_")
        a.curve("refined_level", last.halvings_of, "halvings after which the run was made (-1: not computed)", "", cells)
    for k, axis in zip("xy", map_.axes, strict=True):
        ends = {"axis": axis.name, "low": axis.low, "high": axis.high, "is_angle": int(axis.is_angle)}
        a.attribute(**{f"{k}_{word}": value for word, value in ends.items()})
    axes = {
        axis.name: {"range": [axis.low, axis.high], "cells": axis.cells, "unit": axis.unit, "periodic": axis.is_periodic}
        for axis in map_.axes
    }
    a.number("axes", axes, "axes of the map")
    if map_.ranges:
        a.number("ranges", {r.name: [r.low, r.high] for r in map_.ranges}, "ranges of what each cell draws at random")
    shares = _state_shares(a, replace(map_, runs=runs), labels, refine, levels)
    a.warn(*doubts)
    _warn_of_missing_cells(a, refine, last)
    state_details(a, runs, last, labels, shares)
    _state_failures(a, map_, levels)


def _state_cells(a: Answer, map_: OutcomeMap, level: Level, labels: Labels, prefix: str) -> str:
    """State coordinates and variables of a map on one level, and return their dimensions."""
    x, y = map_.axes
    cells, kind = f"{prefix}{y.dimension} {prefix}{x.dimension}", map_.runs.number_type
    flags = {"flag_values": np.array(list(labels), kind), "flag_meanings": " ".join(labels.values())}
    for axis in map_.axes:
        a.curve(f"{prefix}{axis.dimension}", axis.centres(level.halvings), axis.description, axis.unit)
    a.curve(f"{prefix}outcome", level.outcome.astype(kind), "outcome", "", cells, attributes=flags)
    for name, (words, unit) in map_.runs.readings.items():
        a.curve(f"{prefix}{name}", level.reading(name), words, unit, cells)
    return cells


def _shares(map_: OutcomeMap, labels: Labels, level: Level) -> Shares:
    """Shares of the labels on one level, with their uncertainty."""
    present = np.unique(level.outcome[~level.is_missing]).tolist()
    errors = {labels[k]: map_.errors(level, k) for k in present}
    return {
        "cells": [level.shape[1], level.shape[0]],
        "runs": level.runs,
        "fractions": {labels[k]: share(level.outcome == k) for k in present},
        "uncertainty": {name: error for name, (error, _) in errors.items()},
        "bound": {name: largest for name, (_, largest) in errors.items() if largest is not None},
        "missing": share(level.is_missing),
    }


def _state_shares(a: Answer, map_: OutcomeMap, labels: Labels, refine: int, levels: tuple[Level, ...]) -> Shares:
    """State the shares of the labels on each level, and the answer in one sentence. Returns those of the last level."""
    shares, (rows, columns) = [_shares(map_, labels, level) for level in levels], map_.shape(refine)
    last, runs = shares[-1], levels[-1].total_runs
    fractions, errors, missing = last["fractions"], last["uncertainty"], last["missing"]
    a.number("fractions", fractions, "shares of the map by outcome", headline=_HEADLINES)
    a.number("uncertainty", errors, "uncertainty of the shares, in 19 of 20 cases")
    a.number("standard_errors", {name: error / 2 for name, error in errors.items()}, "standard errors of the shares")
    a.number("bound", last["bound"], "largest error of the shares if the map resolves the borders")
    a.number("missing", missing, "share of the map that is not computed")
    a.number("runs", runs, "number of runs")
    a.number("runs_of_dense_map", rows * columns, "number of cells of the finest map")
    a.number("levels", shares, "shares on each level of refinement")
    saddles = {labels[k] for k in map_.runs.unstable_labels}
    order = sorted(fractions, key=lambda name: -fractions[name])
    clauses = [f"{name} {percent(fractions[name], errors[name])}" for name in order if name not in saddles]
    clauses += [f"{percent(fractions[name])} of the starts end in the saddle {name}" for name in order if name in saddles]
    a.sentence = ", ".join([*clauses, *([f"{100 * missing:.3g} % not computed yet"] if missing else [])])
    first_cells, last_cells = (" x ".join(map(str, one["cells"])) for one in (shares[0], last))
    refinement = f", at the borders halved to those of {last_cells}" if len(levels) > 1 else ""
    random = f", with {' and '.join(r.name for r in map_.ranges)} at random" if map_.ranges else ""
    a.line("map", f"{first_cells} cells over {' and '.join(axis.name for axis in map_.axes)}{refinement}{random}")
    dense = f", instead of {rows * columns} with one in each cell of the finest map"
    a.line("runs", f"{runs}{dense if runs != rows * columns else ''}")
    if fractions:
        bounds = last["bound"].values()
        most = f"; the error is at most {100 * max(bounds):.2g} % if the map resolves the borders" if bounds else ""
        a.line("shares", f"± holds in 19 of 20 cases{most}")
    for k, name in enumerate(fractions if len(levels) > 1 else ()):
        by_level = ", ".join(f"{100 * one['fractions'].get(name, 0.0):.4g} %" for one in shares)
        a.line("" if k else "by level", f"{name} {by_level}")
    return last


def _warn_of_missing_cells(a: Answer, refine: int, last: Level) -> None:
    missing = int(last.is_missing.sum())
    if missing:
        a.warn(f"{missing} of the {last.outcome.size} cells of the map are not computed; the shares are of all cells")
    elif last.halvings < refine:
        a.warn(f"the borders are refined {last.halvings} of {refine} times")


def state_times(a: Answer, runs: OutcomeRuns, last: Level, labels: Labels, shares: Shares) -> None:
    """State how long motions of a machine were integrated, and warn of those that this was too short for."""
    question, end_time = runs.question, last.reading("end_time")
    a.number("model", question.model, "equations")
    a.line("integrated", a.number("integration", integration_note(question), "method of integration"))
    a.number("amplitude_unit", question.machine.orbit_unit, "unit of amplitudes")
    a.number("time_unit", a.unit("time"), "unit of times")
    a.number("until", question.until, "time until which each motion is integrated", "time")
    inside = {name: last.outcome == k for k, name in labels.items() if name in shares["fractions"]}
    times = {name: [float(f(end_time[cells])) for f in (np.min, np.max)] for name, cells in inside.items()}
    a.number("followed", times, "least and greatest time until which motions of an outcome were integrated", "time")
    if Outcome.UNIDENTIFIED not in times:
        return
    low, high = (f"{t:.4g}" for t in times[Outcome.UNIDENTIFIED])
    until = f"{low if low == high else f'{low} to {high}'} {a.unit('time')}".rstrip()
    part = f"{100 * share(inside[Outcome.UNIDENTIFIED]):.3g} % of the map"
    longer = "; a longer study.until may identify them" if question.until is not None else ""
    a.warn(f"{part} are unidentified, integrated until {until}{longer}")
    a.line("unidentified", f"{part}, integrated until {until}")


def _state_failures(a: Answer, map_: OutcomeMap, levels: tuple[Level, ...]) -> None:
    failures = [
        (level.halvings, int(cells[m]), reason)
        for level in levels
        for cells, members in level.tiles
        for m, reason in members.failures
    ]
    count = a.number("failures", len(failures), "number of runs that failed")
    for halvings, cell, reason in failures[:_MOST_FAILURES]:
        place = map_.places(halvings, np.array([cell]))[:, 0].tolist()
        location = ", ".join(f"{q.name} = {value:.6g}" for q, value in zip(map_.quantities, place, strict=True))
        a.warn(f"the run at {location} failed: {reason}")
    if count > _MOST_FAILURES:
        a.warn(f"{count - _MOST_FAILURES} more runs failed")
    if count:
        a.line("failed", f"{count} run{'s' if count > 1 else ''}: see the warnings")
