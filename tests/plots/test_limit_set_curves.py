"""What motions of equations tend to, as it is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wucht.plots.limit_set_curves import draw_limit_set, wrapped_curve

PLAIN = np.array([False, False])


def line_of(states: np.ndarray, kind: str, turning: np.ndarray = PLAIN) -> Line2D:
    axis = Figure().add_subplot()
    draw_limit_set(axis, states, turning, kind)
    (line,) = axis.get_lines()
    return line


def circle(samples: int, turns: float) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi * turns, samples)
    return np.array([np.cos(angle), np.sin(angle)])


def test_a_motion_with_few_samples_in_an_oscillation_is_a_smooth_thin_line() -> None:
    """Ten samples a turn are interpolated: the line stays on the circle where a polygon would be a twentieth within it."""
    line = line_of(circle(1001, 100.0), "chaotic")
    x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
    assert len(x) > 5000 and line.get_linewidth() < 0.5 and line.get_linestyle() == "-"
    assert np.hypot(x, y)[80:-80] == pytest.approx(1.0, abs=0.01)


def test_of_a_long_motion_a_stretch_is_drawn() -> None:
    line = line_of(circle(40_001, 1000.0), "quasi-periodic")
    assert len(np.asarray(line.get_xdata())) == pytest.approx(150 * 80, rel=0.02)


def test_an_orbit_is_a_line_and_an_equilibrium_a_point() -> None:
    assert line_of(circle(50, 1.0), "periodic").get_linewidth() > 1
    point = line_of(np.array([[7.0], [0.5]]), "equilibrium", np.array([True, False]))
    assert (point.get_marker(), list(point.get_xdata())) == ("o", [pytest.approx(7.0 - 2 * np.pi)])


def test_a_curve_has_a_gap_where_an_angle_is_wrapped() -> None:
    curve = wrapped_curve(np.array([[3.0, 3.1, 3.2, 3.3], [0.0, 1.0, 2.0, 3.0]]), np.array([True, False]))
    assert np.isnan(curve[0]).tolist() == [False, False, True, False, False]
    assert curve[0, -1] == pytest.approx(3.3 - 2 * np.pi)
    within = wrapped_curve(np.array([[3.1, 3.2], [0.0, 1.0]]), np.array([True, False]), (0.0, 0.0))
    assert within.tolist() == [[3.1, 3.2], [0.0, 1.0]]


def test_samples_that_are_far_apart_are_dots() -> None:
    line = line_of(np.pad(circle(301, 100.0), [(0, 0), (0, 5)], constant_values=np.nan), "chaotic")
    assert line.get_linestyle() == "None" and len(np.asarray(line.get_xdata())) == 301
