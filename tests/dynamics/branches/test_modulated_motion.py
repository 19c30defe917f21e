"""Where stable states are lost, and rows of motions that end at a saddle connection."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from known_connections import LEAF
from wucht.dynamics.branches.first_orbits import orbit_near
from wucht.dynamics.branches.modulated_motion import (
    ModulatedMotion,
    lost_states,
    nearest_fold,
)
from wucht.dynamics.branches.orbit_endings import orbit_beyond_loss
from wucht.dynamics.branches.second_parameter import SecondParameter
from wucht.dynamics.branches.state_rows import OrbitRow, RowCase, connection_curve, transverse_exponent
from wucht.dynamics.branches.steady_states import SystemEquilibria
from wucht.errors import RunError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION
from wucht.system import System

X, Y, Z, P, Q, THETA = sp.symbols("x y z p q theta", real=True)


def motion_of(
    system: System, values: dict[str, float], path: str, ranges: Any, bounds: tuple[float, float] = (-1.0, 1.0), **start: float
) -> ModulatedMotion:
    equations = wucht.UserSystem(system, values)
    states = SystemEquilibria.of(equations, path, (-1.0, 1.0), ranges)
    return ModulatedMotion.of(equations, path, bounds, states, ranges=ranges, start=start)


# x' = p + q x - x^3 folds at x = +-sqrt(q/3), p = -+2 (q/3)^(3/2); y decays fourfold as fast as x at most.
CUBIC = System((X, Y), (P + Q * X - X**3, -8 * Y), (P, Q))
FOLD = 2 / 3**1.5


@cache
def cubic() -> ModulatedMotion:
    return motion_of(CUBIC, {"p": 0.0, "q": 1.0}, "p", {"x": (-2.0, 2.0), "y": (-1.0, 1.0)})


@pytest.mark.parametrize(("sign", "way"), [(1, 1), (-1, -1)])
def test_a_stable_state_that_begins_to_vibrate_is_lost(sign: int, way: int) -> None:
    """At p = 0, with +-2 i; beyond it a run comes to the circle r^2 = p, which turns at 2 rad a unit of time."""
    growth = sign * P - X**2 - Y**2
    system = System((X, Y), (growth * X - 2 * Y, 2 * X + growth * Y), (P,))
    motion = motion_of(system, {"p": 0.0}, "p", {"x": (-2.0, 2.0), "y": (-1.0, 1.0)})
    ((lost, found_way),) = lost_states(motion.steady_branches())
    assert (lost.kind, lost.parameter, found_way) == ("hopf", pytest.approx(0.0, abs=1e-9), way)
    orbit = orbit_beyond_loss(motion, lost, way, [], lambda: None)
    assert orbit is not None and orbit.period == pytest.approx(math.pi, rel=1e-6)
    assert np.hypot(*orbit.states.T) == pytest.approx(np.full(len(orbit.states), abs(orbit.value) ** 0.5), rel=1e-4)


def test_the_nearest_fold_of_a_branch() -> None:
    """From the saddle between both: at p = 0.1 the upper one, at -0.1 the lower."""
    upper = nearest_fold(cubic(), np.array([-0.1, 0.0]), 0.1)
    assert upper.parameter == pytest.approx(FOLD) and upper.x[0] == pytest.approx(-(3**-0.5), abs=1e-6)
    lower = nearest_fold(cubic(), np.array([0.1, 0.0]), -0.1)
    assert lower.parameter == pytest.approx(-FOLD) and lower.x[0] == pytest.approx(3**-0.5, abs=1e-6)
    assert nearest_fold(cubic(), np.array([1.2, 0.0]), 0.5).parameter == pytest.approx(FOLD)
    with pytest.raises(RunError, match="the saddle has no fold over p"):
        nearest_fold(cubic().with_values({"q": -1.0}), np.array([0.0, 0.0]), 0.0)


# The leaf: its stable orbits within, at mu < 0, become a saddle connection at mu = 0, for each a.
SPACE = {"x": (-0.6, 1.4), "y": (-1.0, 1.0)}
MU = (-0.05, 0.05)


@cache
def leaf_row() -> tuple[ModulatedMotion, OrbitRow]:
    motion = motion_of(LEAF, {"c": 0.0, "mu": -0.02, "a": -1.0, "b": 0.0}, "mu", SPACE, MU, x=0.6, y=0.2)
    run = orbit_near(motion.subject, -0.02, np.array([0.6, 0.2]), lambda: None, lambda _: 20.0)
    assert run.orbit is not None
    row = RowCase(motion, "a", -1.0, lambda: None).row_through(replace(run.orbit, longest=5 * run.orbit.period))
    assert isinstance(row, OrbitRow)
    return motion, row


def test_a_row_that_ends_at_a_saddle_connection() -> None:
    low, high = leaf_row()[1].sides
    assert (low.kind, low.value) == ("range", -0.05)
    assert (high.kind, high.value) == (SADDLE_CONNECTION, pytest.approx(0.0, abs=1e-9))
    np.testing.assert_allclose(high.equilibrium, [0.0, 0.0], atol=1e-9)
    row = leaf_row()[1]
    assert row.special == () and row.stable.all() and row.middle.value == pytest.approx(-0.025, abs=1e-6)
    assert row.whole.longest == 3 * row.middle.period
    assert (np.diff(row.values) >= 0).all() and row.values[0] == pytest.approx(-0.05)


def test_the_curve_of_saddle_connections_through_it() -> None:
    """mu = 0, for each a."""
    motion, row = leaf_row()
    curve = connection_curve(motion, SecondParameter("a", (-1.4, -0.6), -1.0), row, row.sides[1])
    assert curve.kind == SADDLE_CONNECTION
    np.testing.assert_allclose(curve.x, 0.0, atol=1e-9)
    assert sorted(curve.y[[0, -1]]) == pytest.approx([-1.4, -0.6]) and len(set(np.sign(np.diff(curve.y)))) == 1
    nowhere = replace(row.sides[1], equilibrium=np.array([2 / 3, 0.0]))
    with pytest.raises(RunError):
        connection_curve(motion, SecondParameter("a", (-1.4, -0.6), -1.0), row, nowhere)


def test_the_exponent_of_the_direction_that_leads_out_of_a_section() -> None:
    """In x' = y, y' = -x, z' = (p + x^2) z around r = 2: the integral of p + x^2 over a period, 2 pi (p + 2)."""
    system = System((X, Y, Z), (-Y, X, (P + X**2) * Z), (P,))
    whole: Any = SimpleNamespace(system=system, path="p", fixed_values=lambda *_: {})
    e = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    motion: Any = SimpleNamespace(whole=whole, subject=SimpleNamespace(embedding=e))
    angle = np.linspace(0, 2 * np.pi, 401)
    cycle: Any = SimpleNamespace(
        states=2 * np.array([np.cos(angle), np.sin(angle)]), parameter=-0.5,
        integral=lambda values: float(((values[1:] + values[:-1]) / 2 * np.diff(angle)).sum()),
    )  # fmt: skip
    assert transverse_exponent(motion)(cycle) == pytest.approx(2 * np.pi * 1.5, rel=1e-4)
