from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from equations_by_hand import by_hand
from tests.refusals import failed

from auto_demos import AB, LORENZ
from symbolic_forms import forms, planar_lyapunov, tensor_lyapunov
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.continuation.two_parameters import bogdanov_takens_form, expansion, fold_form, hopf_form
from wucht.system import System

X, Y, P, Q = sp.symbols("x y p q", real=True)


def ab_hopf(x: float) -> np.ndarray:
    """f(u) = 0 and a trace of zero, solved by hand: u2 = p2 u1 / 4, p1 = u1 / (1 - u1) exp(-u2), p2 u1 = 5 + u1 / (1 - u1)."""
    p2 = (5 + x / (1 - x)) / x
    return np.array([x, p2 * x / 4, x / (1 - x) * math.exp(-p2 * x / 4), p2])


def ab_fold(x: float) -> np.ndarray:
    """p2 = 4 / (u1 (1 - u1))."""
    p2 = 4 / (x * (1 - x))
    return np.array([x, p2 * x / 4, x / (1 - x) * math.exp(-p2 * x / 4), p2])


@pytest.mark.parametrize("x", [0.3, 0.9])
def test_derivatives_agree_with_symbolic_ones(x: float) -> None:
    equations, unknowns = EquilibriumEquations.from_system(AB, ["p1", "p2"], {}), ab_hopf(x)
    A, B, C = forms(AB, unknowns)
    directions = np.array([[1.0, 0.3], [-0.4, 2.0]])
    A_found, first, second_found = expansion(equations, unknowns, directions)
    np.testing.assert_allclose(A_found, A, rtol=1e-13)
    np.testing.assert_allclose(first, np.einsum("ijk,kd->ijd", B, directions), rtol=1e-10, atol=1e-10 * np.abs(B).max())
    second = np.einsum("ijkl,kd,ld->ijd", C, directions, directions)
    np.testing.assert_allclose(second_found, second, rtol=1e-9, atol=1e-9 * np.abs(C).max())


@pytest.mark.parametrize("x", [0.3, 0.9])
def test_first_lyapunov_coefficient_by_another_formula(x: float) -> None:
    """Guckenheimer and Holmes (3.4.11), from symbolic derivatives in the coordinates of the Jordan form."""
    unknowns = ab_hopf(x)
    form = hopf_form(EquilibriumEquations.from_system(AB, ["p1", "p2"], {}), unknowns)
    omega, expected = planar_lyapunov(AB, unknowns)
    assert form.frequency == pytest.approx(omega, rel=1e-12)
    assert form.l1 == pytest.approx(expected, rel=1e-9)


def test_lorenz_loses_stability_subcritically() -> None:
    """At rho = 470/19, as has been known since Marsden and McCracken 1976; l1 from symbolic derivatives."""
    problem = EquilibriumContinuation(EquilibriumEquations.from_system(LORENZ, ["rho"], {}), (20, 26))
    size = math.sqrt(8 / 3 * 21)
    (hopf,) = problem.follow_branch(problem.start([size, size, 21], 22.0)).special
    form = hopf_form(problem.equations, hopf.unknowns, hopf.frequency)
    assert not form.supercritical
    assert form.l1 == pytest.approx(tensor_lyapunov(LORENZ, hopf.unknowns), rel=1e-9)
    assert form.eigenvalues[2] == pytest.approx(-(10 + 1 + 8 / 3), rel=1e-9)


@pytest.mark.parametrize("x", [0.3, 0.7])
def test_quadratic_coefficient_of_a_fold(x: float) -> None:
    """w^T B(v, v) / (2 w^T v), v of unit length, from symbolic derivatives."""
    unknowns = ab_fold(x)
    A, B, _ = forms(AB, unknowns)
    v, w = sp.Matrix(A).evalf(40).nullspace(iszerofunc=lambda e: abs(e) < 1e-12), np.linalg.svd(A)[0][:, -1]
    q = np.array(v[0], float).ravel()
    q *= np.sign(q[0]) / np.linalg.norm(q)
    expected = np.einsum("i,ijk,j,k", w, B, q, q) / (2 * w @ q)
    assert fold_form(EquilibriumEquations.from_system(AB, ["p1", "p2"], {}), unknowns)[0] == pytest.approx(expected, rel=1e-9)


def test_cubic_coefficient_of_a_cusp_on_a_bent_centre_manifold() -> None:
    """x' = p - x^3/3 + x y, y' = -y + 2 x^2: y = 2 x^2 there, so c = 2 - 1/3."""
    system = System((X, Y), (P + Q * X - X**3 / 3 + X * Y, -Y + 2 * X**2), (P, Q))
    a, c = fold_form(EquilibriumEquations.from_system(system, ["p", "q"], {}), np.zeros(4))
    assert a == pytest.approx(0, abs=1e-10)
    assert c == pytest.approx(5 / 3, rel=1e-9)


def test_bogdanov_takens_coefficients_do_not_depend_on_coordinates() -> None:
    """x' = y, y' = p + q x + 3 x^2 - 2 x y, in other coordinates whose linear part keeps the null vector."""
    old_y = Y - (sp.exp(X) - 1 - X)  # new y = old y + exp(x) - 1 - x
    forced = P + Q * X + 3 * X**2 - 2 * X * old_y
    system = System((X, Y), (old_y, forced + (sp.exp(X) - 1) * old_y), (P, Q))
    form = bogdanov_takens_form(EquilibriumEquations.from_system(system, ["p", "q"], {}), np.zeros(4))
    assert form == pytest.approx((3, -2), rel=1e-9)


def test_no_hopf_form_without_a_complex_pair() -> None:
    with failed("no-pair"):
        hopf_form(EquilibriumEquations.from_system(System((X, Y), (X, P * Y), (P,)), ["p"], {}), np.array([0.0, 0.0, -1.0]))


def test_derivatives_are_as_accurate_for_states_of_any_size() -> None:
    """Of exp(x/1000) y^2 with x of a size of 1000 and y of 0.01, along (1, 0), (0, 1), and where nothing changes."""
    equations = by_hand([sp.exp(X / 1000) * Y**2, P + Q + Y], [X, Y], [P, Q]).with_scale(np.array([1e3, 1e-2, 1.0, 1.0]))
    y = 0.03
    A, first, second = expansion(equations, np.array([0.0, y, 0.0, 0.0]), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    assert A[0] == pytest.approx([1e-3 * y**2, 2 * y], rel=1e-12)
    assert first[0, :, 0] == pytest.approx([1e-6 * y**2, 2e-3 * y], rel=1e-9)
    assert first[0, :, 1] == pytest.approx([2e-3 * y, 2.0], rel=1e-9)
    assert second[0, :, 0] == pytest.approx([1e-9 * y**2, 2e-6 * y], rel=1e-7, abs=0.0)
    assert second[0, :, 1] == pytest.approx([2e-3, 0.0], rel=1e-7, abs=1e-6)
    assert np.abs(first[..., 2]).max() < 1e-13 and np.abs(second[..., 2]).max() == 0.0
