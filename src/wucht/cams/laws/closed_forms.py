"""Dwell motions of finitely many harmonics that are known in closed form: a rise by a stroke at pi, and a dwell about 0."""

from __future__ import annotations

import math

import numpy as np

from wucht.numerics.harmonics import Harmonics


def equiripple(count: int, half_dwell: float, stroke: float = 1.0) -> Harmonics:
    """The flattest motion of so many harmonics: on |phi| <= half_dwell it goes to and fro as little as possible.

    stroke T_N(u(phi))/T_N(u(pi)), with Chebyshev's polynomial and u linear in cos phi, such that |u| <= 1 on the dwell: so far
    as stroke/T_N((3 + c)/(1 - c)), c = cos half_dwell.
    """
    c = math.cos(half_dwell)
    phi = 2 * math.pi * np.arange(2 * count + 1) / (2 * count + 1)
    polynomial = np.polynomial.Chebyshev.basis(count)
    top = polynomial(-(3 + c) / (1 - c))
    return Harmonics.sampled(stroke * polynomial((2 * np.cos(phi) - 1 - c) / (1 - c)) / top)


def maximally_flat(count: int, stroke: float = 1.0) -> Harmonics:
    """stroke sin^(2N)(phi/2): of its derivatives at 0 all vanish below that of order 2 N."""
    k = np.arange(count + 1)
    terms = np.array([math.comb(2 * count, count - int(i)) for i in k]) / 4**count * (-1.0) ** k
    return Harmonics.of(stroke * terms[0], 2 * stroke * terms[1:])
