"""Pages: what would be too tall for a column of a journal has lower panels, or goes across both columns."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from matplotlib import rc_context, rcParams

import wucht as package
from wucht.plots import arranging, sheet
from wucht.plots.page import JOURNAL, PRINT, Page, page_context

MM = 25.4


def test_what_is_tried() -> None:
    lower, wide, both = JOURNAL.fallback_pages
    assert [round(page.width * MM) for page in (lower, wide, both)] == [88, 180, 180]
    assert lower.height == both.height < JOURNAL.height == wide.height
    assert {page.tallest for page in (JOURNAL, *JOURNAL.fallback_pages)} == {230 / MM}
    assert [page.width for page in PRINT.fallback_pages] == [PRINT.width]


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


def test_panels_of_a_column_have_the_room_that_it_needs() -> None:
    """A second scale beside the panels of one column takes nothing from those of the other but width."""

    def widths(scaled: bool, page: Page = PRINT) -> tuple[list[float], float]:
        with page_context(page):
            drawn, axes = sheet.new_grid(4, "", columns=2)
            for axis in axes:
                axis.plot([0, 1])
            if scaled:
                sheet.rpm_axis(axes[0], "rad/s")
            arranging.arrange(drawn)
        boxes = [axis.get_position() for axis in axes]
        assert boxes[0].x0 == boxes[2].x0 and boxes[1].x0 == boxes[3].x0, "in columns"
        return [box.width for box in boxes], boxes[3].x1

    plain, right = widths(scaled=False)
    narrow, edge = widths(scaled=True)
    assert max(narrow) == pytest.approx(min(narrow))
    assert edge == pytest.approx(right), "up to the edge of the page"
    assert plain[0] > narrow[0] > 0.8 * plain[0]


def test_the_settings_of_the_user_do_not_count() -> None:
    """Of matplotlib: a style for slides, or TeX that is not installed."""
    with rc_context({"text.usetex": True, "axes.facecolor": "red", "lines.linewidth": 9.0}), page_context(PRINT):
        assert (rcParams["text.usetex"], rcParams["axes.facecolor"], rcParams["lines.linewidth"]) == (False, "white", 1.5)
        assert rcParams["font.size"] == PRINT.font
