"""Where panels, titles and names are placed: the measures in sizes of the text, and how many columns a legend has."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from wucht.plots import arranging, sheet
from wucht.plots.page import JOURNAL, PRINT, page_context

EM = PRINT.em
BACK = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def column(count: int, heights: float = 2.0, title: str = "title") -> tuple[Figure, list[Any]]:
    figure, axes = sheet.new_figure(count, title, heights=heights)
    for axis in axes:
        axis.plot([0.0, 1.0], [0.0, 1.0])
        axis.set_ylabel("y")
    axes[-1].set_xlabel("x")
    return figure, axes


def inches(figure: Figure, axis: Any) -> tuple[float, float, float, float]:
    """Left, top, width and height of a panel, from the left and from the top of the page."""
    box, width, height = axis.get_position(), *figure.get_size_inches()
    return box.x0 * width, (1 - box.y1) * height, box.width * width, box.height * height


def test_panels_over_one_abscissa_are_one_below_the_other() -> None:
    """The numbers (4.1) and the name (1.25) of a scale with a margin (0.7) to the left, 1.7 to the right; between panels 1.4
    and half a size above the lower one."""
    with page_context(PRINT):
        figure, axes = column(2)
        arranging.arrange(figure)
    heading = EM * (1.25 * 10.0 / 9.0 + 0.6)
    first, second = (inches(figure, axis) for axis in axes)
    left, width = (4.1 + 1.25 + 0.7) * EM, PRINT.width - (4.1 + 1.25 + 0.7 + 1.7) * EM
    assert first == pytest.approx((left, heading + 0.5 * EM, width, 2.0))
    assert second == pytest.approx((left, heading + 0.5 * EM + 2.0 + (1.4 + 0.5) * EM, width, 2.0))
    depth = second[1] + 2.0 + (1.8 + 1.25 + 0.7) * EM
    assert depth <= figure.get_figheight() < depth + 1 / PRINT.dpi + 1e-9, "whole pixels"
    title: Any = figure._suptitle  # type: ignore[attr-defined]
    assert title.get_position()[1] == pytest.approx(1 - 0.4 * EM / figure.get_figheight())


def test_a_note_on_assumptions_and_a_title_of_two_lines_make_room_for_themselves() -> None:
    with page_context(PRINT):
        tops = []
        for title, note in (("title", ""), ("title", "assumed: a\nb"), ("one\ntwo", "")):
            figure, axes = column(1)
            sheet.sheet_of(figure).heading, sheet.sheet_of(figure).note = title, note
            arranging.arrange(figure)
            tops.append(inches(figure, axes[0])[1])
            if note:
                (text,) = figure.texts[1:]
                assert text.get_position()[1] == pytest.approx(
                    1 - EM * (1.25 * 10.0 / 9.0 + 0.6) / figure.get_figheight(), abs=1e-9
                )
    assert np.diff(tops)[0] == pytest.approx(2 * 1.25 * PRINT.small / 72)
    assert tops[2] - tops[0] == pytest.approx(EM * 1.25 * 10.0 / 9.0)


def test_a_panel_has_its_own_title_and_second_scale_above_it() -> None:
    """A title takes its lines and twice 0.7; a scale above the panel its numbers and name."""

    def top(title: str = "", scale: bool = False) -> float:
        with page_context(PRINT):
            figure, (axis,) = column(1)
            axis.set_title(title)
            if scale:
                sheet.rpm_axis(axis, "rad/s", "x")
            arranging.arrange(figure)
        return inches(figure, axis)[1]

    assert top("one") - top() == pytest.approx((1.25 + 1.4 - 0.5) * EM)
    assert top("one\ntwo") - top("one") == pytest.approx(1.25 * EM)
    assert top(scale=True) - top() == pytest.approx((1.8 + 1.25 + 0.4) * EM)


def test_panels_beside_each_other_are_equally_wide_with_the_margins_that_the_widest_of_a_column_needs() -> None:
    with page_context(PRINT):
        figure, axes = sheet.new_grid(4, "title", columns=2, heights=1.0)
        for axis in axes:
            axis.plot([0.0, 1.0], [0.0, 1.0])
        axes[3].set_ylabel("y")
        axes[0].set_yticks([])
        arranging.arrange(figure)
    first, second, third, fourth = (inches(figure, axis) for axis in axes)
    margins = [4.1 + 0.7, 1.7, 4.1 + 1.25 + 0.7, 1.7]
    width = (PRINT.width - sum(margins) * EM) / 2
    assert [box[2] for box in (first, second, third, fourth)] == pytest.approx([width] * 4)
    assert first[0] == third[0] == pytest.approx(margins[0] * EM)
    assert second[0] == fourth[0] == pytest.approx((margins[0] + margins[1] + margins[2]) * EM + width)
    assert first[1] == second[1] and third[1] == fourth[1]


def test_the_height_below_a_row() -> None:
    """Without numbers if the row below has the same; names that are broken, and words in several lines, count as lines."""
    with page_context(PRINT):
        _, (above, below) = column(2)
        assert arranging._height_below([above], False, 60.0) == 1.4
        assert arranging._height_below([below], False, 60.0) == pytest.approx(1.8 + 1.25 + 0.7)
        assert arranging._height_below([above], True, 60.0) == pytest.approx(1.8 + 0.7), "the last one has its numbers"
        below.set_xticks([0.0, 1.0], ["one", "two\nlines\nmore"])
        assert arranging._height_below([below], True, 60.0) == pytest.approx(1.8 + 3 * 1.25 + 0.7)
        below.set_xticks([])
        assert arranging._height_below([below], True, 60.0) == pytest.approx(1.25 + 0.7)


@pytest.mark.parametrize(
    ("text", "room", "lines"),
    [
        ("", 100.0, 0),
        ("speed of the drum", 9.1, 1),  # 17 letters of 0.53
        ("speed of the drum", 8.9, 2),
        ("speed of the drum", 0.0, 2),  # eight letters at least
        ("speed $v_m$ of the drum", 9.1, 2),  # 20 letters without those of the command
        ("speed $\\,a\\,b\\,c\\,d\\,e$", 0.0, 2),  # a formula is not broken
        ("speed\nof the drum that turns", 5.0, 2),
    ],
)
def test_a_name_is_broken_where_its_scale_ends(text: str, room: float, lines: int) -> None:
    axis = Figure().subplots()
    axis.set_xlabel(text)
    assert arranging._name_lines(axis.xaxis, room) == lines
    assert axis.get_xlabel().count("\n") == max(lines - 1, 0) and axis.get_xlabel().replace("\n", " ") == text.replace(
        "\n", " "
    )


def test_lines_end_at_the_right_edge_within_two_hundredths_of_the_panel() -> None:
    axis = Figure().subplots()
    lines = [axis.plot(*xy)[0] for xy in (
        ([0, 10], [0, 5]), ([0, 9.81], [0, 2]), ([0, 9.79], [0, 2]), ([0, 10.19, 10.3], [0, 8, np.nan]), ([0, 10], [0, 11]),
        ([0, 10], [5, 0]), ([0, 10], [0, 10]), ([0, np.nan], [0, 1]), ([], []),
    )]  # fmt: skip
    axis.set(xlim=(0, 10), ylim=(0, 10))
    expected = [0.5, 0.2, np.nan, 0.8, np.nan, 0.0, 1.0, np.nan, np.nan]
    assert arranging._ends(axis, lines) == pytest.approx(np.array(expected), nan_ok=True)


@pytest.mark.parametrize(
    ("widths", "room", "columns"),
    [
        ([1.0] * 4, 99.0, 4),
        ([1.0] * 4, 4.34, 4),  # with three gaps of a letter
        ([1.0] * 4, 4.33, 2),  # three columns have two rows, as two have
        ([1.0] * 5, 5.4, 3),
        ([1.0] * 4, 1.5, 1),
        ([3.0, 1.0, 1.0], 4.2, 2),
        ([3.0, 1.0, 1.0], 4.1, 1),
    ],
)
def test_as_many_columns_of_a_legend_as_fit(
    monkeypatch: pytest.MonkeyPatch, widths: list[float], room: float, columns: int
) -> None:
    """A letter of 1/9 inch: an entry has 3.2 besides its name, and a gap of 1.5 to the next column."""
    letter = PRINT.small / 72
    monkeypatch.setattr(arranging, "_width", lambda _, line, __: float(line) - 3.2 * letter)
    figure: Any = SimpleNamespace(canvas=SimpleNamespace(get_renderer=lambda: None))
    with page_context(PRINT):
        assert arranging._columns(figure, [f"0\n{w}" for w in widths], room) == columns


@pytest.mark.parametrize(("count", "columns"), [(10, 1), (11, 2)])
def test_a_legend_beside_a_panel_has_two_columns_from_eleven_entries_on(count: int, columns: int) -> None:
    with page_context(PRINT):
        figure, (axis,) = column(1)
        entries = sheet.LegendEntries(axis.get_lines() * count, ["a name of more than twenty-eight letters"] * count, "of")
        legend = arranging._legend(axis, entries, 0.0)
        assert legend._ncols == columns and legend.get_title().get_text() == "of"  # type: ignore[attr-defined]
        assert {text.get_text() for text in legend.get_texts()} == {"a name of more than\ntwenty-eight letters"}
        width, height = arranging._size(legend)
        extent = legend.get_window_extent()
        assert (width, height) == pytest.approx((extent.width / figure.dpi, extent.height / figure.dpi))


@pytest.mark.parametrize(("count", "columns"), [(3, 1), (8, 2)])
def test_a_tall_legend_in_a_column_begins_at_the_edge_of_the_page(count: int, columns: int) -> None:
    """Where two columns have room there: names of 23 letters, for which there is none above the panel alone."""
    with page_context(JOURNAL):
        figure, (axis,) = column(1)
        lines = [axis.plot([0, 1], [k, 1], label=f"{k} without any vibration")[0] for k in range(count)]
        sheet.legend_beside(axis, lines)
        arranging.arrange(figure)
        legend = axis.get_legend()
        assert legend._ncols == columns
        left = legend.get_window_extent().x0 / figure.dpi
    assert left == pytest.approx(0.3 * JOURNAL.em if columns == 2 else inches(figure, axis)[0], abs=0.01)


def test_a_legend_at_the_edge_of_the_page_is_above_the_name_of_the_scale() -> None:
    """That is longer than the panel is high, as wide letters are."""
    with page_context(JOURNAL):
        figure, (axis,) = column(1, heights=1.2)
        lines = [axis.plot([0, 1], [k, 1], label=f"{k} without any vibration")[0] for k in range(8)]
        axis.set_ylabel("mmmmm wwwww")
        sheet.legend_beside(axis, lines)
        arranging.arrange(figure)
        figure.draw_without_rendering()
        name, legend = axis.yaxis.label.get_window_extent(), axis.get_legend().get_window_extent()
    assert name.y1 > axis.get_window_extent().y1, "it is longer"
    assert legend.y0 >= name.y1 and legend.x0 < name.x1


def test_a_share_and_its_uncertainty_are_not_parted() -> None:
    assert arranging._unbroken_units("compensated: 18.8 % ± 4.4 % of all").split(" ") == [
        "compensated:", "18.8\N{NO-BREAK SPACE}%\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}4.4\N{NO-BREAK SPACE}%", "of", "all",
    ]  # fmt: skip


def test_a_name_at_the_end_of_a_line_makes_room_to_the_right_of_its_panel() -> None:
    for page in (PRINT, JOURNAL):
        with page_context(page):
            figure, (axis,) = column(1)
            axis.get_lines()[0].set_label("drum")
            axis.set(xlim=(0.0, 1.0), ylim=(0.0, 2.0))
            sheet.name_at_ends(axis)
            arranging.arrange(figure)
            width = arranging._width(figure.canvas.get_renderer(), "drum", page)  # type: ignore[attr-defined]
        assert sheet.sheet_of(figure).right[axis] == pytest.approx(width / page.em + 0.8)
        left, _, panel, _ = inches(figure, axis)
        assert page.width - left - panel == pytest.approx(width + 0.8 * page.em)
        (name,) = axis.texts
        assert (name.get_text(), name.xy, name.get_fontsize()) == ("drum", (1.0, 0.5), page.small)


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
@pytest.mark.parametrize("of", ["x", "y"])
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


def test_numbers_beside_each_other_are_written_in_full() -> None:
    """Without a sum that is to be added to all of them."""
    with page_context(PRINT):
        figure, (axis,) = column(1)
        axis.set_ylim(1000.001, 1000.004)
        arranging.arrange(figure)
    figure.draw_without_rendering()
    assert axis.yaxis.get_offset_text().get_text() == ""
    assert axis.yaxis.get_major_formatter().format_ticks(axis.yaxis.get_majorticklocs())[0].startswith("1000.00")


def test_legends_beside_panels_are_below_each_other() -> None:
    """Though only one panel has a second scale."""
    with page_context(PRINT):
        figure, axes = column(3)
        for k, axis in enumerate(axes):
            axis.plot([0.0, 1.0], [1.0, 0.0], label=f"line {k}")
        sheet.rpm_axis(axes[0], "rad/s")
        for axis in axes[:2]:
            sheet.legend_beside(axis)
        arranging.arrange(figure)
    figure.draw_without_rendering()
    first, second = (axis.get_legend().get_window_extent().x0 for axis in axes[:2])
    scale = axes[0].child_axes[0].get_tightbbox().x1
    assert first == pytest.approx(second) and first > scale


def test_a_sentence_that_does_not_fit_below_the_title_is_in_small_type_above_the_assumptions() -> None:
    with page_context(PRINT):
        figure, (axis,) = sheet.new_figure(1, "title", "a sentence with 7.30712 s and many more words " * 4)
        axis.plot([0.0, 1.0], [0.0, 1.0])
        sheet.write_assumptions(figure, ["no friction"])
        arranging.arrange(figure)
    assert figure.get_suptitle() == "title"
    (note,) = figure.texts[1:]
    *sentence, assumption = note.get_text().split("\n")
    assert " ".join(sentence).startswith("a sentence with 7.307 s") and assumption == "assumed: no friction"
    assert note.get_fontsize() == PRINT.small
