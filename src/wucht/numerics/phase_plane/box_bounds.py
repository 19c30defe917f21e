"""Bounds of a program's results over boxes of its states: the natural interval extension, line by line.

R. E. Moore, R. B. Kearfott, M. J. Cloud, "Introduction to Interval Analysis", SIAM 2009, chapter 5. Rounding is not directed:
what uses the bounds leaves a margin for it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.program import Program
from wucht.numerics.intervals import Interval, cubics_of, power_of, product_of, reciprocal_of, sum_of
from wucht.piecewise import PiecewiseCubic

_MONOTONE: dict[type, Callable[[np.ndarray], np.ndarray]] = {
    sp.exp: np.exp, sp.log: np.log, sp.tanh: np.tanh, sp.sinh: np.sinh, sp.atan: np.arctan, sp.asin: np.arcsin,
}  # fmt: skip


def bounds(program: Program, constants: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds (k, N) of a program's k results over N boxes.

    Parameters
    ----------
    program : Program
        Of n states, without the time.
    constants : ndarray
        Its constants' values.
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
    known: dict[sp.Expr, Interval] = dict(zip(program.states, zip(low, high, strict=True), strict=True))
    known |= {s: _number(v, low) for (s, _), v in zip(program.constants, constants.tolist(), strict=True)}
    with np.errstate(all="ignore"):
        for symbol, expression in program.lines:
            known[symbol] = _bounds(expression, known, low)
        each = [_bounds(sp.sympify(r), known, low) for r in program.results]
    below, above = (np.array([np.broadcast_to(e[k], low.shape[1:]) for e in each]) for k in (0, 1))
    return below, above


def _number(value: float, like: np.ndarray) -> Interval:
    at = np.full(like.shape[1:], float(value))
    return at, at


def _bounds(e: sp.Expr, known: dict[sp.Expr, Interval], like: np.ndarray) -> Interval:
    if e not in known:
        known[e] = _of(e, known, like)
    return known[e]


def _of(e: sp.Expr, known: dict[sp.Expr, Interval], like: np.ndarray) -> Interval:
    if e.is_number:
        return _number(e, like)
    if isinstance(e, PiecewiseCubic):
        return cubics_of(e.args[1], _bounds(e.args[0], known, like))
    parts = [_bounds(a, known, like) for a in e.args]
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
    raise WuchtError(f"no bounds are known of {e.func.__name__}")


def _power(base: Interval, exponent: sp.Expr, e: sp.Expr) -> Interval:
    if exponent.is_Integer:
        power = power_of(base, abs(int(exponent)))
        return power if exponent > 0 else reciprocal_of(power)
    if not exponent.is_number:
        raise WuchtError(f"no bounds are known of {e}")
    p = float(exponent)  # of what is positive: it rises or falls
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
