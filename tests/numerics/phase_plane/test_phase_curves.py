"""Where curves go, and closed curves with known periods and multipliers."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipk

from wucht.numerics.phase_plane.fixed_points import fixed_points
from wucht.numerics.phase_plane.phase_curves import (
    CLOSED_CURVE,
    FIXED_POINT,
    LENGTH,
    OUTSIDE_WINDOW,
    Portrait,
)
from wucht.numerics.phase_plane.plane import TURN, Plane
from wucht.system import System

X, Y, MU = sp.symbols("x y mu", real=True)
HOPF = System((X, Y), (-Y + X * (MU - X**2 - Y**2), X + Y * (MU - X**2 - Y**2)), (MU,))  # 002 (2.37)-(2.38)
WINDING = System((X, Y), (X * (1 - X**2), MU - sp.sin(Y)), (MU,), angles=frozenset({Y}))  # 002 (2.49)-(2.50)
PENDULUM = System((X, Y), (Y, -sp.sin(X)), angles=frozenset({X}))


def portrait(system: System, low: tuple[float, float], high: tuple[float, float], **values: float) -> Portrait:
    plane = Plane(system, {k: v for k, v in values.items() if k == "mu"}, np.array(low), np.array(high))
    return Portrait(plane, fixed_points(plane).points, most_length=values.get("length", 40.0))


@pytest.mark.parametrize("start", [(0.05, 0.0), (1.4, 0.3)])
def test_a_limit_cycle_from_inside_and_outside(start: tuple[float, float]) -> None:
    """Radius sqrt(mu), period 2 pi, multiplier exp(-2 mu 2 pi); backwards the focus, or out of the window."""
    hopf = portrait(HOPF, (-1.5, -1.5), (1.5, 1.5), mu=0.5)
    curve = hopf.follow(np.array(start), True)
    assert (curve.end, curve.index, len(hopf.closed_curves)) == (CLOSED_CURVE, 0, 1)
    cycle = hopf.closed_curves[0]
    assert (cycle.kind, cycle.period) == ("stable", pytest.approx(TURN, rel=1e-9))
    assert cycle.multiplier == pytest.approx(math.exp(-TURN), rel=1e-6)
    assert np.hypot(*cycle.states) == pytest.approx(math.sqrt(0.5), rel=1e-9)
    back = hopf.follow(np.array(start), False)
    assert back.end == (FIXED_POINT if np.hypot(*start) < 0.7 else OUTSIDE_WINDOW)
    assert -20 < back.time[-1] < 0  # from 0.05 to the part of the focus that nothing leaves: ln(5)/mu or so


def test_a_winding_curve() -> None:
    """Period 2 pi/sqrt(mu^2 - 1), however slow where the fixed points were; multiplier exp(-2 T)."""
    for mu in (1.2, 1.0001):
        winding = portrait(WINDING, (0.2, 0.0), (1.8, TURN), mu=mu)
        assert winding.points == ()
        assert winding.follow(np.array([0.5, 1.0]), True).end == CLOSED_CURVE
        period = TURN / math.sqrt(mu**2 - 1)
        assert winding.closed_curves[0].period == pytest.approx(period, rel=1e-7)
        assert winding.closed_curves[0].turns == pytest.approx([0, TURN])
        assert winding.closed_curves[0].multiplier == pytest.approx(math.exp(-2 * period), abs=1e-8)


def test_curves_of_a_family_and_their_periods() -> None:
    """The pendulum released at rest from an angle: 4 K(sin^2(angle/2)); the closed curve beside is of its own energy."""
    swing = portrait(PENDULUM, (0.0, -3.0), (TURN, 3.0))
    for angle in (0.5, 2.0):
        curve = swing.follow(np.array([angle, 0.0]), True)
        assert curve.end == CLOSED_CURVE
        closed = swing.closed_curves[curve.index]
        theta, speed = closed.states
        squares = (speed**2 / 2 - np.cos(theta) + 1) / 2
        assert squares == pytest.approx(math.sin(angle / 2) ** 2, abs=1e-4)
        assert (closed.kind, closed.period) == ("one of a family", pytest.approx(4 * ellipk(squares[0]), rel=1e-8))
    assert len(swing.closed_curves) == 2


def test_a_curve_that_goes_nowhere_is_given_up() -> None:
    """A focus that attracts as slowly as r' = -r/1000."""
    slow = portrait(HOPF, (-1.0, -1.0), (1.0, 1.0), mu=-0.001, length=5.0)
    curve = slow.follow(np.array([0.05, 0.0]), True)
    assert (curve.end, slow.closed_curves) == (LENGTH, [])
    assert 5 <= curve.length < 5.3


def test_a_fold_is_approached_and_called_so() -> None:
    fold = portrait(System((X, Y), (-(X**2), -Y)), (-1.0, -1.0), (1.0, 1.0))
    curve = fold.follow(np.array([0.5, 0.5]), True)
    assert (curve.end, fold.points[curve.index].kind) == (FIXED_POINT, "degenerate")
