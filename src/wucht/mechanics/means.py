"""Exact means over a variable, and antiderivatives of mean zero, of sums and products of sines and cosines.

The mean is that of 002 (3.5) and (3.9), lim 1/T int_0^T, which exists for any frequencies, commensurate or not. Quotients of
sines and cosines with one period have a mean by the residue theorem where their poles are numbers. All else is refused.
"""

from __future__ import annotations

import sympy as sp

from wucht.mechanics.quotients import mean_of_quotients
from wucht.mechanics.trigonometric import NotTrigonometricError, harmonics


def mean(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """lim (1/T) int_0^T of the expression, exact.

    Raises ``WuchtError`` with the reason where there is none, or none was found.
    """
    return mean_and_frequencies(expression, variable)[0]


def mean_and_frequencies(expression: sp.Expr, variable: sp.Symbol) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """The mean, and the frequencies of what oscillates, which must not be zero for it to hold. Raises ``WuchtError``."""
    try:
        waves = harmonics(expression, variable)
        return waves.mean, waves.frequencies
    except NotTrigonometricError:
        return mean_of_quotients(sp.sympify(expression), variable)


def antiderivative(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """The antiderivative, of mean zero, of what the expression is without its mean. Raises ``WuchtError`` as ``harmonics``."""
    return harmonics(expression, variable).antiderivative
