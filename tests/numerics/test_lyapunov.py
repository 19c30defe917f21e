"""Largest Lyapunov exponents: known exactly for linear equations, from the literature for chaotic ones."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.lyapunov import exponent_from_blocks, largest_lyapunov_exponent
from wucht.piecewise import PiecewiseCubic, step
from wucht.system import System

x, y, z, a = sp.symbols("x y z a", real=True)


def test_of_a_linear_system_it_is_the_largest_real_part() -> None:
    system = System((x, y, z), (a * x + y, a * y, -3 * z), (a,))
    exponent, times, states = largest_lyapunov_exponent(system, (-0.25,), np.array([1.0, 1.0, 1.0]), 400.0)
    assert exponent.value == pytest.approx(-0.25, abs=0.01)  # a double eigenvalue: the change grows as t exp(-t/4)
    assert (times[-1] - times[0], states.shape[0]) == (pytest.approx(400.0), 3)


def test_of_lorenz_equations_its_interval_holds_the_published_value() -> None:
    """J. C. Sprott, "Chaos and Time-Series Analysis", Oxford 2003, appendix A: 0.9056 at sigma = 10, rho = 28, beta = 8/3.

    Which motion is followed is decided by rounding, differently by each engine: the width of its interval scatters about 0.035
    by 0.008 (30 starts). The mean of four is below 0.05 but for one in ten thousand, and at least three hold the value.
    """
    system = System((x, y, z), (10 * (y - x), x * (28 - z) - y, x * y - sp.Rational(8, 3) * z))
    starts = [np.array([1.0 + k, 1.0, 20.0]) for k in range(4)]
    exponents = [largest_lyapunov_exponent(system, (), start, 1000.0)[0] for start in starts]
    assert sum(e.low < 0.9056 < e.high for e in exponents) >= 3
    assert np.mean([e.high - e.low for e in exponents]) < 0.05


def test_the_growth_swings_with_the_exponent_over_the_time_and_not_beyond_on_a_torus() -> None:
    """exp(a t): its logarithm's means over 20 blocks differ by 19/20 a T; of an angle beside a limit cycle by less than 1."""
    growing, _, _ = largest_lyapunov_exponent(System((x,), (a * x,), (a,)), (0.02,), np.array([0.0]), 1000.0)
    assert growing.swing == pytest.approx(0.02 * 1000 * 19 / 20, rel=1e-6)
    cycle = System(
        (x, y, z), (x - 2 * y - x * (x**2 + y**2), 2 * x + y - y * (x**2 + y**2), sp.Integer(1)), (), angles=frozenset({z})
    )
    turning, _, _ = largest_lyapunov_exponent(cycle, (), np.array([1.0, 0.0, 0.0]), 1000.0)
    assert turning.swing < 1


def test_the_rate_of_growth_of_a_chaotic_motion_that_ends_is_not_steady() -> None:
    """Lorenz' equations with r from 28: where it falls to 10 in the time of the record, the motion ends at rest in between."""
    r = sp.Symbol("r", real=True)
    system = System((x, y, z, r), (10 * (y - x), x * (r - z) - y, x * y - sp.Rational(8, 3) * z, -a), (a,))
    start = np.array([1.0, 1.0, 20.0, 28.0])
    ends, goes_on = (largest_lyapunov_exponent(system, (fall,), start, 500.0)[0] for fall in (18 / 550, 0.0))
    assert (ends.is_steady, goes_on.is_steady) == (False, True)


def test_its_interval_is_that_of_student() -> None:
    exponent = exponent_from_blocks(np.array([1.0, 2.0, 3.0]), 3.0)
    assert (exponent.value, exponent.high - exponent.value) == (2.0, pytest.approx(4.302653 / np.sqrt(3), rel=1e-6))


def test_equations_that_jump_have_none() -> None:
    system = System((x, y), (y, -x - PiecewiseCubic(y, step("sign", 0.0, -1.0, 1.0))))
    with pytest.raises(WuchtError, match="the equations jump"):
        largest_lyapunov_exponent(system, (), np.array([1.0, 0.0]), 10.0)
