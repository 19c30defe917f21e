"""Cycles that were counted: what all counting methods give, and all spectra and damages are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_SAME = 1e-9  # of the largest range: ranges nearer to each other than that are one


@dataclass(frozen=True, eq=False)
class Cycles:
    """ranges, means, counts (m,): range and mean of each cycle, and how often it happened, 0.5 of a half cycle."""

    ranges: np.ndarray
    means: np.ndarray
    counts: np.ndarray

    @classmethod
    def between(cls, one: np.ndarray, other: np.ndarray, counts: np.ndarray) -> Cycles:
        """Of cycles between two values (m,) each."""
        return cls(np.abs(one - other), (one + other) / 2, np.asarray(counts, dtype=float))

    @classmethod
    def none(cls) -> Cycles:
        """No cycle at all."""
        return cls(np.empty(0), np.empty(0), np.empty(0))

    def joined(self, more: Cycles) -> Cycles:
        """Both."""
        pairs = ((self.ranges, more.ranges), (self.means, more.means), (self.counts, more.counts))
        return Cycles(*(np.concatenate(pair) for pair in pairs))

    @property
    def total(self) -> float:
        """How many."""
        return float(self.counts.sum())

    @property
    def largest(self) -> float:
        """The largest range; 0 without any."""
        return float(self.ranges.max(initial=0.0))

    def exceeding(self, ranges: np.ndarray) -> np.ndarray:
        """How many cycles have at least each of some ranges (k,): the cumulative frequency (k,)."""
        order = np.argsort(self.ranges)
        above = np.append(np.cumsum(self.counts[order][::-1])[::-1], 0.0)
        return np.asarray(above[np.searchsorted(self.ranges[order], ranges - _SAME * self.largest, side="left")])

    def by_range(self, width: float | None = None) -> tuple[Cycles, np.ndarray]:
        """One cycle for each range, ascending (k,), or for each class of ranges of a width, that is not empty; and to which
        of them (m,) each of these belongs.

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
        ranges, means = (np.bincount(group, self.counts * of) / counts for of in (self.ranges, self.means))
        return Cycles(ranges, means, counts), group
