"""Single panels of a figure by their names, drawn into axes of the user's own."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from itertools import chain, count
from typing import TYPE_CHECKING

from wucht.plots.arranging import name_power
from wucht.plots.page import current_page
from wucht.plots.sheet import LegendEntries, Sheet, has_sheet, new_grid, sheet_of, user_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_UNIT = re.compile(r"\s*\([^()]*\)$")


def panels_by_name(figure: Figure) -> dict[str, Axes]:
    """The panels of a figure that is not arranged yet, by name; none of a figure that was not made by ``sheet``.

    A panel has its title as its name, else that of its ordinate, or abscissa, without the unit; where two are alike, the later
    one has its number besides.
    """
    panels: dict[str, Axes] = {}
    for axis in [one for row in sheet_of(figure).rows for one in row] if has_sheet(figure) else []:
        label = axis.get_title() or axis.get_ylabel() or axis.get_xlabel() or "panel"
        name = " ".join(_UNIT.sub("", label).split())
        panels[next(n for n in chain([name], (f"{name} ({k})" for k in count(2))) if n not in panels)] = axis
    return panels


def panels_on_a_sheet(draw: Callable[[], Figure], names: Sequence[str], title: str, subtitle: str) -> Figure:
    """A figure of some panels of another one, one below the other, to be arranged. draw: makes the whole figure."""
    whole = draw()
    panels, whole_sheet = panels_by_name(whole), sheet_of(whole)
    rows = zip(whole_sheet.rows, whole_sheet.heights, strict=True)
    heights = {axis: height / current_page().height for row, height in rows for axis in row}
    figure, axes = new_grid(len(names), title, subtitle, columns=1, heights=[heights[panels[name]] for name in names])
    by_name, sheet = dict(zip(names, axes, strict=True)), sheet_of(figure)
    drawn_sheet = _draw_again(draw, panels, by_name)
    sheet.beside |= {axis: entries for axis, entries in drawn_sheet.beside.items() if axis in axes}
    sheet.above |= {axis: entries for axis, entries in drawn_sheet.above.items() if axis in axes}
    sheet.right |= {axis: room for axis, room in drawn_sheet.right.items() if axis in axes}
    sheet.top |= {axis: room for axis, room in drawn_sheet.top.items() if axis in axes}
    sheet.ends |= {axis: lines for axis, lines in drawn_sheet.ends.items() if axis in axes}
    sheet.below, sheet.over = drawn_sheet.below, drawn_sheet.over
    for name, axis in by_name.items():
        _take_abscissa(axis, panels[name])
    return figure


def draw_into(draw: Callable[[], Figure], panels: Mapping[str, Axes], axes: Mapping[str, Axes]) -> None:
    """Draw a figure once more, with some of its panels in axes of the user's own, each with its legend.

    draw: makes the figure. panels: of the figure as it was made before, by name. axes: for some of these. Numbers at the
    abscissa of axes stay hidden where they are.
    """
    are_shown = {name: axis.xaxis.get_tick_params().get("labelbottom", True) for name, axis in axes.items()}
    sheet = _draw_again(draw, panels, axes)
    for name, axis in axes.items():
        _take_abscissa(axis, panels[name])
        if not are_shown[name]:
            axis.tick_params(labelbottom=False)
            axis.set_xlabel("")
        for scale in (axis.xaxis, axis.yaxis):
            name_power(scale)
        entries = sheet.beside.get(axis) or sheet.above.get(axis) or _entries_of(axis, sheet)
        if entries.names:
            axis.legend(entries.handles, entries.names, title=entries.title, frameon=False, fontsize=current_page().small)


def _draw_again(draw: Callable[[], Figure], panels: Mapping[str, Axes], axes: Mapping[str, Axes]) -> Sheet:
    with user_panels({number: axes[name] for number, name in enumerate(panels) if name in axes}):
        return sheet_of(draw())


def _take_abscissa(axis: Axes, model: Axes) -> None:
    """Give axes the limits of a panel, and the abscissa that it may have in common with a panel below it."""
    if model.get_aspect() == "auto":  # else limits follow from the shape of the axes
        axis.set(xlim=model.get_xlim(), ylim=model.get_ylim())
    alike = model.get_shared_x_axes().get_siblings(model)
    if lowest := next((one for one in alike if one.get_xlabel()), None):
        axis.set_xlabel(lowest.get_xlabel())
        axis.tick_params(labelbottom=True)


def _entries_of(axis: Axes, sheet: Sheet) -> LegendEntries:
    """Entries for the labelled artists of a panel, or of the legend that all panels have in common."""
    handles, names = axis.get_legend_handles_labels()
    common = sheet.below or sheet.over or LegendEntries([], [])
    if len(names) == 1 and common.title is None and names[0] in axis.get_ylabel():
        return LegendEntries([], [])
    return LegendEntries(handles, names, common.title) if names else common
