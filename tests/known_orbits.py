"""Systems whose periodic orbits are known in closed form: normal forms in bent coordinates.

In all of them a cycle of radius R turns at the rate w = ``speed`` in the plane of x and y; the coordinates are then changed, so
that neither speed nor shape is simple. Multipliers and periods do not depend on coordinates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import sympy as sp

from wucht.system import System

X, Y, Z, W = sp.symbols("x y z w", real=True)
P, Q, SPEED, FREQUENCY = sp.symbols("p q speed frequency", real=True)
SQUARE = X**2 + Y**2


def bent(states: Sequence[sp.Symbol], rates: Sequence[sp.Expr], changes: Mapping[sp.Symbol, sp.Expr]) -> tuple[sp.Expr, ...]:
    """The rates after each coordinate in turn is replaced by itself plus an expression of the others."""
    now = [sp.sympify(rate) for rate in rates]
    for symbol, gain in changes.items():
        i = list(states).index(symbol)
        gained = sum(sp.diff(gain, s) * rate for s, rate in zip(states, now, strict=True))
        now[i] += gained
        now = [rate.xreplace({symbol: symbol - gain}) for rate in now]
    return tuple(now)


PLANE = {X: Y**2 / 5, Y: X**2 / 10}
SPACE = {X: Z * W / 5, Z: X**2 / 5}
EVEN = {X: Z**2 / 5 + Y**2 / 10}


def planar(growth: sp.Expr, *parameters: sp.Symbol, turning: sp.Expr = SPEED) -> System:
    """r' = r growth(r^2), phi' = turning, in coordinates x + y^2/5, y + x^2/10."""
    rates = (growth * X - turning * Y, turning * X + growth * Y)
    states = (X, Y)
    return System(states, bent(states, rates, PLANE), (*parameters, SPEED))


BAUTIN = planar(P + Q * SQUARE - SQUARE**2, P, Q, turning=SPEED + SQUARE / 4)
"""Orbits r^2 = q/2 +- sqrt(q^2/4 + p), period 2 pi/(speed + r^2/4); folds where p = -q^2/4."""

ISOLA = planar(sp.Rational(9, 100) - (SQUARE - 1) ** 2 - P**2, P)
"""Orbits where (r^2 - 1)^2 + p^2 = 0.3^2: a closed branch with folds at p = +-0.3."""

HOPF_TO_HOPF = planar(1 - P**2 - SQUARE, P)
"""Orbits r^2 = 1 - p^2, from the Hopf point p = -1 to p = 1."""


def _with_two(*rates: sp.Expr) -> System:
    states = (X, Y, Z, W)
    cycle = ((1 - SQUARE) * X - SPEED * Y, SPEED * X + (1 - SQUARE) * Y)
    return System(states, bent(states, (*cycle, *rates), SPACE), (P, Q, SPEED, FREQUENCY))


_INSIDE = Z**2 + W**2
_GROWTH = P - Q**2
TORUS_BIRTH = _with_two((_GROWTH - _INSIDE) * Z - FREQUENCY * W, FREQUENCY * Z + (_GROWTH - _INSIDE) * W)
"""The orbit r = 1, z = w = 0: T = 2 pi/speed, ln mu = -2 T, (p - q^2 +- i frequency) T: a torus is born at p = q^2."""

# In a frame that turns by half the angle of (x, y): z' = (p - q^2) z - z^3 along its first axis, w' = -w along the second.
_MEAN, _HALF = (_GROWTH - 1) / 2, (_GROWTH + 1) / 2
MOEBIUS = _with_two(
    (_MEAN + _HALF * X - _INSIDE) * Z + (_HALF * Y - SPEED / 2) * W,
    (_HALF * Y + SPEED / 2) * Z + (_MEAN - _HALF * X - _INSIDE) * W,
)
"""The orbit r = 1, z = w = 0: multipliers -exp((p - q^2) T), -exp(-T): the period doubles at p = q^2, T = 2 pi/speed."""

_STATES = (X, Y, Z)
PITCHFORK = System(
    _STATES,
    bent(
        _STATES,
        ((1 - SQUARE) * X - SPEED * Y, SPEED * X + (1 - SQUARE) * Y, (_GROWTH - Z**2) * Z),
        EVEN,
    ),
    (P, Q, SPEED),
)
"""The orbit r = 1, z = 0, and where p > q^2 two more with z = +-sqrt(p - q^2): the symmetry z -> -z breaks."""


def placed(changes: Mapping[sp.Symbol, sp.Expr], values: Mapping[sp.Symbol, np.ndarray]) -> np.ndarray:
    """States (n, K) in the bent coordinates, from those in the straight ones (K,)."""
    now = dict(values)
    for symbol, gain in changes.items():
        now[symbol] = now[symbol] + sp.lambdify(list(now), gain)(*now.values())
    return np.array([np.broadcast_to(each, np.shape(values[X])) for each in now.values()])
