"""Turning points of a signal -> what was asked for: cycles, rows of the spectrum, levels, damage."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wucht.fatigue.counted_cycles import Cycles
from wucht.fatigue.counting import cycles_of_levels, cycles_of_peaks, level_crossings, peaks_and_valleys, rainflow, range_pairs
from wucht.studies.load_spectrum.computation import Plan

MOST_ROWS, _CLASSES = 1000, 100  # ranges that each stand for themselves, and classes where there are more


@dataclass(frozen=True, eq=False)
class CountedLoad:
    """cycles: all that were counted. rows: one for each range or class of them, row (m,): to which each belongs. class_width:
    of these, None where each range stands for itself. levels, crossings (k,): of level crossings."""

    cycles: Cycles
    rows: Cycles
    row: np.ndarray
    class_width: float | None
    levels: np.ndarray = field(default_factory=lambda: np.empty(0))
    crossings: np.ndarray = field(default_factory=lambda: np.empty(0))


def counted(plan: Plan, values: np.ndarray, levels: np.ndarray | None = None) -> CountedLoad:
    """The load of turning points (m,). levels (k,): those of a larger part, so that both can be compared."""
    method, residue = plan.spec.counting, plan.spec.residue
    if method in ("rainflow", "range-pair"):
        count = rainflow if method == "rainflow" else range_pairs
        return _in_rows(count(values, residue), plan.class_width)
    closed = residue == "repeat"
    if method == "peaks":
        peaks, valleys = peaks_and_valleys(values, plan.reference, closed)
        middle = plan.reference if plan.reference is not None else float(values.mean()) if len(values) else 0.0
        return _in_rows(cycles_of_peaks(peaks, valleys, middle), plan.class_width)
    if not np.ptp(values if len(values) else np.zeros(1)):
        return _in_rows(Cycles.none(), plan.class_width)
    history = np.append(values, values[0]) if closed else values
    levels = _levels(values, plan.class_width, plan.reference) if levels is None else levels
    crossings = level_crossings(history, levels, plan.reference)
    cycles = cycles_of_levels(levels, crossings)
    rows, row = cycles.by_range()
    return CountedLoad(cycles, rows, row, float(levels[1] - levels[0]) if len(levels) > 1 else None, levels, crossings)


def _in_rows(cycles: Cycles, width: float | None) -> CountedLoad:
    rows, row = cycles.by_range(width)
    if width is None and len(rows.ranges) > MOST_ROWS:
        width = cycles.largest / _CLASSES
        rows, row = cycles.by_range(width)
    return CountedLoad(cycles, rows, row, width)


def _levels(values: np.ndarray, width: float | None, reference: float | None) -> np.ndarray:
    """Evenly spaced levels (k,): at multiples of a width from the reference on, or in the middle of a hundred classes."""
    low, high = float(values.min()), float(values.max())
    if width is None:
        step = (high - low) / _CLASSES
        return np.asarray(low + step * (np.arange(_CLASSES) + 0.5))
    origin = reference or 0.0
    first, last = np.ceil((low - origin) / width), np.floor((high - origin) / width)
    return np.asarray(origin + width * np.arange(first, last + 1))
