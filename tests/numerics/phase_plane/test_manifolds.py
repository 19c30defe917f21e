"""Manifolds of saddles against conserved energies, known formulas and the measured order of their start."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.numerics.phase_plane.fixed_points import SADDLE, fixed_points
from wucht.numerics.phase_plane.manifolds import LocalManifold, Manifold, manifold, manifolds
from wucht.numerics.phase_plane.phase_curves import CLOSED_CURVE, FIXED_POINT, OUTSIDE_WINDOW, Portrait
from wucht.numerics.phase_plane.plane import TURN, Plane
from wucht.system import TIME, System

X, Y, MU = sp.symbols("x y mu", real=True)
PENDULUM = System((X, Y), (Y, -sp.sin(X)), angles=frozenset({X}))
FISH = System((X, Y), (Y, X - X**2))  # y^2/2 - x^2/2 + x^3/3 is constant: the loop of the saddle is y = +-x sqrt(1 - 2 x/3)
CYCLE = System((X, Y), (Y, MU * Y + X - X**2 + X * Y), (MU,))  # 002 (2.53)-(2.54)


def portrait(system: System, low: tuple[float, float], high: tuple[float, float], **values: float) -> Portrait:
    plane = Plane(system, values, np.array(low), np.array(high))
    return Portrait(plane, fixed_points(plane).points)


def each(portrait: Portrait, stable: bool) -> list[Manifold]:
    return [m for m in manifolds(portrait) if m.stable == stable]


def test_energy_is_conserved_along_the_pendulums_separatrix() -> None:
    """And it is 2 gd(t): theta = 4 atan(tanh(t/2)), from the saddle to itself a turn on."""
    swing = portrait(PENDULUM, (0.0, -3.0), (TURN, 3.0))
    found = manifolds(swing)
    assert len(found) == 4
    for m in found:
        angle, speed = m.curve.states
        assert np.abs(speed**2 / 2 - np.cos(angle) - 1).max() < 1e-9
        assert (m.curve.end, swing.points[m.curve.index].kind) == (FIXED_POINT, SADDLE)
        assert abs(angle[-1] - angle[0]) == pytest.approx(TURN, abs=1e-12)
        assert m.curve.gap < 1e-9
    forth = next(m for m in found if not m.stable and m.curve.states[1].max() > 1)
    theta = forth.curve.states[0, 1:-1] - TURN  # from -pi to pi
    t = forth.curve.time[1:-1]
    middle = np.interp(0.0, theta, t)
    assert 4 * np.arctan(np.tanh((t - middle) / 2)) == pytest.approx(theta, abs=3e-6)


@pytest.mark.parametrize("stable", [False, True])
def test_the_start_is_of_second_order_and_its_error_is_known(stable: bool) -> None:
    """Half the distance: an eighth of the error, which is that which the equations' defect says."""
    plane = Plane(FISH, {}, np.array([-2.0, -2.0]), np.array([2.0, 2.0]))
    local = LocalManifold.of(plane, np.zeros(2), stable)
    sign = -1 if stable else 1
    assert local.rate == pytest.approx(sign, abs=1e-12)

    def off(s: float) -> float:
        x, y = local.state_at(s)
        return abs(y - sign * x * math.sqrt(1 - 2 * x / 3)) / math.sqrt(2) / 4  # across the diagonal, in windows

    distances = [0.02, 0.01, 0.005]
    errors = [off(s) for s in distances]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([3, 3], abs=0.05)
    assert [local.error(s) for s in distances] == pytest.approx(errors, rel=0.15)
    assert local.error(local.start(1)) <= 1e-11


def test_a_loop_returns_to_its_saddle() -> None:
    fish = portrait(FISH, (-1.2, -1.5), (2.0, 1.5))
    for m in each(fish, False):
        if m.curve.states[0].max() < 0.1:
            assert m.curve.end == OUTSIDE_WINDOW and m.curve.states[1, -1] == pytest.approx(-1.5)
            continue
        x, y = m.curve.states
        assert np.abs(y**2 / 2 - x**2 / 2 + x**3 / 3).max() < 1e-9
        assert (m.curve.end, m.curve.index, m.curve.states[0].max()) == (FIXED_POINT, m.saddle, pytest.approx(1.5, abs=1e-5))


def test_on_both_sides_of_a_homoclinic_bifurcation() -> None:
    """002 figure 2.14: the manifold goes to the cycle below mu = -0.8645, beyond it leaves; the stable one then comes from the
    focus."""
    below, above = (portrait(CYCLE, (-1.2, -1.3), (2.0, 1.3), mu=mu) for mu in (-0.87, -0.86))
    ends = [{(m.stable, m.curve.end) for m in manifolds(p)} for p in (below, above)]
    assert (False, CLOSED_CURVE) in ends[0] and (True, FIXED_POINT) not in ends[0]
    assert (False, CLOSED_CURVE) not in ends[1] and (True, FIXED_POINT) in ends[1]
    assert [c.kind for c in below.closed_curves] == ["stable"] and above.closed_curves == []


def test_what_ends_at_the_border_ends_on_it() -> None:
    cycle = portrait(CYCLE, (-1.2, -1.3), (2.0, 1.3), mu=-0.8)
    for m in manifolds(cycle):
        if m.curve.end == OUTSIDE_WINDOW:
            x, y = m.curve.states[:, -1]
            assert min(abs(x + 1.2), abs(x - 2.0), abs(y + 1.3), abs(y - 1.3)) < 1e-12
        assert np.sign(m.curve.time[-1]) == (-1 if m.stable else 1)


def test_what_is_no_saddle_of_the_plane_is_refused() -> None:
    node = portrait(System((X, Y), (-X, -2 * Y)), (-1, -1), (1, 1))
    with rejected("no-saddle"):
        manifold(node, 0, True, 1)
    with rejected("no-saddle", "-1", "-2"):
        LocalManifold.of(node.plane, np.zeros(2), True)
    z = sp.Symbol("z", real=True)
    with rejected("two-states", "3", "x", "y", "z"):
        Plane(System((X, Y, z), (X, Y, z)), {}, np.zeros(3), np.ones(3))
    with rejected("time-dependent"):
        Plane(System((X, Y), (X, Y * TIME)), {}, np.zeros(2), np.ones(2))


def test_the_manifolds_of_both_sides_are_as_long_where_these_are_alike() -> None:
    """x' = x, y' = -y: along the axes, half a window each way, from the saddle on."""
    alike = manifolds(portrait(System((X, Y), (X, -Y)), (-1.0, -2.0), (1.0, 2.0)))
    assert [m.curve.length for m in alike] == pytest.approx([0.5] * 4, rel=2e-3)
    assert [m.curve.end for m in alike] == [OUTSIDE_WINDOW] * 4
    forth, back = (m.curve.length for m in alike if not m.stable)
    assert forth == pytest.approx(back, rel=1e-9)
