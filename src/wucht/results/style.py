"""How figures look: printable, and readable with any colour vision."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

# M. Okabe, K. Ito, "Color Universal Design", 2008: distinguishable with every kind of colour vision (less its pale yellow).
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
DASHES = ("-", "--", "-.", ":")
GREY = "#666666"
SLOW: dict[str, Any] = {"color": "#000000", "linestyle": (0, (6, 2)), "linewidth": 0.8, "zorder": 4}  # averaged equations
_SYMBOLS = {"time": "$\\tau$", "speed": "$\\omega$"}  # of a dimensionless machine
_WIDTH, _MOST_POINTS = 8.0, 4000
# What matplotlib takes from its settings while a figure is made, and, of ticks, when it is written.
SETTINGS: dict[Any, Any] = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.7}
_SMALL_LETTERS, _SMALL_LINE, _HEADING_LINE = 17, 0.13, 0.167  # per inch of width; inches a line
_NEAR_ZERO = 45.0  # degrees: angles that end so near to 0 are not drawn at the edge of the panel
_STRIPS, _PALE, _FEW = 100, 0.15, 2


def new_figure(rows: int, height: float, title: str, subtitle: str = "") -> tuple[Figure, list[Axes]]:
    """A figure with one column of panels over a common abscissa."""
    # Set by hand: matplotlib's automatic layout draws everything twice, which takes as long as the whole run.
    margins = {"left": 0.1, "right": 0.74, "bottom": 0.45 / height, "top": 1 - 0.55 / height, "hspace": 0.12}
    figure, axes = _panels(rows, 1, height, f"{title}\n{subtitle}", margins)
    figure.align_ylabels(axes)
    return figure, axes


def new_grid(rows: int, columns: int, height: float, title: str, subtitle: str = "") -> tuple[Figure, list[Axes]]:
    """A figure with panels that have abscissae of their own, row by row; below them is room for a legend."""
    above = 0.6 + 0.17 * subtitle.count("\n")
    margins = {"left": 0.1, "right": 0.97, "bottom": 1.0 / height, "top": 1 - above / height, "hspace": 0.32, "wspace": 0.28}
    return _panels(rows, columns, height, f"{title}\n{subtitle}", margins)


def _panels(rows: int, columns: int, height: float, heading: str, margins: dict[str, float]) -> tuple[Figure, list[Axes]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_WIDTH, height), dpi=150)
    FigureCanvasAgg(figure)
    axes: list[Axes] = list(figure.subplots(rows, columns, sharex=columns == 1, squeeze=False).ravel())
    figure.suptitle(heading.rstrip("\n"), fontsize=10).set_parse_math(False)  # a title may hold a dollar sign
    figure.subplots_adjust(**margins)
    for axis in axes:
        axis.grid(visible=True, linewidth=0.4, color="#DDDDDD")
        axis.ticklabel_format(axis="y", scilimits=(-3, 4))  # long numbers would push the labels off the page
        axis.yaxis.get_offset_text().set(x=0.01, verticalalignment="top")  # inside: above it would be in the next panel
    return figure, axes


def state_below_heading(figure: Figure, statements: Sequence[str]) -> None:
    """Write what a result assumes in small type below the heading, for which the figure becomes a little higher."""
    if not statements:
        return
    width, height = figure.get_size_inches()
    words = textwrap.wrap(f"assumed: {'; '.join(statements)}", int(_SMALL_LETTERS * width))
    added = _SMALL_LINE * len(words)
    whole, heading = height + added, figure._suptitle  # type: ignore[attr-defined]
    figure.set_size_inches(width, whole)
    for axis in figure.axes:
        place = axis.get_position()
        axis.set_position((place.x0, place.y0 * height / whole, place.width, place.height * height / whole))
    lines = 0 if heading is None else heading.get_text().count("\n") + 1
    top = (0.02 * whole if lines else 0.05) + _HEADING_LINE * lines
    stated = figure.text(0.5, 1 - top / whole, "\n".join(words), ha="center", va="top", fontsize=7, color=GREY)
    stated.set_parse_math(False)


def plain_decades(axis: Axis) -> None:
    """Ticks of a logarithmic axis as 1e-9: matplotlib's own typesetting of powers takes as long as all the rest of a figure."""
    axis.set_major_formatter(lambda value, _position: f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e"))


def line_style(index: int) -> dict[str, Any]:
    """Colour and dash of the index-th line: neighbours differ in both."""
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)], "linewidth": 1.1}


def label(result: Any, name: str, factor_unit: str | None = None) -> str:
    """``amplitude (mm)``: axis label from a variable's long name and units."""
    attributes = result[name].attrs
    return with_unit(attributes.get("long_name", name), attributes.get("units", "") if factor_unit is None else factor_unit)


def with_unit(text: str, unit: str) -> str:
    """``text (unit)``, without brackets where there is no unit."""
    return f"{text} ({unit})" if unit else text


def printed_unit(result: Any, name: str) -> tuple[float, str]:
    """The factor by which a variable is drawn, and its unit there: lengths in mm."""
    unit = str(result[name].attrs["units"])
    return (1e3, "mm") if unit == "m" else (1.0, unit)


def abscissa_label(result: Any, name: str) -> str:
    """``time (s)``, and with its symbol where there is no unit."""
    return label(result, name) if result[name].attrs["units"] else f"{name} {_SYMBOLS[name]}"


def legend_beside(axis: Axes, lines: Sequence[Line2D] = (), right: float = 1.01) -> None:
    """Name what is drawn beside its panel: some lines, or all that have a name."""
    if handles := lines or axis.get_legend_handles_labels()[0]:
        axis.legend(handles=handles, loc="center left", bbox_to_anchor=(right, 0.5), frameon=False, fontsize=8)


def mark_levels(axis: Axes, values: Iterable[float], name: str) -> None:
    """Dotted lines across a panel, the first of which has the name."""
    for k, value in enumerate(values):
        axis.axhline(value, color=GREY, linestyle=":", linewidth=0.9, label=None if k else name)


def mark_speeds(axes: Sequence[Axes], result: Any, natural: tuple[str, str], free: tuple[float, str], named: int) -> None:
    """Finish panels over the speed: mark speeds that lie in the range, set the range, write legends and the abscissa's name.

    natural: what the natural frequencies are called, one of them and several; they are marked for both senses. free: the speed
    that the drive reaches, and what it is called. named: the panel whose legend has these.
    """
    low, high = float(result.speed[0]), float(result.speed[-1])
    frequencies = np.round(result.natural_frequency.values, 9)
    shown = sorted(f for f in {*frequencies, *-frequencies} if low <= f <= high)
    marks = [(f, ":", natural[len(shown) > 1] if k == 0 else None) for k, f in enumerate(shown)]
    marks += [(free[0], "--", free[1])] if low <= free[0] <= high else []
    for axis in axes:
        for speed, dashes, name in marks:
            shown_name = name if axis is axes[named] else None
            axis.axvline(speed, color=GREY, linestyle=dashes, linewidth=0.9, label=shown_name, zorder=1)
        axis.set_xlim(low, high)
        legend_beside(axis)
    axes[-1].set_xlabel(abscissa_label(result, "speed"))


def thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """No more points than a print shows, extremes kept: smallest and largest value of each interval, in their order."""
    if len(x) <= _MOST_POINTS:
        return x, y
    size = len(x) // (_MOST_POINTS // 2) + 1
    begins = np.arange(0, len(x) - size + 1, size)
    blocks = y[: len(begins) * size].reshape(len(begins), size)
    if np.isnan(blocks).any():
        return x, y
    low, high = begins + blocks.argmin(axis=1), begins + blocks.argmax(axis=1)
    rest = np.arange(len(begins) * size, len(x))
    keep = np.unique(np.concatenate([[0], low, high, rest, [len(x) - 1]]))
    return x[keep], y[keep]


def without_jumps(phase: np.ndarray, period: float) -> np.ndarray:
    """A wrapped angle with a gap where it wraps, so that no line crosses the panel."""
    shown = phase.copy()
    shown[1:][np.abs(np.diff(phase)) > period / 2] = np.nan
    return shown


def angle_panel(axis: Axes, angles: Iterable[np.ndarray]) -> float:
    """Set the axis of a panel of angles (degrees) to one turn.

    Returns where it begins: at -180 where all angles end near 0, else at 0.
    """
    last = [a[np.isfinite(a)][-1] for a in angles if np.isfinite(a).any()]
    near = bool(last) and all(abs((x + 180) % 360 - 180) < _NEAR_ZERO for x in last)
    begin = -180.0 if near else 0.0
    axis.set_ylim(begin, begin + 360)
    axis.set_yticks(begin + np.array([0, 90, 180, 270, 360]))
    return begin


def draw_angles(axis: Axes, x: np.ndarray, degrees: np.ndarray, begin: float, styles: Sequence[dict[str, Any]]) -> None:
    """Angles (n, N) in a panel from ``begin`` on, with gaps where they wrap.

    Where one turns faster than can be drawn its line is left out, and a pale band with its name says so.
    """
    passing: list[tuple[np.ndarray, dict[str, Any]]] = []
    for angle, style in zip(degrees, styles, strict=True):
        fast = _faster_than_drawn(x, angle)
        shown = without_jumps(begin + np.remainder(angle - begin, 360), 360.0)
        axis.plot(x, np.where(fast, np.nan, shown), **style)
        passing += [(fast, style)] if fast.any() else []
    if passing:
        names = [str(style["label"]) for _, style in passing if "label" in style]
        name = f"turning past: {', '.join(names) if len(names) == len(passing) <= _FEW else 'several'}"
        colour = passing[0][1]["color"] if len(passing) == 1 else GREY
        anywhere = np.any([fast for fast, _ in passing], axis=0)
        axis.fill_between(x, begin, begin + 360, where=anywhere, label=name, color=colour, alpha=_PALE, linewidth=0)


def _faster_than_drawn(x: np.ndarray, degrees: np.ndarray) -> np.ndarray:
    """Where (N,) an angle makes more than a turn within a hundredth of the panel."""
    span = abs(float(x[-1] - x[0])) if len(x) > 1 else 0.0
    if not span or not np.isfinite(span):
        return np.zeros(len(x), bool)
    turned = np.nan_to_num(np.unwrap(np.nan_to_num(degrees), period=360.0))
    strip = np.minimum((np.abs(x - x[0]) / (span / _STRIPS)).astype(int), _STRIPS - 1)
    low, high = np.full(_STRIPS, np.inf), np.full(_STRIPS, -np.inf)
    np.minimum.at(low, strip, turned)
    np.maximum.at(high, strip, turned)
    return np.asarray((high - low > 360)[strip])
