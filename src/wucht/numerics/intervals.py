"""Bounds of an expression over intervals of one variable, and of a program over boxes: the natural interval extension.

R. E. Moore, R. B. Kearfott, M. J. Cloud, "Introduction to Interval Analysis", SIAM 2009, chapter 5.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, reduce

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.program import Program
from wucht.piecewise import Pieces, PiecewiseCubic

Interval = tuple[np.ndarray, np.ndarray]

_REAL = 1e-6  # a double root may come out as a complex pair
_MONOTONE: dict[type, Callable[[np.ndarray], np.ndarray]] = {
    sp.exp: np.exp, sp.log: np.log, sp.tanh: np.tanh, sp.sinh: np.sinh, sp.atan: np.arctan, sp.asin: np.arcsin,
}  # fmt: skip


def enclosure(expression: sp.Expr, symbol: sp.Symbol, low: np.ndarray, high: np.ndarray) -> Interval:
    """Return lower and upper bounds (N,) of an expression in one symbol on the intervals [low, high] (N,).

    It may contain sums, products, integer powers, tanh and piecewise cubics; where these jump, both values are included.
    Bounds are infinite where a denominator may vanish. Raises ``WuchtError`` for any other function.
    """
    e = sp.sympify(expression)
    if e == symbol:
        return low, high
    if e.is_number:
        value = np.full_like(low, float(e))
        return value, value
    if isinstance(e, sp.Add | sp.Mul):
        parts = [enclosure(a, symbol, low, high) for a in e.args]
        return reduce(sum_of if isinstance(e, sp.Add) else product_of, parts)
    if isinstance(e, sp.Pow) and e.exp.is_Integer:
        power = power_of(enclosure(e.base, symbol, low, high), abs(int(e.exp)))
        return power if e.exp > 0 else reciprocal_of(power)
    if isinstance(e, sp.tanh):
        below, above = enclosure(e.args[0], symbol, low, high)
        return np.tanh(below), np.tanh(above)
    if isinstance(e, PiecewiseCubic):
        return cubics_of(e.args[1], enclosure(e.args[0], symbol, low, high))
    raise WuchtError(f"no bounds are known for {e}", code="no-bounds")


def cubics_of(pieces: Pieces, a: Interval) -> Interval:
    """Bound a piecewise cubic by its values at both ends, at breakpoints from both sides, and where the slope is zero."""
    with np.errstate(all="ignore"):
        ends = np.array([np.where(np.isfinite(x), pieces(x), np.nan) for x in a])
    at, values = _extremes(pieces)
    inside = (at[:, None] >= a[0]) & (at[:, None] <= a[1])
    low = np.where(inside, values[:, None], np.inf).min(axis=0, initial=np.inf)
    high = np.where(inside, values[:, None], -np.inf).max(axis=0, initial=-np.inf)
    unknown, low, high = np.isnan(ends).any(axis=0), np.minimum(low, ends.min(axis=0)), np.maximum(high, ends.max(axis=0))
    return np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high)


@lru_cache(maxsize=64)
def _extremes(pieces: Pieces) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k,) at which a value can be extreme inside an interval, and these values (k,)."""
    borders, candidates = (-np.inf, *pieces.breakpoints, np.inf), []
    for origin, row, begin, end in zip(pieces.origins, pieces.coefficients, borders[:-1], borders[1:], strict=True):
        cubic = np.polynomial.Polynomial(row)
        flat = np.asarray(cubic.deriv().roots(), complex)
        real = origin + flat.real[np.abs(flat.imag) <= _REAL * (1 + np.abs(flat))]
        candidates += [(x, float(cubic(x - origin))) for x in (*real, begin, end) if begin <= x <= end and np.isfinite(x)]
    return tuple(np.array(candidates).T)


def sum_of(a: Interval, b: Interval) -> Interval:
    """Bounds of a sum."""
    return a[0] + b[0], a[1] + b[1]


def product_of(a: Interval, b: Interval) -> Interval:
    """Bounds of a product; infinity times zero is zero."""
    with np.errstate(invalid="ignore"):
        products = np.nan_to_num(np.array([x * y for x in a for y in b]), nan=0.0, posinf=np.inf, neginf=-np.inf)
    return products.min(axis=0), products.max(axis=0)


def power_of(a: Interval, exponent: int) -> Interval:
    """Bounds of a power with a whole exponent that is not negative."""
    ends = np.array([a[0] ** exponent, a[1] ** exponent])
    low, high = ends.min(axis=0), ends.max(axis=0)
    return np.where((a[0] < 0) & (a[1] > 0) & (exponent % 2 == 0), 0.0, low), high


def reciprocal_of(a: Interval) -> Interval:
    """Bounds of 1/a, infinite where it may have a pole."""
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = 1 / a[1], 1 / a[0]
    vanishing = (a[0] <= 0) & (a[1] >= 0)
    return np.where(vanishing, -np.inf, low), np.where(vanishing, np.inf, high)


def bounds(program: Program, constants: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lower and upper bounds (k, N) of a program's k results over N boxes.

    Parameters
    ----------
    program : Program
        With n states, without the time.
    constants : ndarray
        The values of its constants.
    low, high : ndarray, (n, N)

    Returns
    -------
    tuple of ndarray
        Infinite, or not a number, where no bound is known.

    Raises
    ------
    WuchtError
        For a function of which no bounds are known.
    """
    intervals: dict[sp.Expr, Interval] = dict(zip(program.states, zip(low, high, strict=True), strict=True))
    intervals |= {s: _number(v, low) for (s, _), v in zip(program.constants, constants.tolist(), strict=True)}
    with np.errstate(all="ignore"):
        for symbol, expression in program.lines:
            intervals[symbol] = _bounds(expression, intervals, low)
        result_intervals = [_bounds(sp.sympify(r), intervals, low) for r in program.results]
    below, above = (np.array([np.broadcast_to(e[k], low.shape[1:]) for e in result_intervals]) for k in (0, 1))
    return below, above


def _number(value: float, like: np.ndarray) -> Interval:
    at = np.full(like.shape[1:], float(value))
    return at, at


def _bounds(e: sp.Expr, intervals: dict[sp.Expr, Interval], like: np.ndarray) -> Interval:
    if e not in intervals:
        intervals[e] = _compute_bounds(e, intervals, like)
    return intervals[e]


def _compute_bounds(e: sp.Expr, intervals: dict[sp.Expr, Interval], like: np.ndarray) -> Interval:
    if e.is_number:
        return _number(e, like)
    if isinstance(e, PiecewiseCubic):
        return cubics_of(e.args[1], _bounds(e.args[0], intervals, like))
    parts = [_bounds(a, intervals, like) for a in e.args]
    if isinstance(e, sp.Add | sp.Mul):
        return reduce(sum_of if isinstance(e, sp.Add) else product_of, parts)
    if isinstance(e, sp.Pow):
        return _power(parts[0], e.exp, e)
    return _function(e, parts[0])


def _function(e: sp.Expr, a: Interval) -> Interval:
    if e.func in _MONOTONE:
        f = _MONOTONE[e.func]
        return f(a[0]), f(a[1])
    if isinstance(e, sp.sin | sp.cos):
        return _wave(a, 0.0 if isinstance(e, sp.cos) else np.pi / 2)
    if isinstance(e, sp.cosh):
        ends = np.cosh(np.array(a))
        return np.where((a[0] < 0) & (a[1] > 0), 1.0, ends.min(axis=0)), ends.max(axis=0)
    if isinstance(e, sp.tan):
        pole = np.floor(a[0] / np.pi + 0.5) != np.floor(a[1] / np.pi + 0.5)
        return np.where(pole, -np.inf, np.tan(a[0])), np.where(pole, np.inf, np.tan(a[1]))
    raise WuchtError(f"no bounds are known for {e.func.__name__}")


def _power(base: Interval, exponent: sp.Expr, e: sp.Expr) -> Interval:
    if exponent.is_Integer:
        power = power_of(base, abs(int(exponent)))
        return power if exponent > 0 else reciprocal_of(power)
    if not exponent.is_number:
        raise WuchtError(f"no bounds are known for {e}")
    p = float(exponent)  # the base is positive: the power is monotone
    ends = base[0] ** p, base[1] ** p
    return ends if p > 0 else (ends[1], np.where(base[0] > 0, ends[0], np.inf))


def _wave(a: Interval, shift: float) -> Interval:
    """Bounds of cos(a - shift)."""
    low, high = a[0] - shift, a[1] - shift
    ends = np.cos(np.array([low, high]))
    top = np.floor(high / (2 * np.pi)) >= np.ceil(low / (2 * np.pi))
    bottom = np.floor((high - np.pi) / (2 * np.pi)) >= np.ceil((low - np.pi) / (2 * np.pi))
    unknown = ~np.isfinite(low + high)
    return np.where(bottom | unknown, -1.0, ends.min(axis=0)), np.where(top | unknown, 1.0, ends.max(axis=0))
