from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq
from tests.refusals import failed

from auto_demos import AB
from symbolic_forms import planar_lyapunov
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.continuation.fold_curves import Folds
from wucht.numerics.continuation.hopf_curves import HopfPoint, HopfPoints
from wucht.numerics.continuation.two_parameters import SpecialCurve
from wucht.system import System

X, Y, Z, W, P, Q = sp.symbols("x y z w p q", real=True)
TAKENS = System((X, Y), (Y, P + Q * X + X**2 + X * Y), (P, Q))
ENDS = "it ends at a Bogdanov-Takens point"


def hopf_points(system: System, *bounds: tuple[float, float]) -> HopfPoints:
    return HopfPoints(EquilibriumEquations.from_system(system, system.parameter_names[:2], {}), bounds)


def ab_hopf(x: float) -> np.ndarray:
    """See ``test_normal_forms``."""
    p2 = (5 + x / (1 - x)) / x
    return np.array([x, p2 * x / 4, x / (1 - x) * math.exp(-p2 * x / 4), p2])


def assert_hopf_points(system: System, curve: SpecialCurve[HopfPoint]) -> None:
    """f = 0 and a pair of eigenvalues +-i omega at each point, the Jacobian being a symbolic one."""
    unknowns = (*system.states, *system.parameters)
    f = sp.lambdify(unknowns, sp.Matrix(system.derivatives), "numpy")
    A = sp.lambdify(unknowns, sp.Matrix(system.derivatives).jacobian(system.states), "numpy")
    for point in curve.points:
        matrix = np.array(A(*point.unknowns), float)
        assert np.abs(f(*point.unknowns)).max() < 1e-11
        shifted = matrix @ matrix + point.frequency**2 * np.eye(len(matrix))
        assert np.linalg.svd(shifted, compute_uv=False)[-2:].max() < 1e-9 * max(1.0, np.abs(matrix).max() ** 2)


def test_bogdanov_takens_ends_a_hopf_curve() -> None:
    """Hopf: p = 0, x = 0, omega^2 = -q, for q < 0 only."""
    problem = hopf_points(TAKENS, (-1, 1), (-2, 2))
    curve = problem.follow_curve(problem.start([0.05, 0.0], (0.0, -1.0)))
    np.testing.assert_allclose([p.frequency**2 for p in curve.points], -curve.parameter_values[1], atol=1e-10)
    assert np.abs(curve.unknowns[:3]).max() < 1e-11
    assert sorted(e[: len(ENDS)] for e in curve.ends) == [ENDS, "it leaves the range at q = -2"]
    (takens,) = curve.special
    assert takens in (curve.points[0], curve.points[-1]) and np.abs(takens.unknowns).max() < 1e-10
    assert takens.coefficients == pytest.approx({"a": 1, "b": 1}, rel=1e-9)
    assert all(p.coefficients["l1"] > 0 for p in curve.points if not p.kind)  # a b > 0: unstable orbits
    assert_hopf_points(TAKENS, curve)


def test_a_hopf_curve_begins_at_a_bogdanov_takens_point_of_a_fold_curve() -> None:
    problem = Folds(EquilibriumEquations.from_system(TAKENS, ["p", "q"], {}), [(-2, 2), (-2, 2)])
    (takens,) = problem.follow_curve(problem.start([0.3, 0.1], (0.1, -0.5))).special
    hopf = hopf_points(TAKENS, (-1, 1), (-2, 2))
    curve = hopf.follow_curve(hopf.start(takens.x, takens.parameter_values, 0.0))
    assert sorted(e[: len(ENDS)] for e in curve.ends) == [ENDS, "it leaves the range at q = -2"]
    assert [p.kind for p in curve.special] == ["bogdanov-takens"] and curve.parameter_values[1].max() < 1e-9


def test_ab_hopf_curve() -> None:
    """p2 u1 = 5 + u1 / (1 - u1), from a zero trace; l1 vanishes where another formula says so; both ends are known."""
    one = EquilibriumContinuation(EquilibriumEquations.from_system(AB, ["p1"], {"p2": 15.0}), (0, 0.5))
    first, second = (p for p in one.follow_branch(one.start([0, 0], 0.0)).special if p.kind == "hopf")
    problem = hopf_points(AB, (0, 1), (5, 40))
    curve = problem.follow_curve(problem.start(first.x, (first.parameter, 15.0), first.frequency))
    x, u2, p1, p2 = curve.unknowns
    np.testing.assert_allclose(p2, (5 + x / (1 - x)) / x, rtol=1e-10)
    np.testing.assert_allclose(u2, p2 * x / 4, rtol=1e-10)
    np.testing.assert_allclose(p1, x / (1 - x) * np.exp(-u2), rtol=1e-10)
    assert min(np.abs(curve.parameter_values - [[second.parameter], [15.0]]).sum(axis=0)) < 0.1
    special = {p.kind: p for p in curve.special}
    assert special.keys() == {"bogdanov-takens", "generalised-hopf"}
    np.testing.assert_allclose(special["bogdanov-takens"].parameter_values, [math.exp(-4 / 3) / 3, 64 / 3], rtol=1e-10)
    # Zero of l1: both signs of it on either side, by Guckenheimer's and Holmes' formula.
    at = brentq(lambda v: planar_lyapunov(AB, ab_hopf(v))[1], 0.55, 0.6, xtol=1e-13)
    np.testing.assert_allclose(special["generalised-hopf"].unknowns, ab_hopf(at), rtol=1e-9)
    np.testing.assert_allclose(special["generalised-hopf"].parameter_values, ab_hopf(at)[2:], rtol=0, atol=1e-10)
    assert_hopf_points(AB, curve)


def test_zero_hopf_and_generalised_hopf_on_one_curve() -> None:
    """x' = p + x^2 + |z|^2, z' = (q + i 2 + x + x^2) z: Hopf at p = -x^2, q = -x - x^2.

    Reduced to its centre manifold, |z|' = -(1 + 2 x) / (2 x) |z|^3, so that l1 = -(1 + 2 x) / (2 x): a pole at x = 0, where the
    third eigenvalue, 2 x, vanishes, and a zero at x = -1/2.
    """
    growth = Q + Z + Z**2
    system = System((X, Y, Z), (growth * X - 2 * Y, 2 * X + growth * Y, P + Z**2 + X**2 + Y**2), (P, Q))
    problem = hopf_points(system, (-0.7, 1), (-1, 1))
    curve = problem.follow_curve(problem.start([0, 0, 0.3], (-0.09, -0.39), 2.0))
    x = curve.unknowns[2]
    np.testing.assert_allclose(curve.parameter_values, [-(x**2), -x - x**2], atol=1e-11)
    special = sorted(curve.special, key=lambda p: p.kind)
    assert [p.kind for p in special] == ["generalised-hopf", "zero-hopf"]
    np.testing.assert_allclose(special[0].parameter_values, [-0.25, 0.25], atol=1e-10)
    np.testing.assert_allclose(special[1].parameter_values, [0, 0], atol=1e-10)
    assert abs(special[1].noncritical_eigenvalues[0]) < 1e-9
    for point in curve.points:
        if abs(point.x[2]) > 0.02:
            expected = -(1 + 2 * point.x[2]) / (2 * point.x[2])
            assert point.coefficients["l1"] == pytest.approx(expected, rel=1e-8, abs=1e-8)
    assert_hopf_points(system, curve)


def test_double_hopf_of_two_coupled_oscillators() -> None:
    """Both in phase: lambda^2 - p lambda + 1 = 0; in opposition: lambda^2 - (p - 2 q) lambda + 1 + 2 c = 0, c = 0.4.

    Springs that stiffen and dampers that grow with the square of the deflection, different ones. Curves p = 0 and p = 2 q.
    """
    c = sp.Rational(2, 5)
    system = System(
        (X, Y, Z, W),
        (
            Y,
            -X + (P - X**2) * Y - c * (X - Z) - Q * (Y - W),
            W,
            -Z - Z**2 / 3 + (P - 2 * Z**2) * W - c * (Z - X) - Q * (W - Y),
        ),
        (P, Q),
    )
    problem = hopf_points(system, (-0.5, 0.5), (-0.4, 0.3))
    for frequency, start, slope in ((1.0, (0.0, 0.2), 0.0), (math.sqrt(1.8), (0.4, 0.2), 2.0)):
        curve = problem.follow_curve(problem.start(np.full(4, 0.001), start, frequency))
        p, q = curve.parameter_values
        np.testing.assert_allclose(p, slope * q, atol=1e-11)
        (special,) = [s for s in curve.special if s.kind == "double-hopf"]
        assert np.abs(special.parameter_values).max() < 1e-10
        both = sorted([special.frequency, abs(special.noncritical_eigenvalues[0].imag)])
        assert both == pytest.approx([1.0, math.sqrt(1.8)], rel=1e-9)
        assert np.abs(special.noncritical_eigenvalues.real).max() < 1e-9
        assert_hopf_points(system, curve)


def test_a_neutral_saddle_is_no_hopf_point() -> None:
    problem = hopf_points(System((X, Y), (X + 0 * Q, (P - 1) * Y), (P, Q)), (-1, 1), (-1, 1))
    with failed("no-pair"):
        problem.start([0, 0], (0.0, 0.0))
    takens = hopf_points(TAKENS, (-1, 1), (-2, 2))
    with failed("neutral-saddle"):
        takens.start([0, 0], (0.0, 0.5), 0.0)


def test_the_pair_next_to_the_imaginary_axis_gives_the_frequency() -> None:
    """Of two pairs that each have a Hopf point: one with frequency 2 that grows a little, one with 5 that decays faster."""
    s, w = P - X**2 - Y**2, Q - sp.Rational(1, 5)
    two = System((X, Y, Z, W), (s * X - 2 * Y, 2 * X + s * Y, w * Z - 5 * W, 5 * Z + w * W), (P, Q))
    point = hopf_points(two, (-1.0, 1.0), (-1.0, 1.0)).start([0.0, 0.0, 0.0, 0.0], [0.05, 0.0])
    assert np.sqrt(point.unknowns[-1]) == pytest.approx(2.0, rel=1e-9)
