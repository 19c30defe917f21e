"""Bounds of a rational expression over intervals of one variable: the natural interval extension.

R. E. Moore, R. B. Kearfott, M. J. Cloud, "Introduction to Interval Analysis", SIAM 2009, chapter 5.
"""

from __future__ import annotations

from functools import reduce

import numpy as np
import sympy as sp

from wucht.errors import WuchtError

Interval = tuple[np.ndarray, np.ndarray]


def enclosure(expression: sp.Expr, symbol: sp.Symbol, low: np.ndarray, high: np.ndarray) -> Interval:
    """Lower and upper bounds (N,) of an expression in one symbol on the intervals [low, high] (N,).

    Infinite where a denominator may vanish. Raises ``WuchtError`` for what is no sum, product or integer power.
    """
    e = sp.sympify(expression)
    if e == symbol:
        return low, high
    if e.is_Number or e.is_NumberSymbol:
        value = np.full_like(low, float(e))
        return value, value
    if isinstance(e, sp.Add | sp.Mul):
        parts = [enclosure(a, symbol, low, high) for a in e.args]
        return reduce(_sum if isinstance(e, sp.Add) else _product, parts)
    if isinstance(e, sp.Pow) and e.exp.is_Integer:
        power = _power(enclosure(e.base, symbol, low, high), abs(int(e.exp)))
        return power if e.exp > 0 else _reciprocal(power)
    raise WuchtError(f"no bounds are known of {e}")


def _sum(a: Interval, b: Interval) -> Interval:
    return a[0] + b[0], a[1] + b[1]


def _product(a: Interval, b: Interval) -> Interval:
    with np.errstate(invalid="ignore"):
        corners = np.nan_to_num(np.array([x * y for x in a for y in b]), nan=0.0, posinf=np.inf, neginf=-np.inf)
    return corners.min(axis=0), corners.max(axis=0)


def _power(a: Interval, exponent: int) -> Interval:
    ends = np.array([a[0] ** exponent, a[1] ** exponent])
    low, high = ends.min(axis=0), ends.max(axis=0)
    around_zero = (a[0] < 0) & (a[1] > 0) & (exponent % 2 == 0)
    return np.where(around_zero, 0.0, low), high


def _reciprocal(a: Interval) -> Interval:
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = 1 / a[1], 1 / a[0]
    vanishing = (a[0] <= 0) & (a[1] >= 0)
    return np.where(vanishing, -np.inf, low), np.where(vanishing, np.inf, high)
