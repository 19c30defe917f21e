"""Panels, legends and scales in their places, on a page and in a column of a journal; numbers of scales."""

from __future__ import annotations

import gc
import math
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

import figure_checks
import wucht as package
from wucht.plots import arranging, sheet
from wucht.plots.arranging import arrange
from wucht.plots.page import JOURNAL, PRINT, Page, page_context
from wucht.plots.style import line_style

PAGES = pytest.mark.parametrize("page", [PRINT, JOURNAL], ids=["print", "journal"])


def drawn(page: Page, names: list[str], title: str = "title", **keys: Any) -> Figure:
    """Two panels over one abscissa; in the first as many lines as there are names."""
    with page_context(page):
        figure, axes = sheet.new_figure(2, title, **keys)
        for k, name in enumerate(names):
            axes[0].plot([0.0, 1.0], [k, 2.0 * k], label=name, **line_style(k))
        axes[1].plot([0.0, 1.0], [0.0, 1.0])
        axes[0].set_ylabel("speed (rad/s)")
        axes[1].set_ylabel("a name that is far too long for the height of one panel (mm)")
        axes[1].set_xlabel("time (s)")
        sheet.rpm_axis(axes[0], "rad/s")
        sheet.legend_beside(axes[0])
    return arrange(figure)


@PAGES
@pytest.mark.parametrize("count", [4, pytest.param(12, marks=pytest.mark.slow)])
def test_whatever_is_named_stands_on_the_page_beside_all_else(page: Page, count: int) -> None:
    names = [f"a body with a rather long name, number {k}" if k % 2 else f"b{k}" for k in range(count)]
    figure = drawn(page, names)
    figure_checks.check(figure)
    assert [t.get_text().replace("\n", " ") for t in figure.axes[0].get_legend().get_texts()] == names


@pytest.mark.parametrize(("ends", "direct"), [((1.0, 5.0, 9.0), True), ((1.0, 1.1, 9.0), False)])
def test_lines_are_named_where_they_end_if_there_is_room(ends: tuple[float | None, ...], direct: bool) -> None:
    """Not where they end too near to each other, or before the others."""
    with page_context(PRINT):
        figure, (axis,) = sheet.new_figure(1, "title")
        for k, end in enumerate(ends):
            x = [0.0, 10.0] if end is not None else [0.0, 5.0]
            axis.plot(x, [0.0, 3.0 if end is None else end], label=f"run {k}", **line_style(k))
        axis.set(xlim=(0.0, 10.0), ylabel="speed", xlabel="time")
        sheet.name_at_ends(axis)
    arrange(figure)
    figure_checks.check(figure)
    names = ["run 0", "run 1", "run 2"]
    assert [t.get_text() for t in axis.texts] == (names if direct else [])
    assert [t.get_text() for legend in figure.legends for t in legend.get_texts()] == ([] if direct else names)
    if direct:
        box = axis.texts[1].get_window_extent()
        assert (box.y0 + box.y1) / 2 == pytest.approx(axis.transData.transform((10.0, 5.0))[1], abs=2.0)
        assert axis.get_window_extent().x1 < box.x0 < box.x1 < figure.bbox.x1


def test_the_checks_find_what_is_wrong() -> None:
    figure = drawn(PRINT, ["p1", "p2"])
    first, second = figure.axes[:2]
    figure.draw_without_rendering()
    assert figure_checks.overlapping(figure) == figure_checks.beyond(figure) == []
    second.set_title("upon the\nname of the scale above")
    first.set_xlabel("upon the title below")
    figure.draw_without_rendering()
    assert figure_checks.overlapping(figure)
    first.set_ylabel("y", labelpad=200)
    figure.draw_without_rendering()
    assert "y" in figure_checks.beyond(figure)
    a, b = (first.plot([0, 1], [0, k], "--", color=colour, label=colour)[0] for k, colour in enumerate(("#0072B2", "#009E73")))
    assert figure_checks.alike([a, b]) == [("#0072B2", "#009E73")], "blue and green are one grey"


def test_a_figure_that_is_no_more_needed_is_freed() -> None:
    """Sixty of them took 4 to 10 MB each."""
    alive = [weakref.ref(drawn(PRINT, ["one", "two"])) for _ in range(1)]
    gc.collect()
    assert [figure() for figure in alive] == [None]


def test_a_speed_above_a_panel_is_in_rpm_too() -> None:
    with page_context(PRINT):
        figure, (axis,) = sheet.new_figure(1, "title")
        axis.set_xlim(0.0, math.pi)
        sheet.rpm_axis(axis, "rad/s", "x")
    (second,) = axis.child_axes
    figure.draw_without_rendering()
    assert second.get_xlim() == pytest.approx((0.0, 30.0)) and second.get_xlabel() == "speed (rpm)"
    assert second.spines["top"].get_visible() and not sheet.sheet_of(figure).right


MM = 25.4


@pytest.mark.parametrize(("panels", "width"), [(2, 88), (6, 88), (9, 180)])
def test_a_figure_that_would_be_too_tall(
    study: Callable[..., Path], monkeypatch: pytest.MonkeyPatch, panels: int, width: int
) -> None:
    result = package.run_file(study(), {"study.until": "0.02 s"})

    def figure(_result: object) -> object:
        drawn, axes = sheet.new_grid(panels, "", columns=2, heights=1.6)
        for axis in axes:
            axis.plot([0, 1])
            axis.set(xlabel="time (s)", ylabel="speed (rad/s)")
        return drawn

    monkeypatch.setattr(package.RunUp, "draw", lambda _, result: figure(result))
    drawn = package.draw(result, JOURNAL)
    assert round(drawn.get_figwidth() * MM) == width
    assert drawn.get_figheight() <= JOURNAL.tallest


BACK = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def column(count: int, heights: float = 2.0, title: str = "title") -> tuple[Figure, list[Any]]:
    figure, axes = sheet.new_figure(count, title, heights=heights)
    for axis in axes:
        axis.plot([0.0, 1.0], [0.0, 1.0])
        axis.set_ylabel("y")
    axes[-1].set_xlabel("x")
    return figure, axes


@pytest.mark.parametrize(
    ("largest", "name", "expected"),
    [
        (1.1e-5, "damage so far", "damage so far (10⁻⁶)"),
        (3e-4, "mean torque (N m)", "mean torque (10⁻⁶ N m)"),
        (4e4, "force (N)", "force (10³ N)"),
        (2e7, "stiffness (N/m)", "stiffness (10⁶ N/m)"),
        (4e3, "force (N)", "force (N)"),
        (2e-2, "damage so far", "damage so far"),
    ],
)
@pytest.mark.parametrize("of", ["y", pytest.param("x", marks=pytest.mark.slow)])
def test_a_power_of_ten_is_in_the_name_of_its_scale(largest: float, name: str, expected: str, of: str) -> None:
    """Of a thousand; without a text above the scale, and the numbers are those of the unit in the name."""
    with page_context(PRINT):
        figure, (axis,) = sheet.new_figure(1, "title")
        ends = ([0.0, largest], [0.0, 1.0])
        axis.plot(*(ends if of == "x" else ends[::-1]))
        axis.set(**{"xlabel": "x", "ylabel": "y"} | {f"{of}label": name})
        axis.ticklabel_format(scilimits=(-3, 4))
        arranging.arrange(figure)
    figure.draw_without_rendering()
    scale = getattr(axis, f"{of}axis")
    assert scale.get_label_text() == expected
    assert not scale.get_offset_text().get_visible() or not scale.get_offset_text().get_text()
    power = int(expected.partition("(10")[2].partition(")")[0].split(" ")[0].translate(BACK) or 0)
    at, words = scale.get_majorticklocs()[1], scale.get_major_formatter().format_ticks(scale.get_majorticklocs())[1]
    assert float(words.replace("−", "-")) * 10.0**power == pytest.approx(at)


def test_figures_that_were_made_otherwise_stay_as_they_are() -> None:
    own = Figure(figsize=(3, 2))
    axis = own.subplots()
    before = axis.get_position().bounds
    assert arrange(own).get_size_inches().tolist() == [3, 2]
    assert axis.get_position().bounds == before
