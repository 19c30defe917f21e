"""004: the angle of a shaft whose speed fluctuates."""

from __future__ import annotations

import sympy as sp

from .check import Claim, check, equal

SOURCE = "004"


@check(
    SOURCE,
    "(4)",
    r"\varphi",
    "One order j of the speed, j omega t = theta, omega = 2 pi/T: the residual is d phi/dt less the measured speed.",
)
def equation_4() -> Claim:
    a, b, j, omega, theta = sp.symbols("a_j b_j j omega theta", real=True)
    speed = omega + a * sp.cos(theta) + b * sp.sin(theta)
    wave = a * sp.sin(theta) - b * sp.cos(theta)
    printed, right = (theta / j + wave / divisor for divisor in (j, j * omega))
    return Claim(printed, lambda e: j * omega * sp.diff(e, theta) - speed, right)


@check(
    SOURCE,
    "after (3)",
    "c_{n+2m}",
    "The highest order, n = 1, m = 2: the factor of cos(5 theta) in cos(theta + a sin(2 theta)), in its part with a^2.",
)
def highest_order() -> Claim:
    a, theta = sp.symbols("a theta", real=True)
    second = sp.diff(sp.cos(theta + a * sp.sin(2 * theta)), a, 2).subs(a, 0) / 2 * a**2
    derived = sp.integrate(sp.expand(sp.expand_trig(second * sp.cos(5 * theta))), (theta, 0, 2 * sp.pi)) / sp.pi
    return equal(sp.S.Zero, derived, a**2 / 8)
