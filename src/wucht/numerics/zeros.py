"""Zeros of a function of one variable on a grid, all at once: SciPy's root finder takes longer to import than this to run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

RealFunction = Callable[[np.ndarray], np.ndarray]

_MOST_STEPS = 100  # a dozen are enough, but for a function that jumps


def crossings(function: RealFunction, grid: np.ndarray, direction: int = 0) -> np.ndarray:
    """Where a function (N,) -> (N,) changes its sign between samples of a grid (N,), to the last bit, in increasing order.

    direction: +1 only where it rises through zero, -1 only where it falls, 0 both. An interval in which it is zero counts
    once where it has different signs on its two sides, else not at all.
    """
    values = function(grid)
    signed = np.isfinite(values) & (values != 0)
    x, f = grid[signed], values[signed]
    change = np.diff(np.sign(f))
    i = np.flatnonzero(change * direction > 0 if direction else change)
    return _roots(function, x[i], x[i + 1], f[i], f[i + 1]) if len(i) else np.empty(0)


def at_passages(samples: np.ndarray, value: float, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where samples (N,) pass a value, to first order: the samples before that (K,), and what ``of`` (..., N) is there."""
    i = np.flatnonzero((samples[:-1] - value) * (samples[1:] - value) <= 0)
    width = samples[i + 1] - samples[i]
    share = np.divide(value - samples[i], width, out=np.zeros(len(i)), where=width != 0)
    return i, np.asarray(of[..., i] + share * (of[..., i + 1] - of[..., i]))


@np.errstate(divide="ignore", invalid="ignore")  # where no interpolation is safe
def _roots(function: RealFunction, a: np.ndarray, b: np.ndarray, fa: np.ndarray, fb: np.ndarray) -> np.ndarray:
    """The zeros between a and b (k,), where the function has values of different signs.

    Inverse quadratic interpolation where it is safe, else halves: T. R. Chandrupatla, Adv. Eng. Software 28 (1997) 145-149.
    """
    share, roots = fa / (fa - fb), np.full(len(a), np.nan)
    for _ in range(_MOST_STEPS):
        x = a + share * (b - a)
        f = function(x)
        same = np.sign(f) == np.sign(fa)
        (c, fc), (b, fb) = (np.where(same, (a, fa), (b, fb)), np.where(same, (b, fb), (a, fa)))
        a, fa = x, f
        best = np.where(np.abs(fa) < np.abs(fb), a, b)
        least = np.finfo(float).eps * np.abs(best) / np.abs(b - a)  # nearer to an end there is no other number
        roots = np.where(np.isnan(roots) & ((least > 0.5) | (fa == 0)), best, roots)
        if not np.isnan(roots).any():
            break
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        safe = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
        quadratic = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        share = np.clip(np.where(safe, quadratic, 0.5), np.minimum(least, 0.5), np.maximum(1 - least, 0.5))
    return np.where(np.isnan(roots), best, roots)


def first_where(holds: Callable[[float], bool], low: float, high: float) -> float:
    """The lowest number between two from which on a condition holds, which does at ``high``, to the last bit."""
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def fewest_where(holds: Callable[[int], bool], low: int, high: int) -> int:
    """The least whole number above ``low`` from which on a condition holds, which does at ``high``."""
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
