"""Cycles in classes: the range-mean matrix, and by how much two spectra differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.fatigue.counted_cycles import Cycles


@dataclass(frozen=True, eq=False)
class RangeMeanMatrix:
    """counts (r, m): of cycles by classes of range and of mean; edges of these classes (r + 1,), (m + 1,)."""

    range_edges: np.ndarray
    mean_edges: np.ndarray
    counts: np.ndarray

    @classmethod
    def of(cls, cycles: Cycles, classes: int) -> RangeMeanMatrix:
        """With so many classes, ranges from zero on."""
        low, high = (float(f(cycles.means)) if len(cycles.means) else 0.0 for f in (np.min, np.max))
        widest = max(high - low, 1e-9 * max(abs(low), abs(high))) or 1.0
        edges = np.linspace(0.0, cycles.largest or 1.0, classes + 1), np.linspace(low, low + widest, classes + 1)
        # By number, so that rounding at the outer edges loses none.
        pairs = zip((cycles.ranges, cycles.means), edges, strict=True)
        row, column = (np.clip(((of - e[0]) / (e[1] - e[0])).astype(int), 0, classes - 1) for of, e in pairs)
        counts = np.bincount(row * classes + column, cycles.counts, minlength=classes**2)
        return cls(*edges, counts.reshape(classes, classes))


def distance(one: Cycles, other: Cycles, times: float = 1.0) -> float:
    """By how much two spectra differ: the largest difference of their cumulative frequencies, as a share of the cycles of the
    other one. times: so often the first one counts, as a part of a run does that stands for the whole."""
    ranges = np.concatenate([one.ranges, other.ranges])
    if not other.total:
        return 0.0 if not one.total else float("inf")
    return float(np.abs(times * one.exceeding(ranges) - other.exceeding(ranges)).max()) / other.total
