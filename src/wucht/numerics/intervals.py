"""Bounds of an expression over intervals of one variable: the natural interval extension.

R. E. Moore, R. B. Kearfott, M. J. Cloud, "Introduction to Interval Analysis", SIAM 2009, chapter 5.
"""

from __future__ import annotations

from functools import lru_cache, reduce

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.piecewise import Pieces, PiecewiseCubic

Interval = tuple[np.ndarray, np.ndarray]

_REAL = 1e-6  # a double root may come out as a complex pair


def enclosure(expression: sp.Expr, symbol: sp.Symbol, low: np.ndarray, high: np.ndarray) -> Interval:
    """Lower and upper bounds (N,) of an expression in one symbol on the intervals [low, high] (N,).

    It may hold sums, products, integer powers, tanh and piecewise cubics; of these, where they jump, both values are inside.
    Infinite where a denominator may vanish. Raises ``WuchtError`` for anything else.
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
    raise WuchtError(f"no bounds are known of {e}", code="no-bounds")


def cubics_of(pieces: Pieces, a: Interval) -> Interval:
    """The values at both ends, and in between at breakpoints, from both sides, and where the slope is zero."""
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
    """Where a value can be extreme inside an interval (k,), and the value there (k,)."""
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
    """Bounds of a product; what is infinite times zero is zero."""
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
