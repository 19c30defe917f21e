"""Lines by stability: where they begin and end, and that the two kinds meet."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from wucht.plots.stability_lines import (
    Symbol,
    draw_by_stability,
    draw_classes,
    draw_kinds,
    draw_region,
    equal_stretches,
    extend_both_ways,
    field,
    kind_entries,
    smooth_curve,
)

SYMBOLS: dict[str, Symbol] = {"": ("^", "white", ""), "hopf": ("D", "white", "Hopf point"), "branch-point": ("s", "black", "")}
KINDS = np.array(["hopf", "", "branch-point", "hopf", "torus"])


def test_classes_without_points_are_neither_drawn_nor_named() -> None:
    axis = Figure().add_subplot()
    x = np.arange(3.0)
    draw_classes(axis, x, x, [(x > 0, "o", "white", "open"), (x > 9, "s", "black", "none")], linestyle="")
    (line,) = axis.get_lines()
    assert (line.get_label(), np.asarray(line.get_xdata()).tolist()) == ("open", [1.0, 2.0])


def test_special_points_and_their_legend_have_the_same_symbols() -> None:
    axis = Figure().add_subplot()
    draw_kinds(axis, np.arange(5.0), np.arange(5.0), KINDS, SYMBOLS)
    handles = kind_entries(KINDS, SYMBOLS)
    assert [h.get_label() for h in handles] == ["Hopf point", "branch point", "torus"]
    assert [line.get_marker() for line in axis.get_lines()] == [h.get_marker() for h in handles] == ["D", "s", "^"]
    assert [len(np.atleast_1d(line.get_xdata())) for line in axis.get_lines()] == [2, 1, 1]


def test_a_region_has_its_hatch_in_the_map_and_in_the_legend() -> None:
    axis = Figure().add_subplot()
    inside = np.array([[True, True], [False, False]])
    draw_region(axis, np.arange(2.0), np.arange(2.0), inside, "//", "white", colors=["#8FB8D6"])
    (drawn,) = axis.collections
    assert drawn.hatches == ["//"]  # type: ignore[attr-defined]
    handle = field("stable", "#8FB8D6", "//")
    assert (handle.get_label(), handle.get_hatch()) == ("stable", "//")
    assert handle.get_facecolor()[:3] == to_rgb("#8FB8D6")


@pytest.mark.parametrize(
    ("kinds", "expected"), [([1, 1, 0, 0, 2], [(0, 2), (2, 4), (4, 5)]), ([3], [(0, 1)]), ([], []), ([1, 1], [(0, 2)])]
)
def test_runs_of_equal_values(kinds: list[int], expected: list[tuple[int, int]]) -> None:
    assert equal_stretches(np.array(kinds)) == expected


def test_a_dashed_line_begins_where_the_solid_one_ends() -> None:
    axis = Figure().add_subplot()
    x, stable = np.arange(6.0), np.array([True, True, False, False, True, True])
    assert extend_both_ways(np.array([True, False, False])).tolist() == [True, True, False]
    assert extend_both_ways(np.zeros(0, bool)).tolist() == []
    assert extend_both_ways(~stable).tolist() == [False, True, True, True, True, False]
    draw_by_stability(axis, x, 2 * x, stable, "load", color="black")
    solid, dashed = axis.get_lines()
    assert (solid.get_label(), dashed.get_label(), dashed.get_linestyle()) == (
        "load",
        "no stable working point",
        "--",
    )
    at = [np.flatnonzero(np.isfinite(np.asarray(line.get_ydata(), float))).tolist() for line in (solid, dashed)]
    assert at == [[0, 1, 4, 5], [1, 2, 3, 4]]


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
