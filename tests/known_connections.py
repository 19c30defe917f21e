"""Systems whose connections of saddles and saddle-nodes are known in closed form."""

from __future__ import annotations

import math

import sympy as sp
from scipy.special import exp1

from wucht.system import System

X, Y, A, B, C, MU, P, R = sp.symbols("x y a b c mu p r", real=True)
LEAF = System(
    (X, Y),
    (
        C + A * X + 2 * Y - A * X**2,
        2 * X + (A + MU) * Y - 3 * X**2 - sp.Rational(3, 2) * A * X * Y + B * (X**2 * (1 - X) - Y**2),
    ),
    (C, MU, A, B),
)
"""The leaf x^2 (1 - x) = y^2 is an orbit that returns to the origin where c = mu = 0, for each a and b; the eigenvalues there
are a + 2 and a - 2. Yu. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer 2004, example 6.1 (B. Sandstede)."""

LOOP = System(LEAF.states, tuple(d.subs({C: sp.Rational(1, 20) - P**2, A: -2}) for d in LEAF.derivatives), (P, MU, B))
"""The leaf at a = -2 with c = 1/20 - p^2: where that is 0 and mu = 0 an orbit returns to a saddle-node along its strongly
stable direction. Where c is greater there is an orbit around the focus within the leaf, and no equilibrium on its way."""

BETWEEN = System((X, Y), (P + X**2 * (1 - X), -(1 - X) * Y + X * Y**2 + R * X + MU * X * (1 - X)), (P, MU, R))
"""A saddle-node at the origin is left along x where p = 0; one at (1, 0), where r = 0, is reached along x, y being slow there.
The line y = 0 leads from one to the other where mu = 0, too. With r < 0 there is a saddle at (1, sqrt(-r))."""

GOMPERTZ = math.e * float(exp1(1.0))
"""Where p = 0 and mu is small, the orbit from the origin comes to y = mu e E1(1) at x = 1: dy/dx = -y/x^2 + mu/x."""
