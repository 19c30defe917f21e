"""The figure of a load spectrum: cumulative spectrum, range-mean matrix, the signal's course, damage or level crossings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.curves import draw_swings
from wucht.results.formatting import label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

_BARS, _BELOW = 40, 2
_KNEE = 10.0  # times the cycles at the knee: so far the Woehler line is drawn at most


def figure(result: xr.Dataset) -> Figure:
    """Up to four panels from a load spectrum's Dataset alone."""
    scale, unit = printed_unit(result, "range")
    panels = [_cumulative] if len(result["range"]) else []
    panels += [_matrix] if result["matrix"].values.any() else []
    panels += [_course]
    panels += [_crossings] if "crossings" in result else [_bars] if len(result["range"]) else []
    drawn, axes = sheet.new_grid(len(panels), result.attrs["title"], result.attrs["sentence"])
    for panel, axis in zip(panels, axes, strict=True):
        panel(axis, result, scale, unit)
        sheet.legend_above(axis)
    return drawn


def _crossings(axis: Axes, result: xr.Dataset, scale: float, unit: str) -> None:
    axis.plot(result["crossings"].values, scale * result["level"].values, color=style.COLOURS[0])
    axis.set_xlabel("crossings")
    axis.set_ylabel(with_unit("level", unit))
    axis.set_title("level crossings")


def _cumulative(axis: Axes, result: xr.Dataset, scale: float, unit: str) -> None:
    """Amplitude over cumulative cycles, 002 figure 6.6."""
    axis.set_title("cumulative spectrum")
    axis.set_xlabel("cumulative cycles")
    axis.set_ylabel(with_unit("amplitude", unit))
    amplitudes, counts = scale * result["range"].values[::-1] / 2, result["cumulative"].values[::-1]
    # A stair: so many cycles have at least this amplitude. It begins at the smallest number that can be.
    least = min(0.5, float(counts[0]) / 2)
    for name, values, line in (
        ("counted", counts, style.line_style(0)),
        ("twice the first half", result["half_cumulative"].values[::-1], style.line_style(1)),
    ):
        axis.step(
            np.maximum(np.append(least, values), least), np.append(amplitudes, amplitudes[-1]), where="pre", label=name, **line
        )
    axis.set_xscale("log")
    _plain(axis.xaxis)
    if "woehler_SD" in result:
        _woehler(axis, result, scale, float(amplitudes[0]))
    axis.set_ylim(bottom=0)


def _woehler(axis: Axes, result: xr.Dataset, scale: float, largest: float) -> None:
    """The Woehler line as far as it is near the spectrum."""
    k, nd, sd, k2 = (float(result[f"woehler_{key}"]) for key in ("k", "ND", "SD", "k2"))
    amplitudes = np.linspace(0.0, 1.25 * max(largest, scale * sd), 400)[1:] / (scale * sd)
    with np.errstate(over="ignore"):
        lives = nd * np.where(amplitudes >= 1, amplitudes**-k, np.inf if np.isinf(k2) else amplitudes**-k2)
    shown = lives < _KNEE * max(nd, float(result["cumulative"].max()))
    axis.plot(lives[shown], scale * sd * amplitudes[shown], color=style.GREY, linestyle=":", label="Wöhler line")


def _matrix(axis: Axes, result: xr.Dataset, scale: float, unit: str) -> None:
    """Cycles by range and mean, logarithmic; where there are none the paper."""
    from matplotlib.colors import LogNorm

    axis.set_title("range-mean matrix")
    axis.set_xlabel(with_unit("mean", unit))
    axis.set_ylabel(with_unit("range", unit))
    counts = result["matrix"].values
    inside = counts[counts > 0]
    norm = LogNorm(float(inside.min()), max(float(inside.max()), 10 * float(inside.min())))
    mesh = axis.pcolormesh(
        scale * result["mean_class"].values, scale * result["range_class"].values, np.where(counts > 0, counts, np.nan),
        norm=norm, cmap="cividis_r", shading="nearest",
    )  # fmt: skip
    empty = int(np.flatnonzero(counts.any(axis=1))[0]) - _BELOW  # classes of small ranges without cycles
    if empty > 0:
        axis.set_ylim(bottom=scale * float(result["range_class"][empty]))
    bar = sheet.colour_bar(axis, mesh, "cycles")
    _plain(bar.ax.yaxis)


def _plain(axis: Axis) -> None:
    """Decades alone."""
    from matplotlib.ticker import NullFormatter

    style.plain_decades(axis)
    axis.set_minor_formatter(NullFormatter())


def _course(axis: Axes, result: xr.Dataset, scale: float, unit: str) -> None:
    """Between which values the signal went."""
    time = result["course_time"].values
    axis.set_title("course of the signal")
    axis.set_xlabel("time $\\tau$" if result.attrs["dimensionless"] else label(result, "course_time"))
    axis.set_ylabel(with_unit("signal", unit))
    low, high = scale * result["lowest"].values, scale * result["highest"].values
    if np.array_equal(low, high):
        draw_swings(axis, time, high, color=style.COLOURS[0], linewidth=0.6, label="turning points")
    else:
        axis.fill_between(time, low, high, color=style.COLOURS[4], linewidth=0.6, label="between its extremes")
    if np.isfinite(float(result["counted_from"])):
        axis.axvline(float(result["counted_from"]), color="black", linestyle="--", linewidth=0.9, label="counted from here on")


def _bars(axis: Axes, result: xr.Dataset, scale: float, unit: str) -> None:
    """Which amplitudes do the damage; without a Woehler line, how often each happened."""
    damage = "damage" in result and float(result["damage"].sum()) > 0
    shares = (result["damage"] / result["damage"].sum() if damage else result["count"]).values
    amplitudes = scale * result["range"].values / 2
    heights, edges = np.histogram(
        amplitudes, bins=_BARS, range=(0.0, float(amplitudes.max(initial=0.0)) or 1.0), weights=shares
    )
    name = "share of the damage" if damage else "cycles"
    axis.set_title(f"{name}, by amplitude")
    axis.bar(edges[:-1], heights, width=np.diff(edges), align="edge", color=style.COLOURS[1])
    axis.set_xlabel(with_unit("amplitude", unit))
    axis.set_ylabel(name)
    axis.set_xlim(left=0)
    axis.set_ylim(bottom=0)
