"""Tests whether an expression is identically zero, and whether two frequencies are the same.

By values at points drawn at random: an analytic expression that is not zero everywhere is zero on a set of measure zero only,
which such a point does not meet (Schwartz 1980, J. ACM 27, 701-717, for polynomials). A sum that cancels is compared with
its terms, in 40 digits.
"""

from __future__ import annotations

import random
from functools import lru_cache

import mpmath  # type: ignore[import-untyped]  # SymPy brings it along
import sympy as sp

SAME = 1e-12
"""Numbers that differ by less than this, relative to themselves, are one: a decimal number knows no more digits of a root."""

_EXACT, _DIGITS, _POINTS = 1e-20, 40, 4

Point = dict[sp.Expr, tuple[mpmath.mpc, mpmath.mpf]]
"""Expressions already evaluated at a point: the value of each, and the size of its largest terms."""


@lru_cache(maxsize=4096)
def is_identically_zero(e: sp.Expr, tolerance: float = _EXACT) -> bool:
    """True if the expression is zero for all values of its symbols that their assumptions allow.

    tolerance: a remainder of a sum, relative to its terms, that counts as zero; ``SAME`` where it holds decimal numbers.
    """
    if e.is_zero is not None or e.is_Symbol:
        return bool(e.is_zero)
    tolerance = max(tolerance, SAME) if e.has(sp.Float) else tolerance
    draw, is_decided = random.Random(1), False
    for _ in range(_POINTS):
        relative = _relative(e, draw)
        if relative is not None and relative > tolerance:
            return False
        is_decided = is_decided or relative is not None
    return is_decided or bool(sp.simplify(e) == 0)


def is_cancelled_sum(w: sp.Expr, v: sp.Expr, total: sp.Expr) -> bool:
    """True if two frequencies add up to zero. total: their sum, expanded."""
    if w.is_Integer and v.is_Integer:
        return bool(total == 0)
    if w.is_number and v.is_number:
        return bool(abs(number(total)) <= SAME * (abs(number(w)) + abs(number(v))))
    return is_identically_zero(total, SAME)


def number(e: sp.Expr) -> mpmath.mpc:
    """The value of an expression without symbols, to 40 digits. Raises ``TypeError`` where it has none."""
    re, im = sp.N(e, _DIGITS).as_real_imag()
    if not (re.is_Number and im.is_Number and re.is_finite and im.is_finite):
        raise TypeError(f"{e} has no value")
    with mpmath.workdps(_DIGITS):
        return mpmath.mpc(mpmath.mpf(str(re)), mpmath.mpf(str(im)))


def _relative(e: sp.Expr, draw: random.Random) -> float | None:
    """|e| over the size of its terms, at a random point, or None where it has no value there."""
    with mpmath.workdps(_DIGITS):
        symbols = sorted(e.free_symbols, key=sp.default_sort_key)
        point: Point = {
            s: (value, abs(value)) for s, value in zip(symbols, (_draw_value(s, draw) for s in symbols), strict=True)
        }
        try:
            value, size = _evaluate(e, point)
            return float(abs(value) / size) if size else 0.0
        except (TypeError, ValueError, ArithmeticError, AttributeError):  # a function without a number, or its pole
            return None


def _draw_value(symbol: sp.Symbol, draw: random.Random) -> mpmath.mpc:
    """A value that the symbol's assumptions allow, of either sign where they do."""
    size = mpmath.mpc(draw.randint(2, 99)) if symbol.is_integer else mpmath.mpc(1 + 2 * draw.random())
    positive = draw.random() < 0.5
    if symbol.is_nonnegative or symbol.is_nonpositive:
        positive = bool(symbol.is_nonnegative)
    return size if positive else -size


def _evaluate(e: sp.Expr, point: Point) -> tuple[mpmath.mpc, mpmath.mpf]:
    """Value and size of an expression, each of its subexpressions once."""
    if e not in point:
        if e.is_Add or e.is_Mul:
            values, sizes = zip(*(_evaluate(a, point) for a in e.args), strict=True)
            together = mpmath.fsum if e.is_Add else mpmath.fprod
            point[e] = together(values), together(sizes)
        elif e.is_Pow and e.exp.is_Integer:
            value, size = _evaluate(e.base, point)
            if e.exp.is_negative and abs(value) <= _EXACT * size:
                raise ZeroDivisionError
            power = value ** int(e.exp)
            point[e] = power, size ** int(e.exp) if e.exp.is_positive else abs(power)
        else:
            arguments = [sp.sympify(_evaluate(a, point)[0]) for a in e.args] if e.free_symbols else ()
            value = number(e.func(*arguments) if e.free_symbols else e)
            point[e] = value, abs(value)
    return point[e]
