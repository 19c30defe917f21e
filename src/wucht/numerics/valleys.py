"""Minima of functions of an angle, and the arcs on which they are negative: of functions that may have kinks and jumps."""

from __future__ import annotations

import math

import numpy as np

from wucht.numerics.zeros import RealFunction, crossings

Arc = tuple[float, float]
TURN = 2 * math.pi
STEP = TURN / 4096
GRID = np.arange(4096) * STEP  # rad: what is narrower than 0.09 deg may be missed
_GOLDEN = (math.sqrt(5) - 1) / 2


def narrowed(function: RealFunction, a: np.ndarray, b: np.ndarray, sections: int = 40) -> np.ndarray:
    """Where a function (k,) -> (k,) is least between a and b (k,), each by itself, where it has one valley there.

    By golden sections: the function may jump or have a kink.
    """
    for _ in range(sections):
        c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
        left = function(c) < function(d)
        a, b = np.where(left, a, c), np.where(left, d, b)
    tried = np.stack([a, (a + b) / 2, b])
    return np.asarray(tried[np.argmin([function(x) for x in tried], axis=0), np.arange(len(a))])


def valleys(function: RealFunction, values: np.ndarray | None = None, below: float = math.inf) -> tuple[np.ndarray, np.ndarray]:
    """Angles in [0, 2 pi) at which a function (N,) -> (N,) of period 2 pi has its minima, and these (k,), at least one.

    values: of the function on ``GRID``, where they are known. below: only minima that are lower there, and the lowest. One that
    jumps has its minima there on the lower side.
    """
    y = function(GRID) if values is None else values
    i = np.flatnonzero((y < np.roll(y, 1)) & (y <= np.roll(y, -1)) & (y < below))
    i = i if len(i) else np.array([int(np.argmin(y))])
    found = narrowed(function, GRID[i] - STEP, GRID[i] + STEP)
    reached = function(found)
    at, least = np.where(reached < y[i], found, GRID[i]), np.minimum(reached, y[i])
    return np.mod(at, TURN), least


def arcs_below_zero(function: RealFunction, minima: np.ndarray | None = None) -> tuple[Arc, ...]:
    """The arcs in rad on which a function of period 2 pi is negative, their ends to the last bit, in order of their begins.

    Begins lie in [0, 2 pi), ends after them. A whole turn is (0, 2 pi). minima: angles of its ``valleys``, where known.
    """
    minima = valleys(function)[0] if minima is None else minima
    at = np.unique(np.concatenate([GRID, minima]))
    zeros = crossings(function, np.append(at, at[0] + TURN))
    if not len(zeros):
        return ((0.0, TURN),) if function(minima).min() < 0 else ()
    after = np.append(zeros[1:], zeros[0] + TURN)
    negative = function((zeros + after) / 2) < 0
    return tuple((float(begin), float(end)) for begin, end in zip(zeros[negative], after[negative], strict=True))
