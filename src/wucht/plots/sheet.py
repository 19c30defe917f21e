"""Panels, legends and second scales of a figure, and its file. ``arranging`` places them when everything is drawn."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.page import PRINT, Page, current_page, page_context
from wucht.results.formatting import units_in_print, wrap_text
from wucht.results.report import answer_in_print
from wucht.results.store import replace_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

SCALE, TICKS, LINE = 6.2, 1.8, 1.25  # in sizes of the text: a scale with its name beside a panel, its numbers, a line
_BAR = 1.0  # a bar of colours beside a panel
LETTER, TITLE = 0.53, 10.0  # the mean width of a letter; the size of the title, in points
_WIDE = 0.58  # mean width of a letter in a sentence with many numbers
_LINE_SHARE = 0.92  # of the page: a line of a note, whose letters may be wider than those of the whole
_MEASURED_LETTERS = 500  # of a note: its first ones, as a title may be very long
_MOST_LINES, _MOST_NOTE_LINES = 2, 4  # of a heading, and of a sentence below it


@dataclass
class LegendEntries:
    """Entries and title of a legend that is to be placed."""

    handles: list[Any]
    names: list[str]
    title: str | None = None


@dataclass
class Sheet:
    """Parts of a figure to be arranged. rows: of panels; columns: number of panels that fit in each row; heights: of each,
    in inches. right: room for scales beside panels. sentence, note: texts in small type below the heading."""

    page: Page
    heading: str
    rows: list[list[Axes]]
    columns: list[int]
    heights: list[float]
    beside: dict[Axes, LegendEntries] = field(default_factory=dict)
    above: dict[Axes, LegendEntries] = field(default_factory=dict)
    over: LegendEntries | None = None
    below: LegendEntries | None = None
    right: dict[Axes, float] = field(default_factory=dict)
    top: dict[Axes, float] = field(default_factory=dict)
    ends: dict[Axes, list[Line2D]] = field(default_factory=dict)
    sentence: str = ""
    note: str = ""


_SHEET = "_wucht_sheet"  # attribute of a figure: a global table would keep figures alive, as a sheet refers to its figure


def sheet_of(figure: Figure) -> Sheet:
    """The sheet of a figure that was made here."""
    sheet: Sheet = getattr(figure, _SHEET)
    return sheet


def has_sheet(figure: Figure) -> bool:
    """True if a figure was made here."""
    return hasattr(figure, _SHEET)


def new_figure(
    rows: int, title: str, subtitle: str = "", heights: float | Sequence[float] = 1.55, apart: int = 0
) -> tuple[Figure, list[Axes]]:
    """Make a figure with one column of panels over a common abscissa.

    heights: of the rows, in inches. apart: number of panels below them, with separate abscissae, beside each other.
    """
    figure, axes = new_grid(rows + apart, title, subtitle, columns=max(apart, 1), heights=heights, wide=rows)
    for axis in axes[1:rows]:
        axis.sharex(axes[0])
    for axis in axes[: rows - 1]:
        axis.tick_params(labelbottom=False)
    figure.align_ylabels(axes[:rows])
    return figure, axes


def new_grid(
    panels: int,
    title: str,
    subtitle: str = "",
    *,
    columns: int = 2,
    narrow: int = 0,
    heights: float | Sequence[float] = 2.1,
    wide: int = 0,
    last: int = 0,
) -> tuple[Figure, list[Axes]]:
    """Make a figure with panels that have separate abscissae, row by row.

    columns: panels in a row; narrow: where the page has room for fewer, 0: as many as it has room for. wide, last: numbers of
    panels at the beginning and at the end with a row each. heights: of the rows, in inches; the last one holds for all further
    rows.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    page = current_page()
    figure = Figure(figsize=(page.width, 3.0), dpi=page.dpi)
    FigureCanvasAgg(figure)
    columns = columns if columns <= page.columns else (narrow or page.columns)
    axes = [_add_panel(figure) for _ in range(panels)]
    rest, end = axes[wide : panels - last], axes[panels - last :]
    middle_rows = [rest[k : k + columns] for k in range(0, len(rest), columns)]
    rows = [[axis] for axis in axes[:wide]] + middle_rows + [[axis] for axis in end]
    row_heights = [page.height * h for h in ([heights] if isinstance(heights, int | float) else heights)]
    row_heights = (row_heights + row_heights[-1:] * len(rows))[: len(rows)]
    heading, sentence = _heading(title, units_in_print(subtitle), page) if page.has_title else ("", "")
    row_columns = [1] * wide + [columns] * len(middle_rows) + [1] * last
    setattr(figure, _SHEET, Sheet(page, heading, rows, row_columns, row_heights, sentence=sentence))
    if heading:
        figure.suptitle(heading, fontsize=TITLE).set_parse_math(False)  # a title may hold a dollar sign
    return figure, axes


def _add_panel(figure: Figure) -> Axes:
    axis: Axes = figure.add_axes((0.1, 0.1, 0.8, 0.8), label=str(len(figure.axes)))
    axis.grid(visible=True, linewidth=0.4, color="#DDDDDD")
    axis.set_axisbelow(True)
    axis.tick_params(labelsize=current_page().font)  # ticks are made when the figure is written
    axis.ticklabel_format(axis="y", scilimits=(-3, 4))  # long numbers would push the labels off the page
    axis.ticklabel_format(useOffset=False)
    return axis


def _heading(title: str, subtitle: str, page: Page) -> tuple[str, str]:
    """The title with the sentence below it, in at most two lines, and the sentence apart, where it needs more."""
    titles, sentences = _lines(title, page, TITLE), _lines(subtitle, page, TITLE)
    if len(titles) + len(sentences) <= _MOST_LINES:
        return "\n".join([*titles, *sentences]), ""
    return "\n".join(titles), "\n".join(_lines(subtitle, page, page.small, _MOST_NOTE_LINES))


def _lines(text: str, page: Page, size: float, most: int = _MOST_LINES) -> list[str]:
    """Break a text in letters of a size into lines that fit on the page, at most so many; the rest of it is left out."""
    letters = _letters_of_line(text, page) if text and size == page.small else int(page.width * 72 / (_WIDE * size))
    begin = text[: (most + 1) * letters]  # of more no line is printed
    lines = wrap_text(begin, letters) if text else []
    if len(lines) > most or len(begin) < len(text):
        *first, last = lines[:most]
        lines = [*first, f"{last}\N{HORIZONTAL ELLIPSIS}"]
    else:
        lines = _even_lines(begin, letters)
    return [line if len(line) <= letters else f"{line[: letters - 1]}\N{HORIZONTAL ELLIPSIS}" for line in lines]


def _even_lines(text: str, letters: int) -> list[str]:
    """Break a text into as few lines as letters in a line allow, of nearly the same length: no word is alone in the last."""
    fewest = wrap_text(text, letters) if text else []
    widths = range(letters * (len(fewest) - 1) // max(len(fewest), 1), letters)
    narrower = (wrap_text(text, width) for width in widths if width > 0 and len(fewest) > 1)
    return next((lines for lines in narrower if len(lines) == len(fewest)), fewest)


def write_counts(figure: Figure, text: str) -> None:
    """Write how many runs, cells or states an answer is from, or what of it is drawn, in small type below the heading."""
    if (sheet := sheet_of(figure)).heading:
        sheet.note = text


def write_assumptions(figure: Figure, statements: Sequence[str]) -> None:
    """Write the assumptions of a result in small type below the heading, if there is one, after its counts."""
    if statements and has_sheet(figure) and (sheet := sheet_of(figure)).heading:
        text = "; ".join(filter(None, (sheet.note, f"assumed: {'; '.join(statements)}")))
        sheet.note = "\n".join(_even_lines(text, _letters_of_line(text, sheet.page)))


def _letters_of_line(text: str, page: Page) -> int:
    """Return how many letters of a text in small type fit on a line of the page, by the width of its first letters."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    begin = text[:_MEASURED_LETTERS].replace("\n", " ")
    width, _, _ = text_to_path.get_text_width_height_descent(begin, FontProperties(size=page.small), ismath=False)
    return int(len(begin) * _LINE_SHARE * page.width * 72 / width)


def page_of(figure: Figure) -> Page:
    """The page for which a figure was made."""
    return sheet_of(figure).page if has_sheet(figure) else PRINT


def legend_beside(axis: Axes, handles: Iterable[Any] | None = None, title: str | None = None) -> None:
    """Add the legend of a panel beside it (above it if the page is narrow), with all labelled artists or the given ones."""
    sheet = sheet_of(figure_of(axis))
    entries = _legend_entries(axis, handles, title)
    alone = len(entries.names) == 1 and title is None and entries.names[0] in axis.get_ylabel()
    if entries.names and not alone:  # a single name that the scale has already is left out
        (sheet.beside if sheet.page.beside else sheet.above)[axis] = entries


def legend_above(axis: Axes, handles: Iterable[Any] | None = None, title: str | None = None) -> None:
    """Add the legend of a panel above it, likewise."""
    if (entries := _legend_entries(axis, handles, title)).names:
        sheet_of(figure_of(axis)).above[axis] = entries


def legend_below(figure: Figure, handles: Iterable[Any], title: str | None = None) -> None:
    """Add one legend for all panels, below them; each name once."""
    sheet_of(figure).below = _unique_entries(handles, title)


def legend_over(figure: Figure, handles: Iterable[Any], title: str | None = None) -> None:
    """Add one legend for all panels, above them, likewise."""
    sheet_of(figure).over = _unique_entries(handles, title)


def _unique_entries(handles: Iterable[Any], title: str | None) -> LegendEntries | None:
    once: dict[str, Any] = {}
    for handle in handles:
        once.setdefault(str(handle.get_label()), handle)
    return LegendEntries(list(once.values()), list(once), title) if once else None


def draw_panels(
    result: Any,
    panels: Sequence[Callable[[Axes, Any], None]],
    legend: Callable[[Axes], None] | None = legend_above,
    **layout: Any,
) -> tuple[Figure, list[Axes]]:
    """Make a figure with the title and answer of a result, each panel drawn by a function, with its legend.

    layout: as for ``new_grid``.
    """
    figure, axes = new_grid(len(panels), result.attrs["title"], answer_in_print(result), **layout)
    for draw, axis in zip(panels, axes, strict=True):
        draw(axis, result)
        if legend is not None:
            legend(axis)
    return figure, axes


def name_at_ends(axis: Axes) -> None:
    """Label the lines of a panel at their right ends; in the legend below all panels, if there is no room for that."""
    sheet_of(figure_of(axis)).ends[axis] = list(axis.get_lines())


def labelled_handles(axes: Iterable[Axes]) -> list[Any]:
    """The labelled artists of several panels."""
    return [handle for axis in axes for handle in axis.get_legend_handles_labels()[0]]


def _legend_entries(axis: Axes, handles: Iterable[Any] | None, title: str | None) -> LegendEntries:
    chosen = axis.get_legend_handles_labels()[0] if handles is None else list(handles)
    return LegendEntries(chosen, [str(h.get_label()) for h in chosen], title)


def figure_of(axis: Axes) -> Figure:
    """The figure of a panel."""
    figure = axis.get_figure(root=True)
    assert figure is not None
    return figure


def rpm_axis(axis: Axes, unit: str, of: str = "y") -> None:
    """Add a second scale in revolutions per minute to the right of a panel of speeds in rad/s, or (``of`` = "x") above it."""
    if unit != "rad/s":
        return
    sheet, per = sheet_of(figure_of(axis)), 30 / math.pi
    functions = (lambda x: np.asarray(x) * per), (lambda x: np.asarray(x) / per)
    make: Any = axis.secondary_yaxis if of == "y" else axis.secondary_xaxis
    second = make("right" if of == "y" else "top", functions=functions)
    second.tick_params(labelsize=sheet.page.font)
    second.spines["right" if of == "y" else "top"].set_visible(True)
    if of == "y":
        second.set_ylabel("speed (rpm)")
        sheet.right[axis] = SCALE
    else:
        second.set_xlabel("speed (rpm)")
        sheet.top[axis] = TICKS + LINE + 0.4
    if (axis.get_yscale() if of == "y" else axis.get_xscale()) == "linear":
        second.ticklabel_format(axis=of, style="plain", useOffset=False)


def colour_bar(axis: Axes, image: Any, name: str) -> Colorbar:
    """Add the colour scale of an image beside its panel. name: in one or several lines."""
    figure = figure_of(axis)
    bar = figure.colorbar(image, cax=axis.inset_axes((1.03, 0.0, 0.045, 1.0)))
    bar.set_label(name)
    bar.ax.tick_params(labelsize=current_page().small)
    sheet_of(figure).right[axis] = SCALE + _BAR + LINE * name.count("\n")
    return bar


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure in the format of the path's ending."""
    # Compressed a third faster than by default, and a tenth larger.
    packing: dict[str, Any] = {"pil_kwargs": {"compress_level": 1}} if path.suffix == ".png" else {}
    with warnings.catch_warnings(), page_context(page_of(figure)):
        warnings.filterwarnings("ignore", "Glyph", UserWarning)  # a title in a script that the font lacks
        return replace_file(path, lambda beside: figure.savefig(beside, format=path.suffix[1:], **packing))
