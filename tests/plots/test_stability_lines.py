"""Lines by stability: where they begin and end, and that the two kinds meet."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from wucht.plots.stability_lines import draw_by_stability, meeting, stretches


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
