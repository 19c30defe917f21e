"""Zeros of a function of one variable on a grid, all at once: SciPy's root finder takes longer to import than this to run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

RealFunction = Callable[[np.ndarray], np.ndarray]

_HALVINGS = 60  # from any interval of a grid to the last bit


def crossings(function: RealFunction, grid: np.ndarray, direction: int = 0) -> np.ndarray:
    """Where a function (N,) -> (N,) changes its sign between samples of a grid (N,), to the last bit, in increasing order.

    direction: +1 only where it rises through zero, -1 only where it falls, 0 both. An interval in which it is zero counts
    once where it has different signs on its two sides, else not at all.
    """
    values = function(grid)
    signed = np.isfinite(values) & (values != 0)
    x, sign = grid[signed], np.sign(values[signed])
    change = sign[1:] - sign[:-1]
    changes = np.flatnonzero(change * direction > 0 if direction else change)
    low, high, left = x[changes], x[changes + 1], sign[changes]
    for _ in range(_HALVINGS if len(changes) else 0):
        middle = (low + high) / 2
        before = np.sign(function(middle)) == left
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.asarray((low + high) / 2)


def first_where(holds: Callable[[float], bool], low: float, high: float) -> float:
    """The lowest number between two from which on a condition holds, which does at ``high``, to the last bit."""
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
