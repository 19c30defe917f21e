"""Curves of the plane of endings from a connection of two saddle-nodes in closed form."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import wucht
from known_connections import BETWEEN, GOMPERTZ
from wucht.dynamics.branches import ending_curves
from wucht.dynamics.branches.ending_curves import BOTH_VANISH, TO_SADDLE
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.plane_regions import DOUBLE
from wucht.dynamics.branches.steady_states import SystemEquilibria
from wucht.numerics.periodic.connection import Connection

SPACE = {"x": (-1.0, 2.0), "y": (-1.0, 1.0)}
EQUATIONS = wucht.UserSystem(BETWEEN, {"p": 0.0, "mu": 0.0, "r": 0.0})
PATHS, PLANE_RANGES = ("p", "mu", "r"), ((-0.2, 0.2), (-0.3, 0.3), (-0.1, 0.1))


@cache
def case() -> EndingMapCase:
    states = SystemEquilibria.of(EQUATIONS, "p", PLANE_RANGES[0], SPACE)
    motion = ModulatedMotion.of(EQUATIONS, "p", PLANE_RANGES[0], states, ranges=SPACE)
    return EndingMapCase(PATHS, PLANE_RANGES, motion, 2, states.labels)


@cache
def double() -> Connection:
    """From an orbit that waits at the origin, where p = 1e-3, and goes on to (1, 0), its only saddle-node."""
    p, mu, r = 1e-3, 2e-3, -1e-3

    def rates(_: float, u: np.ndarray) -> tuple[float, float]:
        x, y = u
        return p + x**2 * (1 - x), -(1 - x) * y + x * y**2 + r * x + mu * x * (1 - x)

    run = solve_ivp(rates, (0, 104), (-0.9, 0.0), rtol=1e-10, atol=1e-12, dense_output=True)
    time = float(np.interp(0.99, run.y[0], run.t))
    waits: Any = SimpleNamespace(
        states_at=lambda tau: run.sol(tau * time),
        time=time,
        parameter_values=np.array([p, mu, r]),
        equilibria=np.array([[1.0, 0.0]]),
    )
    one = ending_curves._connections(case(), time, (True, False))
    found = ending_curves._double_connection(case(), one, waits)
    assert found is not None
    return found


def test_the_connection_of_two_saddle_nodes_from_an_orbit_that_waits() -> None:
    """All parameters zero. In the longer time the error, as 1/time, is less than 1e-7 of the ranges."""
    found = double()
    np.testing.assert_allclose(found.parameter_values[:3], 0.0, atol=1e-8)
    np.testing.assert_allclose(found.equilibria, [[0.0, 0.0], [1.0, 0.0]], atol=1e-8)
    np.testing.assert_allclose(found.eigenvalues, [[0.0, -1.0], [0.0, -1.0]], atol=1e-8)
    assert 100.0 < found.time < 400.0  # longer, once


def test_the_curves_that_begin_there() -> None:
    """Both pairs vanish where p = r = 0; the saddle is at y = sqrt(-r), and reached where mu = y/(e E1(1)) + O(y^2)."""
    lost, watched = list[str](), list[str]()
    point, curves = ending_curves._from_double(case(), double(), lost, watched.append)
    assert (point.kind, lost) == (DOUBLE, [])
    assert (point.x, point.y, point.value) == pytest.approx((0.0, 0.0, 0.0), abs=1e-8)
    assert [c.kind for c in curves] == [TO_SADDLE, BOTH_VANISH, BOTH_VANISH]
    saddle, *both = curves
    np.testing.assert_allclose([saddle.x[0], saddle.y[0]], 0.0, atol=1e-8)
    assert (np.diff(saddle.x) > 0).all() and (np.diff(saddle.y) < 0).all()
    near = (saddle.y < -1e-9) & (saddle.y > -1e-3)
    y = np.sqrt(-saddle.y[near])
    np.testing.assert_allclose(saddle.x[near] * GOMPERTZ / y, 1.0, atol=0.02)
    assert near.any() and pytest.approx(0.0, abs=1e-12) == min(0.3 - saddle.x[-1], 0.1 + saddle.y[-1])
    for c in both:
        np.testing.assert_allclose(c.y, 0.0, atol=1e-8)
        assert c.x[0] == pytest.approx(0.0, abs=1e-8)
    assert sorted(c.x[-1] for c in both) == pytest.approx([-0.3, 0.3])
    for c in curves:
        np.testing.assert_allclose(c.value, 0.0, atol=1e-8)
    assert len(watched) == 2


def test_curves_are_followed_beyond_the_plane_on_the_same_side_of_zero() -> None:
    """Half its width; down to a tenth of a lower end that is positive, at least."""
    plane = replace(case(), ranges=((0.0, 1.0), (1.0, 3.0), (4.0, 5.0)))
    assert plane.wider_ranges == ((0.0, 1.0), (0.1, 4.0), (3.5, 5.5))
    assert plane.contains(np.array([0.5, 1.0, 2.0, 2.0]), np.array([4.5, 5.0, 3.9, 5.1])).tolist() == [
        False,
        True,
        False,
        False,
    ]
