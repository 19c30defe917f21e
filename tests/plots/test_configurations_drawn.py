"""Curves of several configurations, and marks at speeds: which line is drawn where, how, and with which name."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from wucht.plots import scales, sheet
from wucht.plots.cam_drawings import frame_cam, order_scale
from wucht.plots.page import PRINT, page_context
from wucht.plots.stability_lines import OVERLAPPING, draw_configurations
from wucht.plots.style import COLOURS, GREY, MOST_LOOKS, line_style, mark_levels, mark_speeds, shades

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


def test_more_configurations_than_colours_are_others() -> None:
    lines = drawn(list("abcdef"), [[1] * 4] * 6)
    assert [name for name, *_ in lines] == ["a", "b", "c", "d", "others", ""]
    assert [colour for _, colour, *_ in lines[4:]] == [GREY, GREY]


def test_overlapping_bodies_are_dotted_however_stable() -> None:
    lines = drawn(["in", "out"], [[1, 1, 1, 1], [1, 1, 1, 1]], [1, 0])
    assert lines == [("out", COLOURS[0], "-", [11.0, 12.0, 13.0, 14.0]), (OVERLAPPING, GREY, ":", [1.0, 2.0, 3.0, 4.0])]


def test_looks_differ_as_far_as_is_said_and_neighbours_in_colour_and_dashes() -> None:
    looks = [line_style(k) for k in range(MOST_LOOKS)]
    assert len({(x["color"], x["linestyle"], x.get("marker")) for x in looks}) == MOST_LOOKS
    for one, next_ in pairwise(looks):
        assert one["color"] != next_["color"] and one["linestyle"] != next_["linestyle"]
    assert ["marker" in x for x in looks].index(True) == len(COLOURS)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_shades_go_from_dark_to_light(count: int) -> None:
    from matplotlib.colors import to_rgb

    tones = [0.2126 * r + 0.7152 * g + 0.0722 * b for r, g, b in map(to_rgb, shades(count))]
    assert len(tones) == count and tones == sorted(tones) and tones[0] < 0.15 and len(set(tones)) == count
    assert count == 1 or 0.5 < tones[-1] < 0.9


def test_only_the_first_level_has_the_name() -> None:
    axis = Figure().subplots()
    mark_levels(axis, [3.0, 5.0], "critical")
    assert [(np.asarray(x.get_ydata()).tolist(), str(x.get_label())[:8]) for x in axis.get_lines()] == [
        ([3.0, 3.0], "critical"),
        ([5.0, 5.0], str(axis.get_lines()[1].get_label())[:8]),
    ]
    assert str(axis.get_lines()[1].get_label()).startswith("_")


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


def test_scales_of_cams_orders_and_turns() -> None:
    axis = Figure().subplots()
    order_scale(axis, np.array([1, 2, 9]))
    assert axis.get_xlim() == (0.3, 9.7) and axis.get_xlabel() == "order"
    scales.turn_scale(axis)
    assert axis.get_xlim() == (0, 360) and list(axis.get_xticks()) == [0, 60, 120, 180, 240, 300, 360]
    frame_cam(axis)
    assert (axis.get_aspect(), axis.get_xlabel(), axis.get_ylabel()) == (1.0, "x (mm), cam at 0°", "y (mm)")


@pytest.mark.parametrize(("of", "sides"), [("y", ("speed (rad/s)", "")), ("x", ("", "speed (rad/s)"))])
def test_a_scale_of_speeds_has_its_name_on_its_side(of: str, sides: tuple[str, str]) -> None:
    with page_context(PRINT):
        _, (axis,) = sheet.new_figure(1, "title")
        result = xr.Dataset({"speed": ("n", [1.0], {"units": "rad/s", "long_name": "speed"})})
        scales.name_speeds(axis, result, of=of)
    assert (axis.get_ylabel(), axis.get_xlabel()) == sides
    (second,) = axis.child_axes
    assert (second.get_ylabel(), second.get_xlabel()) == (("speed (rpm)", "") if of == "y" else ("", "speed (rpm)"))


def test_decades_are_written_without_typesetting() -> None:
    axis = Figure().subplots()
    axis.set_yscale("log")
    scales.plain_decades(axis.yaxis, alone=True)
    write = axis.yaxis.get_major_formatter()
    assert [write(x, 0) for x in (1e-9, 1e-12, 1.0, 1e3)] == ["10⁻⁹", "10⁻¹²", "10⁰", "10³"]
    assert axis.yaxis.get_minor_formatter()(3.0, 0) == ""
