"""Figures of results, from the Dataset alone: of a whole study, and single panels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.errors import InputError, nearest
from wucht.plots.arranging import arrange
from wucht.plots.page import PRINT, Page, page_context
from wucht.plots.sheet import figure_of, write_assumptions
from wucht.plots.single_panels import draw_into, panels_by_name, panels_on_a_sheet
from wucht.results.formatting import units_in_print
from wucht.results.provenance import refuse_edited_values
from wucht.results.report import answer_in_print, is_of_version_0_1
from wucht.studies.registry import StudyEntry, studies

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text


def draw(
    result: xr.Dataset,
    page: Page = PRINT,
    *,
    panels: str | Sequence[str] | None = None,
    axes: Axes | Sequence[Axes] | np.ndarray | None = None,
) -> Figure:
    """Draw the figure of a result, from the Dataset alone, or single panels of it.

    Parameters
    ----------
    result : xarray.Dataset
    page : Page
        Page of the print: ``PRINT``, or ``JOURNAL``, a column of 88 mm without a title. A figure that would be taller than
        230 mm there has lower panels, or is set across both columns (180 mm).
    panels : str or sequence of str, optional
        Names of single panels, of those in ``panel_names(result)``; by default all.
    axes : matplotlib.axes.Axes, or several, optional
        Axes of the user's own, one for each panel, in which these are drawn, with their legends; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        With ``axes`` the figure of the first of them.

    Raises
    ------
    InputError
        For an unknown study, a Dataset that lacks variables of the written result, an unknown panel, and another number of
        axes than of panels.

    Examples
    --------
    >>> import wucht
    >>> from matplotlib.figure import Figure
    >>> result = wucht.run(wucht.RunUp(until=2.0), "drozdetskaya-2020/r1")
    >>> left, right = Figure().subplots(1, 2)
    >>> wucht.draw(result, panels=["speed", "motor power"], axes=[left, right]) is left.figure
    True
    """
    if panels is not None or axes is not None:
        return _draw_panels(result, page, panels, axes)
    with study_of_result(result) as entry:
        for trial_page in (page, *page.fallback_pages):
            with page_context(trial_page):
                figure = entry.drawer.draw(result)
                write_assumptions(figure, result.wucht.assumed)
                _print_units(figure)
            if arrange(figure).get_figheight() <= trial_page.tallest:
                break
    return figure


def panel_names(result: xr.Dataset) -> list[str]:
    """Return the names of the panels that the figure of a result has, for ``draw``.

    Parameters
    ----------
    result : xarray.Dataset

    Returns
    -------
    list of str
        In their order: the title of each, else the name of its ordinate, or abscissa, without the unit.

    Raises
    ------
    InputError
        As ``draw`` does.
    """
    with study_of_result(result) as entry, page_context(PRINT):
        return list(panels_by_name(entry.drawer.draw(result)))


def _draw_panels(result: xr.Dataset, page: Page, names: str | Sequence[str] | None, axes: Any) -> Figure:
    with study_of_result(result) as entry, page_context(page):
        draw_whole = partial(entry.drawer.draw, result)
        panels = panels_by_name(draw_whole())
        chosen_names = list(panels) if names is None else [names] if isinstance(names, str) else list(names)
        if not chosen_names or not set(chosen_names) <= set(panels) or len(set(chosen_names)) < len(chosen_names):
            unknown_name = next((str(name) for name in chosen_names if name not in panels), "")
            raise InputError("panels", names, f"must be names of different panels; {nearest(unknown_name, panels)}")
        if axes is None:
            figure = panels_on_a_sheet(draw_whole, chosen_names, result.attrs["title"], answer_in_print(result))
            write_assumptions(figure, result.wucht.assumed)
            _print_units(figure)
            return arrange(figure)
        user_axes = list(np.ravel(np.array(axes, object)))
        if len(user_axes) != len(chosen_names) or not all(hasattr(axis, "transAxes") for axis in user_axes):
            count = f"{len(chosen_names)} panel{'s' if len(chosen_names) > 1 else ''} ({', '.join(chosen_names)})"
            raise InputError("axes", axes, f"must be axes of matplotlib, one for each of {count}")
        draw_into(draw_whole, panels, dict(zip(chosen_names, user_axes, strict=True)))
        for axis in user_axes:
            _print_units(axis)
    return figure_of(user_axes[0])


def _print_units(figure: Figure | Axes) -> None:
    """Write the units in the texts of a figure, or a panel, as those of a report."""
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
