"""Layout of a figure: places of panels, legends, second scales and title, computed once when everything is drawn.

Matplotlib's automatic layout draws everything twice, which takes as long as the whole run. Here the gaps between panels are
measured in sizes of the text, and legends by their words; the figure becomes as tall as that needs.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from wucht.plots.page import Page, current_page, page_context
from wucht.plots.scales import SUPERSCRIPTS
from wucht.plots.sheet import LETTER, LINE, TICKS, TITLE, LegendEntries, Sheet, figure_of, has_sheet, sheet_of
from wucht.plots.style import GREY
from wucht.results.formatting import units_in_print, wrap_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend
    from matplotlib.text import Text

# In sizes of the text: the numbers of a scale, the edge of the page, between panels over one abscissa, and about a name.
_NUMBERS, _EDGE, _GAP, _ABOUT = 4.1, 1.7, 1.4, 0.7
_HANDLE, _BETWEEN = 3.2, 1.0  # of a legend: its line with the gap to the text, and the gap between columns
_WIDEST, _TALL = 28, 10  # of a legend beside a panel: letters in a line, and entries; more of them are set in two columns
_FEW_LINES, _AT_EDGE = 3.5, 0.3  # a legend above a panel is no wider than that up to this height; else, from the page's edge
_HALF_NUMBER = 0.6  # of the height of a number at the upper end of a scale: it is higher than its panel
_ROOM = 1.15  # of a panel's height: greatest length of the name of its scale
_FORMULA, _COMMANDS = re.compile(r"\$[^$]*\$"), re.compile(r"(?<=\\\w)[a-z]+|[\\$_^{},]")
_STAND_IN = "\0"  # of each letter of a formula, while the name around it is broken into lines
_AT_END, _SHARE = 0.02, 0.3  # of the panel: from a line's end to the right edge, at most; of the page: widest name there


def arrange(figure: Figure) -> Figure:
    """Arrange the parts of a figure. Figures that were not made by ``sheet`` remain unchanged."""
    if not has_sheet(figure):
        return figure
    sheet = sheet_of(figure)
    with page_context(sheet.page):
        _arrange(figure, sheet)
    return figure


def _arrange(figure: Figure, sheet: Sheet) -> None:
    page, em = sheet.page, sheet.page.em
    _name_ends(figure, sheet)
    for axis in figure.axes:
        for scale in (axis.xaxis, axis.yaxis):
            name_power(scale)
    beside = {axis: _legend(axis, entries, 0.0) for axis, entries in sheet.beside.items()}
    margins = _margins(sheet, beside)
    heading_height = em * (LINE * TITLE / page.font * len(sheet.heading.split("\n")) + 0.6 if sheet.heading else 0.3)
    texts = [text for text in (sheet.sentence, sheet.note) if text]
    line = LINE * page.small / 72
    top = heading_height + line * len("\n".join(texts).split("\n")) * bool(texts)
    over = None if sheet.over is None else _legend(figure, sheet.over, page.width - 2 * em)
    depth = top + (0.0 if over is None else _size(over)[1] + 0.6 * em)
    places: list[tuple[Axes, float, float, float, float]] = []  # in inches, from the left and from the top
    for number, (row, room, height) in enumerate(zip(sheet.rows, sheet.columns, sheet.heights, strict=True)):
        sides = margins[room]
        inner = (page.width - sum(map(sum, sides))) / room
        depth += max(
            _place_above(axis, sheet, (left_margin, inner, right_margin), height)
            for axis, (left_margin, right_margin) in zip(row, sides, strict=False)
        )
        lefts = [k * inner + sum(map(sum, sides[:k])) + left_margin for k, (left_margin, _) in enumerate(sides)]
        places += [(axis, x, depth, inner, height) for axis, x in zip(row, lefts, strict=False)]
        depth += height + em * _height_below(row, number == len(sheet.rows) - 1, inner / em)
    if sheet.below is not None:
        depth += _size(_legend(figure, sheet.below, page.width - 2 * em))[1] + 0.4 * em
    rights = _scales_beside(sheet)
    depth = math.ceil(depth * figure.dpi) / figure.dpi  # whole pixels
    figure.set_size_inches(page.width, depth)
    for axis, left, above, width, height in places:
        axis.set_position((left / page.width, 1 - (above + height) / depth, width / page.width, height / depth))
        if axis in beside:
            off = (rights[axis] + 0.4) * em / width
            beside[axis].set_bbox_to_anchor((1.0 + off, 0.5), axis.transAxes)
    if over is not None:
        over.set_loc("upper center")
        over.set_bbox_to_anchor((0.5, 1 - top / depth), figure.transFigure)
    if sheet.heading and (title := figure._suptitle) is not None:  # type: ignore[attr-defined]
        title.set(y=1 - 0.4 * em / depth, va="top")
    below = heading_height
    for text in texts:
        small: Any = {"fontsize": page.small, "color": "black" if text is sheet.sentence else GREY, "parse_math": False}
        figure.text(0.5, 1 - below / depth, text, ha="center", va="top", **small)
        below += line * len(text.split("\n"))


def _scales_beside(sheet: Sheet) -> dict[Axes, float]:
    """The room for scales to the right of each panel, that of the widest of its column, so that legends beside are aligned."""
    widest = dict[tuple[int, int], float]()
    places = [(axis, (room, k)) for row, room in zip(sheet.rows, sheet.columns, strict=True) for k, axis in enumerate(row)]
    for axis, place in places:
        widest[place] = max(widest.get(place, 0.0), sheet.right.get(axis, 0.0))
    return {axis: widest[place] for axis, place in places}


def name_power(scale: Any) -> None:
    """Put the power of ten of a scale's numbers into its name, before the unit: ``energy (10³ J)``; a scale has no other place.

    It is a power of a thousand. Scales without a name have the numbers of another panel.
    """
    from matplotlib.ticker import ScalarFormatter

    formatter, text = scale.get_major_formatter(), scale.get_label_text()
    scale.get_offset_text().set_visible(False)
    if not text or not isinstance(formatter, ScalarFormatter):
        return
    formatter.format_ticks(scale.get_majorticklocs())
    _, _, exponent = formatter.get_offset().replace("\N{MINUS SIGN}", "-").partition("e")
    if not exponent:
        return
    power = 3 * (int(exponent) // 3)
    formatter.set_powerlimits((power, power))  # the same however many ticks there will be
    factor, (name, _, unit) = f"10{str(power).translate(SUPERSCRIPTS)}", text.rpartition(" (")
    scale.set_label_text(f"{name} ({factor} {unit}" if name and unit.endswith(")") else f"{text} ({factor})")


def _margins(sheet: Sheet, beside: dict[Axes, Legend]) -> dict[int, list[tuple[float, float]]]:
    """Margins to the left and right of the panels of each column, by the number of panels that fit in a row."""
    em, margins, rights = sheet.page.em, dict[int, list[tuple[float, float]]](), _scales_beside(sheet)
    for row, room, height in zip(sheet.rows, sheet.columns, sheet.heights, strict=True):
        column_margins = margins.setdefault(room, [(0.0, 0.0)] * room)
        for k, axis in enumerate(row):
            has_numbers = axis.axison and axis.get_yticks().size > 0
            left_margin = (_NUMBERS * has_numbers + LINE * _name_lines(axis.yaxis, _ROOM * height / em) + _ABOUT) * em
            right_margin = max(sheet.right.get(axis, 0.0), _EDGE) * em
            if axis in beside:
                right_margin = rights[axis] * em + _size(beside[axis])[0] + 0.8 * em
            column_margins[k] = max(column_margins[k][0], left_margin), max(column_margins[k][1], right_margin)
    return margins


def _place_above(axis: Axes, sheet: Sheet, widths: tuple[float, float, float], height: float) -> float:
    """Place the second scale, the legend and the title above a panel. Return their height in inches.

    widths: of the margin to its left, of the panel, and of the room to its right, in inches. A tall legend begins at the left
    edge of the page, where that saves lines.
    """
    em, scale = sheet.page.em, sheet.top.get(axis, 0.0) * sheet.page.em
    lines = axis.get_title().count("\n") + 1 if axis.get_title() else 0
    title = (LINE * lines + 2 * _ABOUT) * em if lines else 0.5 * em
    if axis not in sheet.above:
        _align_title_left(axis)
        return title + scale
    (left, inner, right), entries, lead = widths, sheet.above[axis], 0.0
    usual = inner if axis in sheet.right else inner + right
    legend = _legend(axis, entries, usual)
    columns, (width, tall) = legend._ncols, _size(legend)  # type: ignore[attr-defined]
    if tall > _FEW_LINES * LINE * em:
        lead = left - _AT_EDGE * em
        legend = _legend(axis, entries, lead + inner + right)
        if legend._ncols == columns and math.prod(_size(legend)) >= width * tall:  # type: ignore[attr-defined]
            legend, lead = _legend(axis, entries, usual), 0.0
    base = max(scale, _height_over(axis.yaxis.label, height), _HALF_NUMBER * em) if lead else scale
    legend.set_bbox_to_anchor((-lead / inner, 1.0 + (0.2 * em + base) / height), axis.transAxes)
    lift = _size(legend)[1] + base
    if lines:
        axis.set_title(axis.get_title(), pad=(lift + 0.6 * em) * 72)
        _align_title_left(axis)
    return title + lift + 0.3 * em


def _height_over(name: Text, height: float) -> float:
    """Return by how much the name of a scale is higher than its panel, in inches: no legend may lie on it."""
    figure = name.get_figure(root=True)
    assert figure is not None
    length = name.get_window_extent(cast("Any", figure.canvas).get_renderer()).height / figure.dpi
    return max(0.0, (float(length) - height) / 2)


def _align_title_left(axis: Axes) -> None:
    """Align a panel's title with its legend; over a sketch without scales it remains centred."""
    if axis.get_xticks().size:
        axis.title.set(x=0.0, ha="left")


def _height_below(row: list[Axes], last: bool, room: float) -> float:
    """Height of the texts below a row of panels, in sizes of the text; without numbers if the row below has the same."""
    is_shared = not last and not any(axis.axison and axis.xaxis.get_tick_params().get("labelbottom", True) for axis in row)
    name_lines = max(_name_lines(axis.xaxis, room) for axis in row)
    has_numbers = any(axis.get_xticks().size for axis in row)
    more = max(_further_lines(axis.xaxis) for axis in row)
    return _GAP if is_shared else TICKS * has_numbers + LINE * (name_lines + more) + _ABOUT


def _further_lines(scale: Any) -> int:
    """Number of further lines that words in place of a scale's numbers take below the first."""
    from matplotlib.ticker import FixedLocator

    has_fixed_ticks = isinstance(scale.get_major_locator(), FixedLocator)
    words = scale.get_major_formatter().format_ticks(scale.get_majorticklocs()) if has_fixed_ticks else []
    return max((word.count("\n") for word in words), default=0)


def _name_lines(scale: Any, room: float) -> int:
    """Break the name of a scale into lines that fit along it, and return their number. room: in sizes of the text."""
    text = scale.get_label_text()
    letters = max(int(room / LETTER), 8)
    if "\n" not in text:
        scale.set_label_text("\n".join(_wrapped_name(text, letters)))
    return int(scale.get_label_text().count("\n") + 1) if text else 0


def _wrapped_name(text: str, letters: int) -> list[str]:
    """Break a name into lines of this many letters, if possible; no formula in it is broken, nor are its commands counted."""
    formulas = iter(_FORMULA.findall(text))
    plain = _FORMULA.sub(lambda formula: _STAND_IN * max(len(_COMMANDS.sub("", formula[0])), 1), text)
    lines = wrap_text(plain, letters) if len(plain) > letters else [plain]
    return [re.sub(f"{_STAND_IN}+", lambda _: next(formulas), line) for line in lines]


def _name_ends(figure: Figure, sheet: Sheet) -> None:
    """Label lines at their ends, or else in the legend below."""
    renderer = cast("Any", figure.canvas).get_renderer()
    for axis, lines in sheet.ends.items():
        labelled_lines = [line for line in lines if not str(line.get_label()).startswith("_")]
        names = [str(line.get_label()) for line in labelled_lines]
        height = next(h for row, h in zip(sheet.rows, sheet.heights, strict=True) if axis in row)
        width = max((_width(renderer, name, sheet.page) for name in names), default=0.0)
        at = _ends(axis, labelled_lines)
        apart = np.diff(np.sort(at)).min(initial=np.inf) * height
        if (
            not labelled_lines
            or not np.isfinite(at).all()
            or apart < LINE * sheet.page.small / 72
            or width > _SHARE * sheet.page.width
        ):
            entries_below = sheet.below or LegendEntries([], [])
            sheet.below = LegendEntries([*labelled_lines, *entries_below.handles], [*names, *entries_below.names])
            continue
        for line, name, y in zip(labelled_lines, names, at, strict=True):
            place: Any = {"xycoords": "axes fraction", "textcoords": "offset points", "annotation_clip": False}
            axis.annotate(name, (1.0, y), (4, 0), va="center", color=line.get_color(), fontsize=sheet.page.small, **place)
        sheet.right[axis] = max(sheet.right.get(axis, 0.0), width / sheet.page.em + 0.8)


def _ends(axis: Axes, lines: list[Any]) -> np.ndarray:
    """Heights in the panel (n,) at which lines end at its right edge; NaN for those that do not."""
    axis.get_xlim(), axis.get_ylim()  # matplotlib computes them on access
    to_panel = axis.transScale + axis.transLimits
    ends = np.full(len(lines), np.nan)
    for k, line in enumerate(lines):
        x, y = (np.asarray(v, float) for v in line.get_data())
        fine = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
        if len(fine):
            across, up = to_panel.transform((x[fine[-1]], y[fine[-1]]))
            ends[k] = up if abs(across - 1) < _AT_END and 0 <= up <= 1 else np.nan
    return ends


def _legend(parent: Any, entries: LegendEntries, width: float) -> Legend:
    """Draw a legend in as many columns as fit in a width (0: one column, or two if there are many names)."""
    page = current_page()
    widest = int(width * 72 / (LETTER * page.small)) - 6 if width else _WIDEST
    texts = [_unbroken_units(units_in_print(n)) for n in entries.names]
    names = [n if len(n) <= widest or "$" in n else "\n".join(wrap_text(n, widest)) for n in texts]
    figure = parent if hasattr(parent, "suptitle") else figure_of(parent)
    columns = _columns(figure, names, width) if width else 1 + (len(names) > _TALL)
    place: dict[str, Any] = {"loc": "lower left" if width else "center left", "bbox_to_anchor": (0.0, 0.0)}
    if parent is figure:
        place = {"loc": "lower center", "bbox_to_anchor": (0.5, 0.0)}
    legend: Legend = parent.legend(
        entries.handles, names, ncols=columns, frameon=False, borderaxespad=0.0, borderpad=0.2, handlelength=2.4,
        handletextpad=0.6, columnspacing=_BETWEEN, labelspacing=0.4, title=entries.title, alignment="left", **place,
    )  # fmt: skip
    return legend


def _unbroken_units(text: str) -> str:
    """A name in which numbers are not separated from their units, nor from their uncertainty, where it is broken into lines."""
    with_units = re.sub(r"(?<=\d) (?=(?:[kMmµ]?[NWJVAmgs]|rad|rpm)(?:[·/²³]|\b)|%)", "\N{NO-BREAK SPACE}", text)
    return re.sub(r" ± ", "\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}", with_units)


def _columns(figure: Figure, names: list[str], width: float) -> int:
    """Greatest number of columns of a legend that fit in a width; they are filled one after the other."""
    page, canvas = current_page(), cast("Any", figure.canvas)
    renderer, letter = canvas.get_renderer(), page.small / 72
    widths = np.array([max(_width(renderer, line, page) for line in name.split("\n")) + _HANDLE * letter for name in names])
    for columns in range(len(names), 1, -1):
        parts = np.array_split(widths, columns)
        if sum(float(part.max()) for part in parts) + (columns - 1) * _BETWEEN * letter <= width:
            rows = -(-len(names) // columns)
            return -(-len(names) // rows)  # as few columns as this number of rows needs
    return 1


def _width(renderer: Any, text: str, page: Page) -> float:
    """Width of a text in a legend, in inches."""
    from matplotlib.font_manager import FontProperties

    width, _, _ = renderer.get_text_width_height_descent(text, FontProperties(size=page.small), ismath="$" in text)
    return float(width) / float(renderer.dpi)


def _size(legend: Legend) -> tuple[float, float]:
    """Width and height, in inches."""
    figure = legend.get_figure(root=True)
    assert figure is not None
    extent = legend.get_window_extent(cast("Any", figure.canvas).get_renderer())
    return float(extent.width / figure.dpi), float(extent.height / figure.dpi)
