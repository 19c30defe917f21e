"""Cubic Hermite interpolation: of fourth order in the distance of the samples.

SciPy has the same, but importing it takes longer than a whole run-up.
"""

from __future__ import annotations

import numpy as np

_MOST_STEPS = 60  # of Newton's method, which doubles the digits at each; where the speed vanishes halves must do
_DIGITS = 1e-14


def between(share: np.ndarray, x: np.ndarray, y: np.ndarray, slope: np.ndarray, i: np.ndarray) -> np.ndarray:
    """y (..., N) of x (N,) with its derivative, at shares (K,) of the way from the samples i to the next: (..., K)."""
    h, left = x[i + 1] - x[i], y.take(i, axis=-1)
    rise = y.take(i + 1, axis=-1) - left
    before, after = h * slope.take(i, axis=-1) - rise, rise - h * slope.take(i + 1, axis=-1)
    return np.asarray(left + share * (rise + (1 - share) * ((1 - share) * before + share * after)))


def where_reached(values: np.ndarray, x: np.ndarray, y: np.ndarray, slope: np.ndarray, i: np.ndarray) -> np.ndarray:
    """At which shares (K,) of the way from the samples i to the next, one y below and one above, y has values (K,)."""
    h, left = x[i + 1] - x[i], y[i]
    rise, first, last = y[i + 1] - left, h * slope[i], h * slope[i + 1]
    wanted, cubic, square = values - left, first + last - 2 * rise, 3 * rise - 2 * first - last
    low, high = np.zeros(len(i)), np.ones(len(i))
    s = np.divide(wanted, rise, out=np.zeros(len(i)), where=rise != 0)
    for _ in range(_MOST_STEPS):
        off = s * (first + s * (square + s * cubic)) - wanted
        found = np.abs(off) <= _DIGITS * np.abs(rise)  # then it stays, however many steps the others take
        if found.all():
            break
        short = off * rise < 0
        low, high = np.where(short, s, low), np.where(short, high, s)
        with np.errstate(all="ignore"):
            step = s - off / (first + s * (2 * square + 3 * s * cubic))
        s = np.where(found, s, np.where((step >= low) & (step <= high), step, (low + high) / 2))
    return np.asarray(s)
