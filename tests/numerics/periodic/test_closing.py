"""Orbits at given parameter values by collocation, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp

from wucht.errors import RunError
from wucht.numerics.periodic.closing import Closing, close_orbit
from wucht.system import TIME, System

x, v, y, a = sp.symbols("x v y a", real=True)
TURN = 2 * math.pi


def closing(reference: list[float], period: float, **more: object) -> Closing:
    n = len(reference)
    given = {"held_states": (), "free_period": False, "left_open": 0} | more
    return Closing(np.zeros(n), np.ones(n), np.array(reference, float), period, **given)  # type: ignore[arg-type]


def test_a_forced_oscillator_from_a_poor_motion() -> None:
    """x' = -a x + cos t from a constant: x = (a cos t + sin t)/(1 + a^2), seen from a time of 1."""
    system = System((x,), (-a * x + sp.cos(TIME),), (a,))
    found = close_orbit(system, np.array([0.3]), 1.0, np.full((1, 30), 0.7), closing([0.7], TURN), 25)
    t = 1.0 + TURN * found.times
    assert found.period == pytest.approx(TURN, rel=1e-14)
    np.testing.assert_allclose(found.states[0], (0.3 * np.cos(t) + np.sin(t)) / 1.09, atol=1e-10)


def test_a_free_period_and_a_held_state() -> None:
    """r' = r (1 - r^2), turning at the rate 3, from a circle of another radius at another rate."""
    r = 1 - x**2 - y**2
    system, tau = System((x, y), (r * x - 3 * y, 3 * x + r * y)), TURN * np.linspace(0, 1, 60)
    motion = np.array([0.6 * np.cos(tau), 0.6 * np.sin(tau)])
    found = close_orbit(system, np.zeros(0), 0.0, motion, closing([0.6, 0.0], 2.5, held_states=(1,), free_period=True), 25)
    assert found.period == pytest.approx(TURN / 3, rel=1e-9)
    assert found.states[:, 0] == pytest.approx([1.0, 0.0], abs=1e-9)


def test_of_a_family_the_nearest() -> None:
    """All motions of a linear oscillator are closed: none is preferred, the one that begins at the guess is found."""
    system, tau = System((x, v), (v, -x)), TURN * np.linspace(0, 1, 60)
    motion = np.array([1.2 * np.cos(tau), -1.1 * np.sin(tau)])
    found = close_orbit(system, np.zeros(0), 0.0, motion, closing([1.2, 0.0], TURN), 25)
    np.testing.assert_allclose(
        found.states, 1.2 * np.array([np.cos(TURN * found.times), -np.sin(TURN * found.times)]), atol=1e-9
    )


def test_where_there_is_none_it_is_told() -> None:
    """x'' = 1 + x^2 has no periodic motion at all."""
    system, tau = System((x, v), (v, 1 + x**2)), TURN * np.linspace(0, 1, 60)
    with pytest.raises(RunError):
        close_orbit(system, np.zeros(0), 0.0, np.array([np.cos(tau), -np.sin(tau)]), closing([1.0, 0.0], TURN), 25)
