"""How figures look: printable, and readable with any colour vision."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# M. Okabe, K. Ito, "Color Universal Design", 2008: distinguishable with every kind of colour vision (less its pale yellow).
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
DASHES = ("-", "--", "-.", ":")
GREY = "#666666"
SLOW: dict[str, Any] = {"color": "#000000", "linestyle": (0, (6, 2)), "linewidth": 0.8, "zorder": 4}  # slow equations
_WIDTH, _MOST_POINTS = 8.0, 4000


def new_figure(rows: int, height: float, title: str, subtitle: str = "") -> tuple[Figure, list[Axes]]:
    """A figure with one column of panels over a common abscissa."""
    figure, axes = _panels(rows, 1, height, title, subtitle, common=True)
    # Set by hand: matplotlib's automatic layout draws everything twice, which takes as long as the whole run.
    figure.subplots_adjust(left=0.1, right=0.74, bottom=0.45 / height, top=1 - 0.55 / height, hspace=0.12)
    figure.align_ylabels(axes)
    return figure, axes


def new_grid(rows: int, columns: int, height: float, title: str, subtitle: str = "") -> tuple[Figure, list[Axes]]:
    """A figure with panels that have abscissae of their own, row by row; below them is room for a legend."""
    figure, axes = _panels(rows, columns, height, title, subtitle, common=False)
    figure.subplots_adjust(left=0.1, right=0.97, bottom=1.0 / height, top=1 - 0.6 / height, hspace=0.32, wspace=0.28)
    return figure, axes


def _panels(rows: int, columns: int, height: float, title: str, subtitle: str, common: bool) -> tuple[Figure, list[Axes]]:
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    mpl.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.7})
    figure = Figure(figsize=(_WIDTH, height), dpi=150)
    FigureCanvasAgg(figure)
    axes: list[Axes] = list(figure.subplots(rows, columns, sharex=common, squeeze=False).ravel())
    heading = figure.suptitle(title + (f"\n{subtitle}" if subtitle else ""), fontsize=10)
    heading.set_parse_math(False)  # a title may hold a dollar sign
    for axis in axes:
        axis.grid(visible=True, linewidth=0.4, color="#DDDDDD")
        axis.ticklabel_format(axis="y", scilimits=(-3, 4))  # long numbers would push the labels off the page
    return figure, axes


def line_style(index: int) -> dict[str, Any]:
    """Colour and dash of the index-th line: neighbours differ in both."""
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)], "linewidth": 1.1}


def label(result: Any, name: str, factor_unit: str | None = None) -> str:
    """``amplitude (mm)``: axis label from a variable's long name and units."""
    attributes = result[name].attrs
    units = attributes.get("units", "") if factor_unit is None else factor_unit
    return f"{attributes.get('long_name', name)} ({units})" if units else f"{attributes.get('long_name', name)}"


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
