"""Figures of results: of a whole study, from the Dataset alone."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from wucht.errors import InputError
from wucht.plots.arranging import arrange
from wucht.plots.page import PRINT, Page, page_context
from wucht.plots.sheet import write_assumptions
from wucht.results.formatting import units_in_print
from wucht.results.provenance import refuse_edited_values
from wucht.results.report import is_of_version_0_1
from wucht.studies.registry import StudyEntry, studies

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure
    from matplotlib.text import Text


def draw(result: xr.Dataset, page: Page = PRINT) -> Figure:
    """Draw the figure of a result, from the Dataset alone.

    Parameters
    ----------
    result : xarray.Dataset
    page : Page
        Page of the print: ``PRINT``, or ``JOURNAL``, a column of 88 mm without a title. A figure that would be taller than
        230 mm there has lower panels, or is set across both columns (180 mm).

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        For an unknown study, or a Dataset that lacks variables of the written result.
    """
    with study_of_result(result) as entry:
        for trial_page in (page, *page.fallback_pages):
            with page_context(trial_page):
                figure = entry.drawer.draw(result)
                write_assumptions(figure, result.wucht.assumed)
                _print_units(figure)
            if arrange(figure).get_figheight() <= trial_page.tallest:
                break
    return figure


def _print_units(figure: Figure) -> None:
    """Write the units in the texts of a figure as those of a report."""
    for text in _texts_in(figure):
        if text.get_text() != (printed_text := units_in_print(text.get_text())):
            text.set_text(printed_text)


def _texts_in(artist: Artist) -> Iterator[Text]:
    """Texts of a figure, but for the numbers at its ticks, which are created only to be drawn."""
    from matplotlib.axis import Axis
    from matplotlib.text import Text

    if isinstance(artist, Text):
        yield artist
    for child in (artist.label, artist.offsetText) if isinstance(artist, Axis) else artist.get_children():
        yield from _texts_in(child)


@contextmanager
def study_of_result(result: xr.Dataset) -> Iterator[StudyEntry]:
    """The study of a result. Errors of its functions in a result that may have been edited become an ``InputError``."""
    kind, by_kind = result.attrs.get("study"), studies()
    if kind not in by_kind:
        module = result.attrs.get("study_module")
        place = "is not installed" if module is None else f"is in the module {module}, to be imported first: --import {module}"
        raise InputError("study", kind, f"there is no study of this kind; it {place}")
    if is_of_version_0_1(result):
        explanation = (
            "this result is of version 0.1 of wucht, which alone can draw it; `wucht report` has its verdict and numbers"
        )
        raise InputError(kind, None, explanation, code="earlier-version")
    contents = result.wucht.contents if "contents" in result.attrs else ["contents"]
    missing = [n for n in contents if n not in result.variables]
    if missing:
        raise InputError(kind, None, f"this is not a complete result of this study: {', '.join(missing)} is missing")
    with refuse_edited_values(result):
        yield by_kind[kind]
