"""O. Drozdetskaya, dissertation, KIT Karlsruhe 2020: folds of the slow equations in two parameters.

(5.17)-(5.18), the latter with its last term corrected (docs/errata.md), Table 5.1. The folds u1*, u2* were computed
independently, at a root finder's precision: all digits given.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.fold_curves import Folds
from wucht.system import System

OMEGA, PSI, U, SIGMA = sp.symbols("omega psi u sigma", real=True)
FIRST = ([0.7758765, -1.6914641], (1.8331080, 0.1))
SECOND = ([1.4926832, 2.6986434], (5.8710372, 0.1))


def together() -> System:
    epsilon = mu = sp.Rational(1, 100)  # Table 5.1
    s, w, beta_p, beta_r, no_load = sp.Rational(3, 4), sp.Rational(13, 10), 1, sp.Rational(1, 10), 2
    A, B = 1 - OMEGA**2, 2 * SIGMA * OMEGA  # (3.38)
    motor = epsilon * U * (no_load - OMEGA) / (OMEGA * (beta_p + beta_r))
    field = OMEGA**3 / ((A**2 + B**2) * (beta_p + beta_r))
    speed = A * (2 * epsilon * beta_p * w - mu * beta_r * s) * sp.sin(PSI)
    speed -= B * (2 * epsilon * beta_p * w + mu * beta_r * s) * sp.cos(PSI) + B * (2 * mu * beta_r + epsilon * beta_p * s * w)
    phase = B * (2 * epsilon * w - mu * s) * sp.cos(PSI) - A * (2 * epsilon * w + mu * s) * sp.sin(PSI)
    phase += B * (epsilon * s * w - 2 * mu)
    rates = (beta_p * motor + field * speed, -motor + field * phase)
    return System((OMEGA, PSI), rates, (U, SIGMA), angles=frozenset({PSI}))


@pytest.fixture(scope="module")
def problem() -> Folds:
    return Folds(Equations.of(together(), ["u", "sigma"], {}), [(0, 20), (0.01, 1)])


def test_both_folds_over_the_damping(problem: Folds) -> None:
    for (x, values), u in ((FIRST, 5.8600817), (SECOND, 2.6739155)):
        start = problem.start(x, values)
        np.testing.assert_allclose(start.unknowns, [*x, *values], rtol=1e-7)
        lighter = Folds(problem.equations, [(0, 20), (0.05, 0.1)]).branch(start)
        (at,) = [p.parameter_values[0] for p in lighter.points if p.parameter_values[1] == 0.05]
        assert at == pytest.approx(u, rel=2e-8)


def test_both_folds_need_the_same_motor_at_one_damping(problem: Folds) -> None:
    """The curves cross in the plane (u, sigma): the states differ, it is no cusp."""
    curves = [problem.branch(problem.start(*at)) for at in (FIRST, SECOND)]
    assert [c.special for c in curves] == [(), ()]

    def fold(curve: int, sigma: float) -> np.ndarray:
        """On a curve, at a damping: Newton's method from the neighbouring point, in the plane of that damping."""
        nearest = curves[curve].unknowns[:, np.abs(curves[curve].parameter_values[1] - sigma).argmin()]
        return problem.curve(nearest).start(np.append(nearest[:3], sigma), np.array([0.0, 0.0, 0.0, 1.0])).unknowns

    sigma, width = 0.067, 1e-3
    for _ in range(5):  # secants
        off, beyond = (fold(0, s)[2] - fold(1, s)[2] for s in (sigma, sigma + width))
        sigma, width = sigma - off * width / (beyond - off), 1e-6
    assert sigma == pytest.approx(0.0672888, abs=5e-8)
    assert fold(0, sigma)[2] == pytest.approx(3.6873885, abs=5e-8)
    assert abs(fold(0, sigma)[0] - fold(1, sigma)[0]) > 0.6


def test_every_point_is_a_fold(problem: Folds) -> None:
    """The determinant of the symbolic Jacobian in terms of its terms, and the equations themselves."""
    system = together()
    unknowns = (OMEGA, PSI, U, SIGMA)
    f = sp.lambdify(unknowns, system.derivatives, "numpy")
    A = sp.lambdify(unknowns, list(sp.Matrix(system.derivatives).jacobian((OMEGA, PSI))), "numpy")
    for at in (FIRST, SECOND):
        curve = problem.branch(problem.start(*at))
        assert len(curve.points) > 80
        a, b, c, d = A(*curve.unknowns)
        assert np.abs(f(*curve.unknowns)).max() < 1e-13
        assert (np.abs(a * d - b * c) / (np.abs(a * d) + np.abs(b * c))).max() < 1e-9
