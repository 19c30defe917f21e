"""Lines by stability: where they begin and end, and that the two kinds meet."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from wucht.plots.stability_lines import draw_by_stability, meeting, smooth_curve, stretches


@pytest.mark.parametrize(
    ("kinds", "expected"), [([1, 1, 0, 0, 2], [(0, 2), (2, 4), (4, 5)]), ([3], [(0, 1)]), ([], []), ([1, 1], [(0, 2)])]
)
def test_runs_of_equal_values(kinds: list[int], expected: list[tuple[int, int]]) -> None:
    assert stretches(np.array(kinds)) == expected


def test_a_dashed_line_begins_where_the_solid_one_ends() -> None:
    axis = Figure().add_subplot()
    x, stable = np.arange(6.0), np.array([True, True, False, False, True, True])
    assert meeting(~stable).tolist() == [False, False, True, True, True, False]
    draw_by_stability(axis, x, 2 * x, stable, "load", color="black")
    solid, dashed = axis.get_lines()
    assert (solid.get_label(), dashed.get_label(), dashed.get_linestyle()) == ("load", "load, unstable", "--")
    at = [np.flatnonzero(np.isfinite(np.asarray(line.get_ydata(), float))).tolist() for line in (solid, dashed)]
    assert at == [[0, 1, 4, 5], [2, 3, 4]]


def test_what_is_stable_throughout_has_one_line() -> None:
    axis = Figure().add_subplot()
    draw_by_stability(axis, np.arange(3.0), np.arange(3.0), np.ones(3, bool), "load")
    assert len(axis.get_lines()) == 1


def test_a_smooth_curve_goes_through_its_points_and_not_below_the_stretch() -> None:
    points = np.array([[0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 1.0, 4.0, 4.0]])
    x, y = smooth_curve(points, (4.0, 4.0), 1, 4)
    assert (x[::8].tolist(), y[::8].tolist()) == ([1.0, 2.0, 3.0, 4.0], pytest.approx([0.0, 1.0, 4.0, 4.0]))
    assert y.min() >= 0.0


def test_few_points_are_joined_by_straight_lines() -> None:
    points = np.array([[0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0]])
    assert smooth_curve(points, (2.0, 1.0), 0, 3)[0].tolist() == [0.0, 1.0, 1.0, 2.0]
