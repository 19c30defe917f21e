"""Exact means over a variable, and antiderivatives of mean zero, of sums and products of sines and cosines.

The mean is that of 002 (3.5) and (3.9), lim 1/T int_0^T, which exists for any frequencies, commensurate or not. Quotients of
sines and cosines with one period have a mean by the residue theorem where their poles are numbers. All else is refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.quotients import mean_of_quotients
from wucht.mechanics.trigonometric import NotTrigonometricError, harmonics


@dataclass(frozen=True)
class Mean:
    """A mean, and the frequencies that must not be zero for it to hold: those of what oscillates."""

    value: sp.Expr
    frequencies: tuple[sp.Expr, ...]


def mean(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """lim (1/T) int_0^T of the expression, exact.

    Raises ``WuchtError`` with the reason where there is none, or none was found.
    """
    return mean_and_frequencies(expression, variable).value


def mean_and_frequencies(expression: sp.Expr, variable: sp.Symbol) -> Mean:
    """The mean, and the frequencies other than zero. Raises ``WuchtError`` as ``mean``."""
    try:
        waves = harmonics(expression, variable)
        return Mean(waves.mean, waves.frequencies)
    except NotTrigonometricError:
        return Mean(*mean_of_quotients(sp.sympify(expression), variable))


def antiderivative(expression: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """The antiderivative, of mean zero, of what the expression is without its mean. Raises ``WuchtError`` as ``harmonics``."""
    return harmonics(expression, variable).antiderivative
