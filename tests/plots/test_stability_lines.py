"""Lines by stability, of several configurations, and marks at speeds: where they begin and end, and how they are named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from wucht.plots import sheet
from wucht.plots.page import PRINT, page_context
from wucht.plots.stability_lines import (
    OVERLAPPING,
    draw_by_stability,
    draw_configurations,
    extend_both_ways,
    smooth_curve,
)
from wucht.plots.style import COLOURS, GREY, mark_speeds


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


def test_a_smooth_curve_goes_through_its_points_and_not_below_the_stretch() -> None:
    points = np.array([[0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 1.0, 4.0, 4.0]])
    x, y = smooth_curve(points, (4.0, 4.0), 1, 4)
    assert (x[::8].tolist(), y[::8].tolist()) == ([1.0, 2.0, 3.0, 4.0], pytest.approx([0.0, 1.0, 4.0, 4.0]))
    assert y.min() >= 0.0


def test_few_points_are_joined_by_straight_lines() -> None:
    points = np.array([[0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0]])
    assert smooth_curve(points, (2.0, 1.0), 0, 3)[0].tolist() == [0.0, 1.0, 1.0, 2.0]


SPEED = np.array([1.0, 2.0, 3.0, 4.0])


def drawn(names: list[str], stable: list[list[int]], overlapping: list[int] | None = None) -> list[tuple[Any, ...]]:
    """Of each line: its name, colour, dashes, and the points (speed, value) on it; configuration k is at 10 k + speed."""
    result = xr.Dataset(
        {"stable": (("configuration", "speed"), stable), "overlapping": ("configuration", overlapping or [0] * len(names))},
        coords={"speed": SPEED, "configuration_name": ("configuration", names)},
    )
    axis = Figure().subplots()
    draw_configurations(axis, result, 10.0 * np.arange(len(names))[:, None] + SPEED)
    lines = list[tuple[Any, ...]]()
    for line in axis.get_lines():
        x, y = (np.asarray(v, float) for v in line.get_data())
        name = str(line.get_label())
        lines.append(("" if name.startswith("_") else name, line.get_color(), line.get_linestyle(), y[np.isfinite(y)].tolist()))
        assert len(x) == 0 or (x == SPEED).all()
    return lines


def test_a_configuration_is_solid_where_stable_and_dashed_from_its_last_stable_point_on() -> None:
    first, second, third, legend = drawn(["apart", "together"], [[0, 0, 0, 0], [1, 1, 0, 0]])
    assert first == ("together", COLOURS[0], "-", [11.0, 12.0]), "what is stable somewhere has the first colour"
    assert second == ("", COLOURS[0], "--", [12.0, 13.0, 14.0])
    assert third == ("apart", COLOURS[3], "--", [1.0, 2.0, 3.0, 4.0])
    assert legend[0] == "not stable" and legend[2:] == ("--", [])


def test_pieces_of_one_name_have_one_colour_and_one_entry() -> None:
    lines = drawn(["in", "out", "in"], [[1] * 4, [1] * 4, [1] * 4])
    assert [(name, colour) for name, colour, *_ in lines] == [("in", COLOURS[0]), ("", COLOURS[0]), ("out", COLOURS[3])]
    assert [points[0] for *_, points in lines] == [1.0, 21.0, 11.0]


def test_overlapping_bodies_are_dotted_however_stable() -> None:
    lines = drawn(["in", "out"], [[1, 1, 1, 1], [1, 1, 1, 1]], [1, 0])
    assert lines == [("out", COLOURS[0], "-", [11.0, 12.0, 13.0, 14.0]), (OVERLAPPING, GREY, ":", [1.0, 2.0, 3.0, 4.0])]


def marked(speeds: list[float], frequencies: list[float], free: float) -> list[list[tuple[float, str]]]:
    """Of two panels: where speeds are marked, and their names."""
    with page_context(PRINT):
        _, axes = sheet.new_figure(2, "title")
        attributes = {"units": "rad/s", "long_name": "speed"}
        result = xr.Dataset({"natural_frequency": ("mode", frequencies)}, coords={"speed": ("speed", speeds, attributes)})
        mark_speeds(axes, result, ("natural frequency", "natural frequencies"), (free, "no load"), -1)
    assert axes[0].get_xlim() == (speeds[0], speeds[-1]) and axes[-1].get_xlabel() == "speed (rad/s)"
    assert [len(axis.child_axes) for axis in axes] == [1, 0], "revolutions per minute above the first panel"
    return [
        [(float(np.asarray(x.get_xdata())[0]), str(x.get_label()).replace("_child", "")) for x in axis.get_lines()]
        for axis in axes
    ]


def names(lines: list[tuple[float, str]]) -> list[tuple[float, str]]:
    return [(at, "" if name[:1] in "_0123456789" else name) for at, name in lines]


def test_speeds_in_the_range_are_marked_in_both_senses_and_named_in_one_panel() -> None:
    above, below = marked([-20.0, 0.0, 50.0], [60.0, 15.0, 30.0], 40.0)
    expected = [(-15.0, "natural frequencies"), (15.0, ""), (30.0, ""), (40.0, "no load")]
    assert names(below) == expected and names(above) == [(at, "") for at, _ in expected]
    assert names(marked([10.0, 20.0], [15.0], 25.0)[1]) == [(15.0, "natural frequency")]
    assert names(marked([10.0, 20.0], [15.0, 15.0 + 1e-12], float("nan"))[1]) == [(15.0, "natural frequency")]
    assert names(marked([10.0, 20.0], [10.0, 20.0], 20.0)[1])[-1] == (20.0, "no load"), "the ends are in the range"


def test_more_configurations_than_colours_are_others() -> None:
    lines = drawn(list("abcdef"), [[1] * 4] * 6)
    assert [name for name, *_ in lines] == ["a", "b", "c", "d", "others", ""]
    assert [colour for _, colour, *_ in lines[4:]] == [GREY, GREY]
