"""The growth of the difference of like parts, against closed forms and against the variational equations by SciPy."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.transverse_growth import transverse_growth
from wucht.system import System

X, Y, Z, K = sp.symbols("x y z k", real=True)
FIRST, SECOND = np.array([0]), np.array([1])


def growth(system: System, values: tuple[float, ...], state: list[float], duration: float):
    compiled_system = compile_system(system, 1e-10)
    return transverse_growth(compiled_system, np.array(values), np.array(state), (0.0, duration), (FIRST, SECOND))


@pytest.mark.parametrize("k", [-1.4, -1.02, -0.98, 0.3])
def test_two_coupled_wells_leave_their_common_place_at_the_rate_of_the_linear_equations(k: float) -> None:
    """x' = x - x^3 + k (y - x), twice: at x = y = 1 the difference grows by 1 - 3 - 2 k, the sum decays by 2.

    After four units a difference of 1e-6 that decays is 3e-11, known to the tolerance: its logarithm to 1e-3.
    """
    wells = System((X, Y), (X - X**3 + K * (Y - X), Y - Y**3 + K * (X - Y)), (K,))
    found = growth(wells, (k,), [1.0, 1.0], 4.0)
    assert found is not None and found.rate == pytest.approx(-2 - 2 * k, abs=1e-3)
    assert (found.logarithm > 0) == (k < -1)


def test_the_rate_along_a_motion_is_that_of_its_variational_equations() -> None:
    """Two phases in the field of an oscillation, x' = z - a sin x: the difference follows v' = -a cos(x) v, here by LSODA.

    The driving oscillation turns once in 2 pi; the motion repeats, and the mean is that over one turn after transients.
    """
    w = sp.Symbol("w", real=True)
    system = System((X, Y, Z, w), (1 + Z - 0.6 * sp.sin(X), 1 + Z - 0.6 * sp.sin(Y), w, -Z), angles=frozenset({X, Y}))
    start = [0.3, 0.3, 0.5, 0.0]

    def rates(_: float, s: np.ndarray) -> list[float]:
        return [1 + s[1] - 0.6 * np.sin(s[0]), s[2], -s[1], -0.6 * np.cos(s[0])]

    duration = 600.0
    run = solve_ivp(rates, (0, duration), [0.3, 0.5, 0.0, 0.0], method="LSODA", rtol=1e-11, atol=1e-12)
    found = growth(system, (), start, duration)
    assert found is not None and found.rate == pytest.approx(run.y[3, -1] / duration, abs=2e-3)


def test_parts_that_are_not_alike_have_no_growth_of_a_difference() -> None:
    """y is driven by x, and z by both: what grows is no difference of x and y alone."""
    system = System((X, Y, Z), (X, Y / 2, 5 * X))
    assert growth(system, (), [0.0, 0.0, 0.0], 2.0) is None


def test_a_motion_that_ends_early_has_none() -> None:
    system = System((X, Y), (X**2, Y**2))
    assert growth(system, (), [1.0, 1.0], 2.0) is None


@pytest.mark.parametrize(("k", "grows"), [(0.05, False), (-0.05, True)])
def test_a_transient_is_no_growth(k: float, grows: bool) -> None:
    """Two weakly damped pendulums, x'' = -k x - 0.1 x': a change of the speed by 1 is one of the angle by up to 4."""
    u, v = sp.symbols("u v", real=True)
    system = System((X, Y, u, v), (u, v, -K * X - u / 10, -K * Y - v / 10), (K,))
    compiled_system = compile_system(system, 1e-10)
    parts = np.array([0, 2]), np.array([1, 3])
    found = transverse_growth(compiled_system, np.array([k]), np.zeros(4), (0.0, 8.0), parts, repeats=True)
    assert found is not None and (found.logarithm > 0) == grows
    rate = -0.05 if k > 0 else -0.05 + np.sqrt(0.05**2 + 0.05)
    assert found.rate == pytest.approx(rate, abs=1e-5)
