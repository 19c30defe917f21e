"""A load counted by one of several methods, cycles or crossings of levels, with a row for each range or class of ranges."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.counting import (
    Residue,
    cycles_of_levels,
    cycles_of_peaks,
    level_crossings,
    peaks_and_valleys,
    rainflow,
    range_pairs,
)

MOST_ROWS, _CLASSES = 1000, 100  # ranges listed without classes, and classes where there are more
_ROUNDING = 1e-9  # of the distance of two levels

CountingMethod = Literal["rainflow", "range-pair", "level-crossing", "peaks"]


@dataclass(frozen=True, eq=False)
class CountedLoad:
    """A counted load.

    cycles: all counted ones. rows: one for each range or class of ranges; row (m,): that of each cycle. class_width:
    of the rows, None where each range has one. levels, crossings (k,): of level crossings.
    """

    cycles: LoadCycles
    rows: LoadCycles
    row: np.ndarray
    class_width: float | None
    levels: np.ndarray = field(default_factory=lambda: np.empty(0))
    crossings: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class LoadCounting:
    """A way of counting. reference: of level crossings and peaks. class_width: of range and level. Both in the load's unit."""

    method: CountingMethod = "rainflow"
    residue: Residue = "half-cycles"
    reference: float | None = None
    class_width: float | None = None

    def count(self, values: np.ndarray, levels: np.ndarray | None = None) -> CountedLoad:
        """Count the load of turning points (m,). levels (k,): those of a longer signal, so that both can be compared."""
        if self.method in ("rainflow", "range-pair"):
            count = rainflow if self.method == "rainflow" else range_pairs
            return self._with_rows(count(values, self.residue))
        is_closed = self.residue == "repeat"
        if self.method == "peaks":
            peaks, valleys = peaks_and_valleys(values, self.reference, is_closed)
            middle = self.reference if self.reference is not None else float(values.mean()) if len(values) else 0.0
            return self._with_rows(cycles_of_peaks(peaks, valleys, middle))
        if not np.ptp(values if len(values) else np.zeros(1)):
            return self._with_rows(LoadCycles.empty())
        history = np.append(values, values[0]) if is_closed else values
        levels = self._levels(values) if levels is None else levels
        crossings = level_crossings(history, levels, self.reference)
        cycles = cycles_of_levels(levels, crossings)
        rows, row = cycles.group_by_range()
        return CountedLoad(cycles, rows, row, float(levels[1] - levels[0]) if len(levels) > 1 else None, levels, crossings)

    def _with_rows(self, cycles: LoadCycles) -> CountedLoad:
        width = self.class_width
        rows, row = cycles.group_by_range(width)
        if width is None and len(rows.ranges) > MOST_ROWS:
            width = cycles.largest / _CLASSES
            rows, row = cycles.group_by_range(width)
        return CountedLoad(cycles, rows, row, width)

    def _levels(self, values: np.ndarray) -> np.ndarray:
        """Evenly spaced levels (k,): at multiples of a width from the reference, or in the middle of a hundred classes."""
        low, high = float(values.min()), float(values.max())
        if self.class_width is None:
            step = (high - low) / _CLASSES
            return np.asarray(low + step * (np.arange(_CLASSES) + 0.5))
        width, origin = self.class_width, self.reference or 0.0
        first, last = np.ceil((low - origin) / width - _ROUNDING), np.floor((high - origin) / width + _ROUNDING)
        return np.clip(origin + width * np.arange(first, last + 1), low, high)
