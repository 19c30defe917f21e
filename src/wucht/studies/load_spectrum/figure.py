"""The figure of a load spectrum: cumulative spectrum, range-mean matrix, the signal's course, damage or level crossings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import plain_decades
from wucht.plots.sheet import colour_bar, draw_panels
from wucht.plots.style import COLOURS, GREY, line_style
from wucht.plots.time_courses import TurnWindows, draw_mean_and_range
from wucht.results.formatting import abscissa_label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BARS, _RIM = 40, 1.5  # classes of the histogram, at most; classes from the middle of the last with cycles to the frame
_ROUNDING = 1e-6  # of a class
_WINDOW = 0.01  # of the panel: the least width over which a mean is taken
_KNEE = 10.0  # times the cycles at the knee: the S-N curve is drawn up to there


def load_figure(result: xr.Dataset) -> Figure:
    """Draw up to four panels from a load spectrum's Dataset alone."""
    cycles = bool(len(result["range"]))
    panels = [_cumulative] if cycles else []
    panels += [_matrix] if result["matrix"].values.any() else []
    panels += [_course]
    panels += [_crossings] if "crossings" in result else [_bars] if cycles else []
    return draw_panels(result, panels)[0]


def _crossings(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = printed_unit(result, "range")
    axis.plot(result["crossings"].values, scale * result["level"].values, color=COLOURS[0])
    axis.set(title="level crossings", xlabel="crossings", ylabel=with_unit("level", unit))


def _cumulative(axis: Axes, result: xr.Dataset) -> None:
    """Draw the amplitude over cumulative cycles, 002 figure 6.6."""
    scale, unit = printed_unit(result, "range")
    axis.set(title="cumulative spectrum", xlabel="cumulative cycles", ylabel=with_unit("amplitude", unit))
    amplitudes = scale * result["range"].values[::-1] / 2
    # Steps: the number of cycles of at least this amplitude. They begin at the smallest possible number.
    least = min(0.5, float(result["cumulative"][-1]) / 2)
    for k, (name, variable) in enumerate({"counted": "cumulative", "twice the first half": "half_cumulative"}.items()):
        counts = np.maximum(np.append(least, result[variable].values[::-1]), least)
        axis.step(counts, np.append(amplitudes, amplitudes[-1]), where="pre", label=name, **line_style(k))
    axis.set_xscale("log")
    plain_decades(axis.xaxis, alone=True)
    if "woehler_SD" in result:
        _woehler(axis, result, scale, float(amplitudes[0]))
    axis.set_ylim(bottom=0)


def _woehler(axis: Axes, result: xr.Dataset, scale: float, largest: float) -> None:
    """Draw the S-N curve (Woehler line) near the spectrum."""
    k, nd, sd, k2 = (float(result[f"woehler_{key}"]) for key in ("k", "ND", "SD", "k2"))
    amplitudes = np.linspace(0.0, 1.25 * max(largest, scale * sd), 400)[1:] / (scale * sd)
    with np.errstate(over="ignore"):
        lives = nd * np.where(amplitudes >= 1, amplitudes**-k, np.inf if np.isinf(k2) else amplitudes**-k2)
    visible = lives < _KNEE * max(nd, float(result["cumulative"].max()))
    axis.plot(lives[visible], scale * sd * amplitudes[visible], color=GREY, linestyle=":", label="S-N curve")


def _matrix(axis: Axes, result: xr.Dataset) -> None:
    """Draw cycles by range and mean, logarithmic; blank where there are none."""
    from matplotlib.colors import LogNorm

    (scale, unit), counts = printed_unit(result, "range"), result["matrix"].values
    axis.set(title="range-mean matrix", xlabel=with_unit("mean", unit), ylabel=with_unit("range", unit))
    inside = counts[counts > 0]
    norm = LogNorm(float(inside.min()), max(float(inside.max()), 10 * float(inside.min())))
    classes = scale * result["mean_class"].values, scale * result["range_class"].values
    mesh = axis.pcolormesh(*classes, np.where(counts > 0, counts, np.nan), norm=norm, cmap="cividis_r", shading="nearest")
    axis.set_xlim(_range_with_rim(classes[0], counts.sum(axis=0) > 0))
    axis.set_ylim(_range_with_rim(classes[1], counts.sum(axis=1) > 0))
    plain_decades(colour_bar(axis, mesh, "cycles").ax.yaxis, alone=True)


def _range_with_rim(middles: np.ndarray, has_cycles: np.ndarray) -> tuple[float, float]:
    """The limits of a scale of classes with these middles (N,): around those that have cycles, with one more at either end."""
    present, width = np.flatnonzero(has_cycles), float(middles[1] - middles[0])
    return float(middles[present[0]] - _RIM * width), float(middles[present[-1]] + _RIM * width)


def _course(axis: Axes, result: xr.Dataset) -> None:
    """Draw the signal over time, or its mean and range where it swings too fast to be drawn."""
    (scale, unit), time = printed_unit(result, "range"), result["course_time"].values
    axis.set(title="course of the signal", xlabel=abscissa_label(result, "course_time", "time"))
    axis.set_ylabel(with_unit("signal", unit))
    low, high = scale * result["lowest"].values, scale * result["highest"].values
    look: dict[str, Any] = {"color": COLOURS[0], "linewidth": 1.0}
    windows = TurnWindows.even(time, float(time[-1])).at_least(_WINDOW) if len(time) else None
    if not np.array_equal(low, high):
        mean = scale * result["average"].values if "average" in result else None  # older results have none
        draw_mean_and_range(axis, time, mean, (low, high), **look)
    elif windows is not None and windows.shares(high, float(np.ptp(high))).any():
        mean = windows.means(high)
        draw_mean_and_range(axis, windows.at, mean, windows.extremes(high, mean), **look)
    else:
        axis.plot(time, high, label="turning points", **look)
    if np.isfinite(float(result["counted_from"])):
        axis.axvline(float(result["counted_from"]), color="black", linestyle="--", linewidth=0.9, label="start of counting")


def _bars(axis: Axes, result: xr.Dataset) -> None:
    """Draw the share of each amplitude in the damage; without an S-N curve, its cycles."""
    scale, unit = printed_unit(result, "range")
    damage = "damage" in result and float(result["damage"].sum()) > 0
    shares = (result["damage"] / result["damage"].sum() if damage else result["count"]).values
    amplitudes, name = scale * result["range"].values / 2, "share of the damage" if damage else "cycles"
    width = result.wucht.summary["class_width"]
    edges = _amplitude_classes(amplitudes, None if width is None else scale * width / 2)
    heights, _ = np.histogram(amplitudes, bins=edges, weights=shares)
    axis.bar(edges[:-1], heights, width=np.diff(edges), align="edge", color=COLOURS[1])
    axis.set(title=f"{name}, by amplitude", xlabel=with_unit("amplitude", unit), ylabel=name, xlim=(0, None), ylim=(0, None))


def _amplitude_classes(amplitudes: np.ndarray, width: float | None) -> np.ndarray:
    """Edges of the classes of a histogram of amplitudes (N,): whole numbers of those in which they were counted, of this width.

    Others would leave holes between bars. None: of amplitudes that were not counted in classes.
    """
    largest = float(amplitudes.max(initial=0.0)) or 1.0
    if width is None:
        return np.linspace(0.0, largest, _BARS + 1)
    least = float(amplitudes.min(initial=largest)) - width / 2
    step = width * np.ceil((largest + width / 2 - least) / width / _BARS)
    return np.asarray(least + step * np.arange(np.ceil((largest + width / 2 - least) / step - _ROUNDING) + 1))
