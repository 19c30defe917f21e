"""Angles in one turn; and functions of one, with kinks and jumps: their minima, and the arcs on which they are negative."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wucht.numerics.zeros_and_peaks import RealFunction, crossings

_ROUNDING = 1e-9  # rad
Arc = tuple[float, float]
TURN = 2 * math.pi
STEP = TURN / 4096
GRID = np.arange(4096) * STEP  # rad: features narrower than 0.09 deg may be missed
_GOLDEN = (math.sqrt(5) - 1) / 2
_LEVEL = 1e-13  # of the largest value: a smaller difference from sample to sample is rounding


def wrap_angle(angle: Any) -> np.ndarray:
    """Return angles in [0, 2 pi), of any shape; one that is a rounding error below a whole turn becomes 0."""
    angles = np.remainder(angle, 2 * np.pi)
    return np.where(2 * np.pi - angles > _ROUNDING, angles, 0.0)


def wrap_to_pi(angle: Any) -> np.ndarray:
    """Return angles in [-pi, pi), of any shape."""
    return np.asarray(np.remainder(angle + np.pi, 2 * np.pi) - np.pi)


def refine_minima(function: RealFunction, a: np.ndarray, b: np.ndarray, sections: int = 40) -> np.ndarray:
    """Return the minimisers (k,) of a function (k,) -> (k,) between a and b (k,), each interval having one minimum.

    The search is by golden sections: the function may jump or have a kink.
    """
    c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
    at_c, at_d = function(c), function(d)
    for _ in range(sections):
        keeps_left = at_c < at_d
        a, b = np.where(keeps_left, a, c), np.where(keeps_left, d, b)
        new = np.where(keeps_left, b - _GOLDEN * (b - a), a + _GOLDEN * (b - a))
        at_new = function(new)
        (c, at_c), (d, at_d) = (np.where(keeps_left, (new, at_new), (d, at_d)), np.where(keeps_left, (c, at_c), (new, at_new)))
    candidates = np.stack([a, (a + b) / 2, b])
    return np.asarray(candidates[np.argmin([function(x) for x in candidates], axis=0), np.arange(len(a))])


def valleys(function: RealFunction, values: np.ndarray | None = None, below: float = math.inf) -> tuple[np.ndarray, np.ndarray]:
    """Return the angles in [0, 2 pi) of the minima of a function (N,) -> (N,) of period 2 pi, and these (k,), at least one.

    values: the function on ``GRID``, if already computed. below: return only minima lower than this, and the lowest. At a jump
    the minimum is taken on the lower side.
    """
    y = function(GRID) if values is None else values
    i = _dips(y)
    i = i[y[i] < below]
    i = i if len(i) else np.array([int(np.argmin(y))])
    minimisers = refine_minima(function, GRID[i] - STEP, GRID[i] + STEP)
    minima = function(minimisers)
    at, least = np.where(minima < y[i], minimisers, GRID[i]), np.minimum(minima, y[i])
    return np.mod(at, TURN), least


def _dips(y: np.ndarray) -> np.ndarray:
    """Return the indices (k,) of the samples (N,) of a turn that are lower than their neighbours.

    A stretch that is level but for rounding counts once, at its first sample: else a circle would have a thousand minima.
    """
    steps = np.flatnonzero(~(np.abs(y - np.roll(y, 1)) <= _LEVEL * np.abs(y[np.isfinite(y)]).max(initial=0.0)))
    z = y[steps]
    return np.asarray(steps[(z < np.roll(z, 1)) & (z <= np.roll(z, -1))])


def arcs_below_zero(function: RealFunction, minima: np.ndarray | None = None) -> tuple[Arc, ...]:
    """Return the arcs in rad on which a function of period 2 pi is negative, exact to the last bit, ordered by their starts.

    Starts lie in [0, 2 pi), ends after them. A whole turn is (0, 2 pi). minima: the angles of its ``valleys``, if known.
    """
    minima = valleys(function)[0] if minima is None else minima
    at = np.unique(np.concatenate([GRID, minima]))
    zeros = crossings(function, np.append(at, at[0] + TURN))
    if not len(zeros):
        return ((0.0, TURN),) if function(minima).min() < 0 else ()
    after = np.append(zeros[1:], zeros[0] + TURN)
    negative = function((zeros + after) / 2) < 0
    return tuple((float(begin), float(end)) for begin, end in zip(zeros[negative], after[negative], strict=True))
