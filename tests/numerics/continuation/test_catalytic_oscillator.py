"""The oscillator of Bykov, Yablonskii and Kim for the oxidation of CO, which MatCont's manual goes through.

A. Dhooge, W. Govaerts, Yu. A. Kuznetsov, W. Mestrom, A. M. Riet, B. Sautois, "MATCONT and CL_MATCONT: Continuation toolboxes
in MATLAB", example "a catalytic oscillator": q1 = 2.5, q3 = 10, q4 = 0.0675, q5 = 1, q6 = 0.1, k = 0.4. It prints six
decimals of points that it locates to about 1e-6 in the parameter and 5e-6 in the state; its first Lyapunov coefficient is omega
times ours. Points where two conditions hold are compared with their equations in exact arithmetic, solved with 30 digits.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from symbolic_forms import tensor_lyapunov
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import Equilibrium, EquilibriumContinuation
from wucht.numerics.continuation.fold_curves import Folds
from wucht.numerics.continuation.hopf_curves import HopfPoints
from wucht.numerics.continuation.two_parameters import fold_form, hopf_form
from wucht.system import System

X, Y, S, Q2, K = STATES = sp.symbols("x y s q2 k", real=True)
FREE = 1 - X - Y - S
RATES = (
    5 * FREE**2 - 2 * X**2 - 10 * X * Y,
    Q2 * FREE - Y / 10 - 10 * X * Y,
    sp.Rational(27, 400) * (FREE - K * S),
)
SYSTEM = System((X, Y, S), RATES, (Q2, K))
BOUNDS, STEPS = [(0, 3), (0, 3)], Steps(most=0.05)
MATCONT = [  # x, y, s, q2, coefficient
    ("hopf", (0.016357, 0.523973, 0.328336, 1.051558), 10.70259),
    ("fold", (0.024717, 0.450257, 0.375018, 1.042049), 0.1166509),
    ("fold", (0.054030, 0.302241, 0.459807, 1.052200), -0.1346534),
    ("hopf", (0.077929, 0.233063, 0.492149, 1.040991), 4.332247),
]


@pytest.fixture(scope="module")
def equations() -> EquilibriumEquations:
    return EquilibriumEquations.from_system(SYSTEM, ["q2", "k"], {})


@pytest.fixture(scope="module")
def located() -> tuple[Equilibrium, ...]:
    problem = EquilibriumContinuation(EquilibriumEquations.from_system(SYSTEM, ["q2"], {"k": 0.4}), (0.5, 2), STEPS)
    return tuple(sorted(problem.follow_branch(problem.start([0.016, 0.524, 0.328], 1.0516)).special, key=lambda p: p.x[0]))


def solved(conditions: list[sp.Expr], near: np.ndarray) -> np.ndarray:
    """The solution near a point of the equilibrium's equations and some more, by Newton's method with 30 digits."""
    found = sp.nsolve([*RATES, *conditions], STATES, near.tolist(), prec=30)
    return np.array(found, float).ravel()


def characteristic() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Of lambda^3 + c2 lambda^2 + c1 lambda + c0: c0, c1, c2."""
    _, c2, c1, c0 = sp.Matrix(RATES).jacobian((X, Y, S)).charpoly().all_coeffs()
    return c0, c1, c2


def test_what_one_parameter_shows(located: tuple[Equilibrium, ...]) -> None:
    one = EquilibriumEquations.from_system(SYSTEM, ["q2"], {"k": 0.4})
    assert [p.kind for p in located] == [kind for kind, _, _ in MATCONT]
    for point, (kind, unknowns, coefficient) in zip(located, MATCONT, strict=True):
        np.testing.assert_allclose(point.unknowns, unknowns, rtol=0, atol=5e-6)
        assert point.parameter == pytest.approx(unknowns[3], abs=1e-6)
        form = hopf_form(one, point.unknowns, point.frequency) if kind == "hopf" else None
        got = form.l1 * form.frequency if form else fold_form(one, point.unknowns)[0]
        assert got == pytest.approx(coefficient, rel=3e-4)


def test_the_fold_curve(equations: EquilibriumEquations, located: tuple[Equilibrium, ...]) -> None:
    """Two Bogdanov-Takens points, c0 = c1 = 0, and a cusp: c0 = 0 = <w, B(v, v)>, w and v from the adjugate matrix."""
    problem = Folds(equations, BOUNDS, STEPS)
    curve = problem.follow_curve(problem.start(located[1].x, (located[1].parameter, 0.4)))
    assert sorted(p.kind for p in curve.special) == ["bogdanov-takens", "bogdanov-takens", "cusp"]
    A = sp.Matrix(RATES).jacobian((X, Y, S))
    v, w = A.adjugate()[:, 0], A.adjugate()[0, :]
    quadratic = sum(w[i] * (v.T * sp.hessian(RATES[i], (X, Y, S)) * v)[0] for i in range(3))
    c0, c1, _ = characteristic()
    for point in curve.special:
        second = c1 if point.kind == "bogdanov-takens" else quadratic
        np.testing.assert_allclose(point.unknowns, solved([c0, second], point.unknowns), rtol=0, atol=1e-10)


def test_the_hopf_curve(equations: EquilibriumEquations, located: tuple[Equilibrium, ...]) -> None:
    """c1 c2 = c0 from one Bogdanov-Takens point to the other, through both Hopf points of k = 0.4."""
    problem = HopfPoints(equations, BOUNDS, STEPS)
    c0, c1, c2 = characteristic()
    numbers = sp.lambdify(STATES, (c0, c1, c2), "numpy")
    curve = problem.follow_curve(problem.start(located[0].x, (located[0].parameter, 0.4), located[0].frequency))
    c0s, c1s, c2s = numbers(*curve.unknowns)
    np.testing.assert_allclose(c1s * c2s, c0s, rtol=0, atol=1e-11)  # rounding: 2e-12
    np.testing.assert_allclose([p.frequency**2 for p in curve.points], c1s, rtol=0, atol=1e-12)
    assert min(np.abs(curve.unknowns[3:] - [[located[3].parameter], [0.4]]).max(axis=0)) < 0.05
    kinds = [p.kind for p in curve.special]
    assert kinds == ["bogdanov-takens", "generalised-hopf", "generalised-hopf", "bogdanov-takens"]
    assert all(end.startswith("it ends at a Bogdanov-Takens point") for end in curve.ends)
    for point in curve.special:
        if point.kind == "bogdanov-takens":
            np.testing.assert_allclose(point.unknowns, solved([c0, c1], point.unknowns), rtol=0, atol=1e-10)
        else:
            assert abs(tensor_lyapunov(SYSTEM, point.unknowns)) < 1e-8  # where nothing happens it is 10 to 200
    signs = [np.sign(p.coefficients["l1"]) for p in curve.points if not p.kind]
    assert np.abs(np.diff(signs)).sum() == 4  # it changes twice
