"""Cubic Hermite interpolation: of fourth order in the distance of the samples.

SciPy has the same, but importing it takes longer than a whole run-up.
"""

from __future__ import annotations

import numpy as np

_STEPS = 8  # of Newton's method, which doubles the digits at each; where the speed vanishes halves must do


def intervals(at: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Between which samples of x (N,), increasing, points lie: i with x[i] < at <= x[i + 1]; the outermost for those beyond."""
    return np.clip(np.searchsorted(x, at, side="left") - 1, 0, len(x) - 2)


def hermite(at: np.ndarray, x: np.ndarray, y: np.ndarray, slope: np.ndarray, i: np.ndarray | None = None) -> np.ndarray:
    """y (..., N) of x (N,) with its derivative, at points ``at`` (K,): (..., K). i: their ``intervals``, if they are known."""
    i = intervals(at, x) if i is None else i
    h = x[i + 1] - x[i]
    s = (at - x[i]) / h
    left = y[..., i]
    rise = y[..., i + 1] - left
    before, after = h * slope[..., i] - rise, rise - h * slope[..., i + 1]
    return np.asarray(left + s * rise + s * (1 - s) * ((1 - s) * before + s * after))


def where_reached(values: np.ndarray, x: np.ndarray, y: np.ndarray, slope: np.ndarray, i: np.ndarray) -> np.ndarray:
    """The points at which the interpolated y reaches values (K,) between the samples i and i + 1, whose y are on both sides."""
    h, left = x[i + 1] - x[i], y[i]
    rise, first, last = y[i + 1] - left, h * slope[i], h * slope[i + 1]
    wanted, cubic, square = values - left, first + last - 2 * rise, 3 * rise - 2 * first - last
    low, high = np.zeros(len(i)), np.ones(len(i))
    s = np.divide(wanted, rise, out=np.zeros(len(i)), where=rise != 0)
    for _ in range(_STEPS):
        off = s * (first + s * (square + s * cubic)) - wanted
        short = off * rise < 0
        low, high = np.where(short, s, low), np.where(short, high, s)
        steepness = first + s * (2 * square + 3 * s * cubic)
        with np.errstate(all="ignore"):
            s = s - off / steepness
        s = np.where((s >= low) & (s <= high), s, (low + high) / 2)
    return np.asarray(x[i] + s * h)
