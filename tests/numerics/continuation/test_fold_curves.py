from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq
from tests.refusals import rejected

from auto_demos import AB
from wucht.errors import RunError
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.continuation.fold_curves import Fold, Folds
from wucht.numerics.continuation.two_parameters import SpecialCurve
from wucht.system import System

X, Y, Z, P, Q = sp.symbols("x y z p q", real=True)
CUSP = System((X,), (X**3 - Q * X - P,), (P, Q))
TAKENS = System((X, Y), (Y, P + Q * X + X**2 + X * Y), (P, Q))
# x: a fold at p = 0; y + i z turns with the speed 2 and grows with q + x.
ZERO_HOPF = System((X, Y, Z), (P + X**2 + Y**2 + Z**2, (Q + X) * Y - 2 * Z, 2 * Y + (Q + X) * Z), (P, Q))


def folds(system: System, *bounds: tuple[float, float], scale: Mapping[str, float] | None = None) -> Folds:
    return Folds(EquilibriumEquations.from_system(system, system.parameter_names[:2], {}, scale), bounds)


def assert_folds(system: System, curve: SpecialCurve[Fold]) -> None:
    """f = 0 and an eigenvalue of zero at each point, the Jacobian being a symbolic one."""
    unknowns = (*system.states, *system.parameters)
    f = sp.lambdify(unknowns, sp.Matrix(system.derivatives), "numpy")
    A = sp.lambdify(unknowns, sp.Matrix(system.derivatives).jacobian(system.states), "numpy")
    for solution in curve.unknowns.T:
        matrix = np.array(A(*solution), float)
        assert np.abs(f(*solution)).max() < 1e-11
        assert np.linalg.svd(matrix, compute_uv=False)[-1] < 1e-10 * max(1.0, np.abs(matrix).max())


def test_the_cusp_and_its_fold_curve() -> None:
    """x^3 - q x - p = 0: 27 p^2 = 4 q^3, the cusp at zero."""
    problem = folds(CUSP, (-2, 2), (-1, 2))
    curve = problem.follow_curve(problem.start([0.5], (-0.25, 0.75)))
    assert curve.ends == ("it leaves the range at q = 2", "it leaves the range at q = 2")
    p, q = curve.parameter_values
    np.testing.assert_allclose(27 * p**2, 4 * q**3, atol=1e-12)
    (cusp,) = curve.special
    assert cusp.kind == "cusp" and np.abs(cusp.unknowns).max() < 1e-10
    assert cusp.coefficients == {"a": pytest.approx(0, abs=1e-9), "c": pytest.approx(1)}
    assert_folds(CUSP, curve)


def test_bogdanov_takens_on_a_fold_curve() -> None:
    """p = q^2 / 4, x = -q / 2; w = (0, 1) and v = (1, 0) wherever x = 0."""
    problem = folds(TAKENS, (-2, 2), (-2, 2))
    curve = problem.follow_curve(problem.start([0.3, 0.1], (0.1, -0.5)))
    p, q = curve.parameter_values
    np.testing.assert_allclose(p, q**2 / 4, atol=1e-12)
    np.testing.assert_allclose(curve.unknowns[0], -q / 2, atol=1e-11)
    (takens,) = curve.special
    assert takens.kind == "bogdanov-takens" and np.abs(takens.unknowns).max() < 1e-10
    assert takens.coefficients == pytest.approx({"a": 1, "b": 1}, rel=1e-9)
    assert_folds(TAKENS, curve)


def test_ab_folds_have_the_form_that_follows_from_its_equilibria() -> None:
    """u2 = p2 u1 / 4, p1 = u1 / (1 - u1) exp(-u2); folds: p2 = 4 / (u1 (1 - u1)), so a cusp at u1 = 1/2: (exp(-2), 16).

    There p2 u1 = 5 + u1 / (1 - u1), a trace of zero, at u1 = 1/4: p2 = 64/3.
    """
    problem = folds(AB, (0, 1), (5, 40))
    one = EquilibriumContinuation(EquilibriumEquations.from_system(AB, ["p1"], {"p2": 18.0}), (0, 0.5))
    located = [p for p in one.follow_branch(one.start([0, 0], 0.0)).special if p.kind == "fold"]
    curve = problem.follow_curve(problem.start(located[0].x, (located[0].parameter, 18.0)))
    x, _, p1, p2 = curve.unknowns
    np.testing.assert_allclose(p2, 4 / (x * (1 - x)), rtol=1e-10)
    np.testing.assert_allclose(p1, x / (1 - x) * np.exp(-1 / (1 - x)), rtol=1e-10)
    assert min(np.abs(curve.parameter_values - [[located[1].parameter], [18.0]]).sum(axis=0)) < 0.1
    special = {p.kind: p for p in curve.special}
    assert special.keys() == {"cusp", "bogdanov-takens"}
    np.testing.assert_allclose(special["cusp"].parameter_values, [math.exp(-2), 16], rtol=1e-10)
    np.testing.assert_allclose(special["cusp"].x, [0.5, 2], rtol=1e-9)
    np.testing.assert_allclose(special["bogdanov-takens"].parameter_values, [math.exp(-4 / 3) / 3, 64 / 3], rtol=1e-10)
    assert np.abs(special["bogdanov-takens"].eigenvalues).max() < 1e-6  # the square root of rounding
    assert_folds(AB, curve)


def test_zero_hopf_on_a_fold_curve() -> None:
    """p = 0, q = 0, in coordinates in which the fold curve is not straight."""
    # New x = old x + y^2 + q^2 / 3, new y = old y + sin(new x) / 5: invertible one after the other.
    old_y = Y - sp.sin(X) / 5
    old_x = X - old_y**2 - Q**2 / 3
    put = {X: old_x, Y: old_y}
    rates = [sp.sympify(e).subs(put, simultaneous=True) for e in ZERO_HOPF.derivatives]
    new_x = rates[0] + 2 * old_y * rates[1]
    system = System((X, Y, Z), (new_x, rates[1] + sp.cos(X) / 5 * new_x, rates[2]), (P, Q))
    problem = folds(system, (-1, 1), (-0.8, 0.8))
    curve = problem.follow_curve(problem.start([0.08, 0.0, 0.0], (0.0, -0.5)))
    (special,) = curve.special
    assert special.kind == "zero-hopf" and np.abs(special.parameter_values).max() < 1e-10
    np.testing.assert_allclose(special.eigenvalues[1:], [2j, -2j], atol=1e-9)
    assert np.abs(curve.parameter_values[0]).max() < 1e-11
    assert_folds(system, curve)


def test_a_neutral_saddle_on_a_fold_curve_is_no_zero_hopf_point() -> None:
    """Eigenvalues 0, 1 and q - 1: the last two add up to zero at q = 0."""
    problem = folds(System((X, Y, Z), (P + X**2, Y, (Q - 1) * Z), (P, Q)), (-1, 1), (-0.5, 0.5))
    assert problem.follow_curve(problem.start([0, 0, 0], (0, 0.2))).special == ()


def test_other_units_give_the_same_special_points() -> None:
    """u2 in millionths, p1 in thousandths."""
    u2, p1 = AB.states[1], AB.parameters[0]
    rates = [d.xreplace({u2: u2 / 10**6, p1: p1 / 1000}) for d in AB.derivatives]
    system = System(AB.states, (rates[0], rates[1] * 10**6), AB.parameters)
    problem = folds(system, (0, 1000), (5, 40), scale={"u2": 1e6, "p1": 1e3})
    curve = problem.follow_curve(problem.start([0.4, 1.7e6], (130, 16.7)))
    special = {p.kind: p.parameter_values for p in curve.special}
    np.testing.assert_allclose(special["cusp"], [1000 * math.exp(-2), 16], rtol=1e-10)
    np.testing.assert_allclose(special["bogdanov-takens"], [1000 * math.exp(-4 / 3) / 3, 64 / 3], rtol=1e-10)


def test_two_parameters_are_needed() -> None:
    with rejected("one-parameter"):
        Folds(EquilibriumEquations.from_system(AB, ["p1"], {"p2": 15.0}), [(0, 1), (0, 1)])


def test_no_fold_is_near() -> None:
    problem = folds(System((X,), (X + P + Q,), (P, Q)), (-1, 1), (-1, 1))
    with pytest.raises(RunError):
        problem.start([0.0], (0.0, 0.0))


def test_the_cusp_of_a_bent_manifold_lies_where_a_symbolic_form_vanishes() -> None:
    """x' = p - x^2 + q y + x^3, y' = -y + sin(x) + x^2: y is known, and what is left is a scalar problem."""
    system = System((X, Y), (P - X**2 + Q * Y + X**3, -Y + sp.sin(X) + X**2), (P, Q))
    problem = folds(system, (-3, 3), (-3, 3))
    curve = problem.follow_curve(problem.start([0.5, 0.7], (0.0, 0.2)))
    # f = p - x^2 + q g(x) + x^3 with g = sin x + x^2: f' = 0 gives q, f'' = 0 the cusp.
    g1, g2 = (lambda x: math.cos(x) + 2 * x), (lambda x: -math.sin(x) + 2)
    q = lambda x: (2 * x - 3 * x**2) / g1(x)  # noqa: E731
    x = brentq(lambda x: -2 + q(x) * g2(x) + 6 * x, 0.1, 1.2, xtol=1e-15)
    at = next(p for p in curve.special if p.kind == "cusp" and abs(p.x[0] - x) < 0.1)
    np.testing.assert_allclose(at.x, [x, math.sin(x) + x**2], rtol=1e-9)
    np.testing.assert_allclose(at.parameter_values, [x**2 - x**3 - q(x) * (math.sin(x) + x**2), q(x)], rtol=0, atol=1e-10)


def test_points_come_one_by_one() -> None:
    problem = folds(CUSP, (-2, 2), (-1, 2))
    walk = problem.walk(problem.start([0.5], (-0.25, 0.75)))
    assert len(list(itertools.islice(walk, 3))) == 3 and walk.end == ""
    assert list(walk)[-1].parameter_values[1] == 2 and walk.end == "it leaves the range at q = 2"
