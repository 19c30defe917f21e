"""Pages on which figures are printed: a page of a report, or a column of a journal."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cache
from typing import Any


@dataclass(frozen=True)
class Page:
    """A page. width: of figures, in inches. height: of panels, relative to the usual one. font, small: text sizes, in points.

    has_title: whether title and answer are printed above. columns: greatest number of panels beside each other. beside: legends
    are beside their panels; otherwise above them. dpi: of a picture. tallest: greatest height of a figure, in inches.
    """

    name: str
    width: float
    height: float
    font: float
    small: float
    has_title: bool
    columns: int
    beside: bool
    dpi: int
    tallest: float = math.inf

    @property
    def fallback_pages(self) -> tuple[Page, ...]:
        """Pages for a figure that is too tall: with lower panels, then across both columns of the journal."""
        wide = (_BOTH_COLUMNS,) if self == JOURNAL else ()
        return tuple(page for one in (self, *wide) for page in (one, replace(one, height=_LOWER * one.height)))[1:]

    @property
    def em(self) -> float:
        """The size of the text in inches, the unit of the gaps between panels."""
        return self.font / 72

    @property
    def settings(self) -> dict[Any, Any]:
        """Settings of matplotlib while a figure is made, and, for its ticks, while it is written."""
        return {
            "font.size": self.font, "legend.fontsize": self.small, "legend.title_fontsize": self.small,
            "axes.titlesize": self.font, "axes.labelsize": self.font, "axes.spines.top": False, "axes.spines.right": False,
            "axes.linewidth": 0.7, "hatch.linewidth": 0.6, "pdf.fonttype": 42,
        }  # fmt: skip


PRINT = Page("print", 8.0, 1.0, 9.0, 8.0, has_title=True, columns=4, beside=True, dpi=150)
# The measures of Elsevier's journals, whose pages have 190 mm by 240 mm, less a caption of two lines.
JOURNAL = Page("journal", 88 / 25.4, 0.75, 8.0, 8.0, has_title=False, columns=1, beside=False, dpi=300, tallest=230 / 25.4)
_BOTH_COLUMNS = replace(JOURNAL, width=180 / 25.4, columns=2, beside=True)
# A page of A4 between margins of 15 mm, whose text has title and answer; below the heading of a chapter there is less room.
REPORT = Page("report", 180 / 25.4, 0.68, 8.0, 8.0, has_title=False, columns=2, beside=True, dpi=150, tallest=190 / 25.4)
_LOWER = 0.8
PAGES = {page.name: page for page in (PRINT, JOURNAL)}
_CURRENT: ContextVar[Page] = ContextVar("page", default=PRINT)


def current_page() -> Page:
    """The page for which a figure is being made."""
    return _CURRENT.get()


def small() -> float:
    """The size of annotations, in points."""
    return current_page().small


@contextmanager
def page_context(page: Page) -> Iterator[None]:
    """Make and write figures for this page, whatever the user's settings of matplotlib are."""
    from matplotlib import rc_context

    token = _CURRENT.set(page)
    try:
        with rc_context(_defaults() | page.settings):
            yield
    finally:
        _CURRENT.reset(token)


@cache
def _defaults() -> dict[Any, Any]:
    """The default settings of matplotlib, except the backend that shows figures on a screen."""
    from matplotlib import rcParamsDefault

    return {name: value for name, value in rcParamsDefault.items() if name != "backend"}
