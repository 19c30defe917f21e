"""Counted cycles, the result of all counting methods; and their classes: range-mean matrix, difference of two spectra."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_SAME = 1e-9  # of the largest range: ranges nearer to each other than that are one
_ROUNDING, _NOISE = 1e-9, 1e-6  # of the largest mean, of the largest range: a smaller spread of means is none


@dataclass(frozen=True, eq=False)
class LoadCycles:
    """Cycles of a load, the result of all counting methods.

    Parameters
    ----------
    ranges : numpy.ndarray, (m,)
        The range of each cycle, twice its amplitude, in the unit of the load.
    means : numpy.ndarray, (m,)
        The mean of each cycle, in the same unit.
    counts : numpy.ndarray, (m,)
        The number of each cycle, 0.5 for a half cycle.
    """

    ranges: np.ndarray
    means: np.ndarray
    counts: np.ndarray

    @classmethod
    def from_extremes(cls, first: np.ndarray, second: np.ndarray, counts: np.ndarray) -> LoadCycles:
        """Create cycles between two values (m,) each."""
        return cls(np.abs(first - second), (first + second) / 2, np.asarray(counts, dtype=float))

    @classmethod
    def empty(cls) -> LoadCycles:
        """Return no cycles."""
        return cls(np.empty(0), np.empty(0), np.empty(0))

    def join(self, cycles: LoadCycles) -> LoadCycles:
        """Join these cycles and more."""
        pairs = ((self.ranges, cycles.ranges), (self.means, cycles.means), (self.counts, cycles.counts))
        return LoadCycles(*(np.concatenate(pair) for pair in pairs))

    @property
    def total(self) -> float:
        """The number of cycles."""
        return float(self.counts.sum())

    @property
    def largest(self) -> float:
        """The largest range; 0 without any."""
        return float(self.ranges.max(initial=0.0))

    def cumulative_frequency(self, ranges: np.ndarray) -> np.ndarray:
        """Return the number (k,) of cycles with at least each of some ranges (k,): the cumulative frequency."""
        order = np.argsort(self.ranges)
        above = np.append(np.cumsum(self.counts[order][::-1])[::-1], 0.0)
        return np.asarray(above[np.searchsorted(self.ranges[order], ranges - _SAME * self.largest, side="left")])

    def group_by_range(self, width: float | None = None) -> tuple[LoadCycles, np.ndarray]:
        """Return one cycle for each range, ascending (k,), or for each class of ranges of a width that is not empty; and the
        index (m,) of the one to which each of these cycles belongs.

        Its range and mean are the means over the cycles in it, so that the sum of all ranges stays.
        """
        if not len(self.ranges):
            return self, np.empty(0, int)
        order = np.argsort(self.ranges, kind="stable")
        sizes = self.ranges[order]
        new = np.diff(sizes) > _SAME * self.largest if width is None else np.diff(np.floor(sizes / width + _SAME)) > 0
        group = np.empty(len(order), int)
        group[order] = np.concatenate([[0], np.cumsum(new)])
        counts = np.bincount(group, self.counts)
        ranges, means = (np.bincount(group, self.counts * values) / counts for values in (self.ranges, self.means))
        return LoadCycles(ranges, means, counts), group


@dataclass(frozen=True, eq=False)
class RangeMeanMatrix:
    """Range-mean matrix: counts of cycles by classes of their range and of their mean.

    Attributes
    ----------
    range_edges : numpy.ndarray, (r + 1,)
        Edges of the classes of range, from zero on, in the unit of the load.
    mean_edges : numpy.ndarray, (m + 1,)
        Edges of the classes of mean.
    counts : numpy.ndarray, (r, m)
    """

    range_edges: np.ndarray
    mean_edges: np.ndarray
    counts: np.ndarray

    @classmethod
    def of(cls, cycles: LoadCycles, classes: int) -> RangeMeanMatrix:
        """Sort cycles into so many classes, ranges from zero on. Means that differ by less than 1e-6 of the largest range are
        of one class, as wide as those of ranges."""
        low, high = (float(f(cycles.means)) if len(cycles.means) else 0.0 for f in (np.min, np.max))
        noise = max(_ROUNDING * max(abs(low), abs(high)), _NOISE * cycles.largest)
        widest = high - low if high - low > noise else cycles.largest or 1.0  # a scale of noise would tell nothing
        edges = np.linspace(0.0, cycles.largest or 1.0, classes + 1), np.linspace(low, low + widest, classes + 1)
        # By number, so that rounding at the outer edges loses none.
        pairs = zip((cycles.ranges, cycles.means), edges, strict=True)
        row, column = (np.clip(((values - e[0]) / (e[1] - e[0])).astype(int), 0, classes - 1) for values, e in pairs)
        counts = np.bincount(row * classes + column, cycles.counts, minlength=classes**2)
        return cls(*edges, counts.reshape(classes, classes))


def frequency_distance(cycles: LoadCycles, reference: LoadCycles, times: float = 1.0) -> float:
    """Return the largest difference between the cumulative frequencies of two spectra, as a share of the reference's cycles.

    Parameters
    ----------
    cycles, reference : LoadCycles
    times : float, optional
        Factor on the number of ``cycles``, for a part of a run that represents the whole.

    Returns
    -------
    float
        0 for equal spectra; infinite where the reference alone has no cycles.
    """
    ranges = np.concatenate([cycles.ranges, reference.ranges])
    if not reference.total:
        return 0.0 if not cycles.total else float("inf")
    return (
        float(np.abs(times * cycles.cumulative_frequency(ranges) - reference.cumulative_frequency(ranges)).max())
        / reference.total
    )
