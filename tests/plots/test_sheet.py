"""Panels, legends and scales in their places, on a page and in a column of a journal."""

from __future__ import annotations

import gc
import math
import weakref
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import figure_checks
from wucht.plots import sheet
from wucht.plots.arranging import arrange
from wucht.plots.page import JOURNAL, PRINT, Page, page_context
from wucht.plots.style import line_style

BOTH_COLUMNS = JOURNAL.fallback_pages[1]
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
@pytest.mark.parametrize("count", [1, pytest.param(4, marks=pytest.mark.slow), 12])
def test_whatever_is_named_stands_on_the_page_beside_all_else(page: Page, count: int) -> None:
    names = [f"a body with a rather long name, number {k}" if k % 2 else f"b{k}" for k in range(count)]
    figure = drawn(page, names)
    figure_checks.check(figure)
    assert [t.get_text().replace("\n", " ") for t in figure.axes[0].get_legend().get_texts()] == names


@PAGES
def test_its_width_is_that_of_the_page(page: Page) -> None:
    figure = drawn(page, ["p1", "p2"])
    assert figure.get_figwidth() == page.width
    assert figure.get_suptitle() == ("title" if page is PRINT else "")
    assert figure_checks.sizes(figure) == {page.font, page.small}
    assert pytest.approx(88 / 25.4) == JOURNAL.width
    assert JOURNAL.small == JOURNAL.font == 8


def test_legends_stand_beside_their_panels_or_above_them() -> None:
    for page, beside in ((PRINT, True), (JOURNAL, False)):
        figure = drawn(page, ["p1", "p2"])
        figure.draw_without_rendering()
        legend, panel = figure.axes[0].get_legend().get_window_extent(), figure.axes[0].get_window_extent()
        assert bool(legend.x0 > panel.x1) is beside
        assert bool(legend.y0 > panel.y1) is not beside


def test_a_line_that_its_scale_names_needs_no_legend() -> None:
    assert drawn(PRINT, ["speed"]).axes[0].get_legend() is None
    assert drawn(PRINT, ["drum"]).axes[0].get_legend() is not None


def test_rpm_beside_radians_a_second_only() -> None:
    figure = drawn(PRINT, ["p1", "p2"])
    figure.draw_without_rendering()
    [second] = figure.axes[0].child_axes
    assert second.get_ylim() == pytest.approx(np.array(figure.axes[0].get_ylim()) * 30 / np.pi)
    with page_context(PRINT):
        _, (axis,) = sheet.new_figure(1, "title")
        sheet.rpm_axis(axis, "")
    assert axis.child_axes == []


@pytest.mark.parametrize(("ends", "direct"), [((1.0, 5.0, 9.0), True), ((1.0, 1.1, 9.0), False), ((1.0, 5.0, None), False)])
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


def test_figures_that_were_made_otherwise_stay_as_they_are() -> None:
    own = Figure(figsize=(3, 2))
    axis = own.subplots()
    before = axis.get_position().bounds
    assert arrange(own).get_size_inches().tolist() == [3, 2]
    assert axis.get_position().bounds == before


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
    alive = [weakref.ref(drawn(PRINT, ["one", "two"])) for _ in range(3)]
    gc.collect()
    assert [figure() for figure in alive] == [None, None, None]


@pytest.mark.parametrize(
    ("change", "added"),
    [
        (lambda figure, axis: axis.set_title("one line"), 1.25 + 2 * 0.7 - 0.5),
        (lambda figure, axis: axis.set_title("two\nlines"), 2 * 1.25 + 2 * 0.7 - 0.5),
        (lambda figure, axis: axis.set_xlabel(""), -1.25),
        (lambda figure, axis: axis.set_xticks([]), -1.8),
        (lambda figure, axis: axis.set_xticks([0, 1], ["rest", "one\ntwo\nthree"]), 2 * 1.25),
        (lambda figure, axis: sheet.rpm_axis(axis, "rad/s", "x"), 1.8 + 1.25 + 0.4),
        (lambda figure, axis: sheet.write_assumptions(figure, ["no friction"]), 1.25 * PRINT.small / PRINT.font),
    ],
)
def test_a_figure_grows_by_what_stands_above_and_below_a_panel(change: Any, added: float) -> None:
    """In sizes of the text: a line 1.25, the numbers of a scale 1.8, half a size where no title is, 0.7 above and below one."""

    def height(changed: bool) -> float:
        with page_context(PRINT):
            figure, (axis,) = sheet.new_figure(1, "title")
            axis.plot([0.0, 1.0], [0.0, 1.0])
            axis.set_xlabel("time")
            if changed:
                change(figure, axis)
        return float(arrange(figure).get_figheight())

    em = PRINT.font / 72
    assert height(False) == pytest.approx(
        (1.25 * 10 / PRINT.font + 0.6) * em + 0.5 * em + 1.55 + (1.8 + 1.25 + 0.7) * em, abs=1.5 / PRINT.dpi
    )
    assert height(True) - height(False) == pytest.approx(added * em, abs=1.5 / PRINT.dpi)


def test_scale_legend_and_title_stand_above_a_panel_in_this_order_and_close_together() -> None:
    with page_context(PRINT):
        figure, (axis,) = sheet.new_figure(1, "title")
        axis.plot([0.0, 1.0], [0.0, 1.0], label="a line")
        axis.set_title("a panel")
        sheet.rpm_axis(axis, "rad/s", "x")
        sheet.legend_above(axis)
    arrange(figure)
    figure.draw_without_rendering()
    em = PRINT.font / 72 * figure.dpi
    panel, legend, name = axis.get_window_extent(), axis.get_legend().get_window_extent(), axis.title.get_window_extent()
    assert legend.y0 - panel.y1 == pytest.approx((0.2 + 1.8 + 1.25 + 0.4) * em, abs=0.05 * em)
    assert 0.0 < name.y0 - legend.y1 < 0.6 * em
    assert name.x0 == pytest.approx(panel.x0, abs=0.2 * em) and legend.x0 == pytest.approx(panel.x0, abs=0.2 * em)
    sketch, (bare,) = sheet.new_figure(1, "title")
    bare.set(xticks=[], title="no scales")
    arrange(sketch)
    assert bare.title.get_ha() == "center", "over a sketch"


def test_a_lone_right_edge_and_a_second_scale_narrow_a_panel_by_their_widths() -> None:
    """4.1 sizes for the numbers, a line for the name and 0.7 about it at the left; 1.7 or a scale's 6.2 at the right."""
    widths = {}
    for unit in ("", "rad/s"):
        with page_context(PRINT):
            figure, (axis,) = sheet.new_figure(1, "title")
            axis.plot([0.0, 1.0], [0.0, 1.0])
            axis.set_ylabel("speed")
            sheet.rpm_axis(axis, unit)
        arrange(figure)
        x, _, widths[unit], _ = np.array(axis.get_position().bounds) * PRINT.width * 72 / PRINT.font
        assert x == pytest.approx(4.1 + 1.25 + 0.7)
    assert widths[""] == pytest.approx(PRINT.width * 72 / PRINT.font - 6.05 - 1.7)
    assert widths[""] - widths["rad/s"] == pytest.approx(6.2 - 1.7)


@pytest.mark.parametrize(
    ("page", "keys", "rows"),
    [
        (PRINT, {"columns": 3, "wide": 1, "last": 1}, [[0], [1, 2, 3], [4, 5], [6]]),
        (JOURNAL, {"columns": 3, "wide": 1, "last": 1}, [[0], [1], [2], [3], [4], [5], [6]]),
        (PRINT, {"columns": 5, "narrow": 2}, [[0, 1], [2, 3], [4, 5], [6]]),
        (BOTH_COLUMNS, {"columns": 3}, [[0, 1], [2, 3], [4, 5], [6]]),
        (PRINT, {}, [[0, 1], [2, 3], [4, 5], [6]]),
    ],
)
def test_rows_of_a_grid(page: Page, keys: dict[str, int], rows: list[list[int]]) -> None:
    """A height holds for all further rows; panels of a journal are lower."""
    with page_context(page):
        figure, axes = sheet.new_grid(7, "title", heights=(2.0, 1.0), **keys)  # type: ignore[arg-type]
    of = sheet.sheet_of(figure)
    assert [[axes.index(axis) for axis in row] for row in of.rows] == rows
    assert of.heights == [page.height * h for h in (2.0, *(1.0,) * (len(rows) - 1))]
    room = {PRINT: keys.get("columns", 2), JOURNAL: 1, BOTH_COLUMNS: 2}[page] if "narrow" not in keys else 2
    wide, last = keys.get("wide", 0), keys.get("last", 0)
    assert of.columns == [1] * wide + [room] * (len(rows) - wide - last) + [1] * last


def test_panels_over_one_abscissa_share_it_and_only_the_last_has_its_numbers() -> None:
    with page_context(PRINT):
        _, axes = sheet.new_figure(3, "title")
    axes[0].set_xlim(2.0, 5.0)
    assert [axis.get_xlim() for axis in axes] == [(2.0, 5.0)] * 3
    assert [axis.xaxis.get_tick_params().get("labelbottom", True) for axis in axes] == [False, False, True]


def test_panels_drawn_by_functions_have_the_sentence_of_their_result() -> None:
    result: Any = SimpleNamespace(attrs={"title": "a drum", "sentence": "It is captured."})
    legends = list[Any]()

    def panel(value: float) -> Any:
        return lambda axis, of: axis.plot([0, 1], [value, value], label=of.attrs["title"])

    with page_context(PRINT):
        figure, axes = sheet.draw_panels(result, [panel(1.0), panel(2.0)], legends.append, columns=1, heights=1.0)
        other, _ = sheet.draw_panels(result, [panel(1.0)], None, subtitle="what it is")
        above, (axis,) = sheet.draw_panels(result, [panel(1.0)])
    assert sheet.sheet_of(figure).heading == "a drum\nIt is captured." and sheet.sheet_of(other).heading == "a drum\nwhat it is"
    assert [np.asarray(axis.get_lines()[0].get_ydata())[0] for axis in axes] == [1.0, 2.0] and legends == axes
    assert sheet.sheet_of(figure).columns == [1, 1] and not sheet.sheet_of(other).above
    assert sheet.sheet_of(above).above[axis].names == ["a drum"]
    assert [h.get_label() for h in sheet.labelled_handles(axes)] == ["a drum", "a drum"]


def test_a_legend_for_all_panels_has_each_name_once_with_its_first_handle() -> None:
    with page_context(PRINT):
        figure, axes = sheet.new_figure(2, "title")
        handles = [axis.plot([0, 1], label=name)[0] for axis, name in zip((*axes, axes[0]), ("p", "q", "p"), strict=True)]
        sheet.legend_over(figure, handles, "bodies")
        sheet.legend_below(figure, handles[1:])
        over, below = sheet.sheet_of(figure).over, sheet.sheet_of(figure).below
        assert over is not None and below is not None
        assert (over.names, over.handles, over.title) == (["p", "q"], handles[:2], "bodies")
        assert (below.names, below.handles, below.title) == (["q", "p"], handles[1:], None)
        sheet.legend_over(figure, [])
        assert sheet.sheet_of(figure).over is None
    sheet.legend_over(figure, handles)
    arrange(figure)
    figure.draw_without_rendering()
    boxes = [legend.get_window_extent() for legend in figure.legends]
    panels = [axis.get_window_extent() for axis in axes]
    assert max(box.y0 for box in boxes) > panels[0].y1 and min(box.y1 for box in boxes) < panels[1].y0
    assert all((box.x0 + box.x1) / 2 == pytest.approx(figure.bbox.x1 / 2, abs=1.0) for box in boxes)


def test_a_scale_of_colours_has_its_name_and_room() -> None:
    with page_context(PRINT):
        figure, (axis,) = sheet.new_figure(1, "title")
        bar = sheet.colour_bar(axis, axis.imshow(np.array([[1.0, 3.0]])), "speed (rad/s)")
    assert bar.ax.get_ylabel() == "speed (rad/s)" and (bar.vmin, bar.vmax) == (1.0, 3.0)
    assert sheet.sheet_of(figure).right[axis] == pytest.approx(6.2 + 1.0)


def test_assumptions_are_below_a_heading_alone() -> None:
    with page_context(PRINT):
        titled, _ = sheet.new_figure(1, "title")
        bare, _ = sheet.new_figure(1, "")
    for figure in (titled, bare):
        sheet.write_assumptions(figure, ["no friction", "a rigid shaft"])
    assert sheet.sheet_of(titled).note == "assumed: no friction; a rigid shaft"
    assert not sheet.sheet_of(bare).note
    sheet.write_assumptions(titled, ["word " * 60])
    lines = sheet.sheet_of(titled).note.split("\n")
    assert [len(line.split()) for line in lines] == [20, 21, 20], "no word is alone in the last"
    for word, count in (("ill ", 2), ("www ", 3)):
        sheet.write_assumptions(titled, [word * 60])
        assert len(sheet.sheet_of(titled).note.split("\n")) == count, "by the width of the letters"


def test_lines_are_as_long_as_each_other_and_no_more_than_needed() -> None:
    text = "one two three four five six seven eight"
    assert sheet._even_lines(text, 100) == [text]
    assert sheet._even_lines(text, 34) == ["one two three four", "five six seven eight"]
    assert sheet._even_lines(text, 6) == ["one", "two", "three", "four", "five", "six", "seven", "eight"]
    assert sheet._even_lines("", 6) == []


def test_a_speed_above_a_panel_is_in_rpm_too() -> None:
    with page_context(PRINT):
        figure, (axis,) = sheet.new_figure(1, "title")
        axis.set_xlim(0.0, math.pi)
        sheet.rpm_axis(axis, "rad/s", "x")
    (second,) = axis.child_axes
    figure.draw_without_rendering()
    assert second.get_xlim() == pytest.approx((0.0, 30.0)) and second.get_xlabel() == "speed (rpm)"
    assert second.spines["top"].get_visible() and not sheet.sheet_of(figure).right


def test_a_title_has_the_clauses_that_fit_on_a_line() -> None:
    clause = "a clause of some forty letters and a digit 1"
    with page_context(PRINT):
        assert sheet.leading_clauses(clause) == clause
        assert sheet.leading_clauses(f"{clause}; short") == f"{clause}; short"
        assert sheet.leading_clauses(f"{clause}; {clause}; {clause}") == f"{clause}; {clause}"[: 2 * len(clause) + 2]
        assert sheet.leading_clauses(f"{4 * clause}; short") == 4 * clause, "at least one"


@PAGES
def test_a_colour_bar_has_room_for_all_lines_of_its_name(page: Page) -> None:
    with page_context(page):
        figure, (left, right) = sheet.new_grid(2, "title", narrow=2)
        left.plot([0.0, 1.0], [0.0, 1.0])
        image = right.scatter([0.0, 1.0], [0.0, 1.0], c=[0.333, 0.444])
        bar = sheet.colour_bar(right, image, "fullness of a\nspectrum, in\nthree lines")
    arrange(figure)
    figure.draw_without_rendering()
    assert bar.ax.yaxis.label.get_window_extent().x1 <= figure.bbox.x1
