"""The figure of a coast-down: the speed over time, and the amplitude where the carrier moves."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wucht.plots.curves import RESIDUAL, draw_residual
from wucht.plots.scales import name_speeds, printed
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS, GREY, mark_levels
from wucht.results.formatting import abscissa_label


def figure(result: xr.Dataset) -> Figure:
    """Two panels (three where the carrier moves) from a coast-down's Dataset alone."""
    moves = bool(np.nanmax(result.amplitude.values, initial=0.0) > 0)
    heights = [2.0] * (1 + moves) + [RESIDUAL]
    drawn, axes = new_figure(len(heights), result.attrs["title"], result.attrs["sentence"], heights)
    _speed(axes[0], result)
    if moves:
        amplitude, name = printed(result, "amplitude")
        axes[1].plot(result.time, amplitude, color=COLOURS[0], linewidth=1.1, label="amplitude")
        axes[1].set(ylabel=name, ylim=(0, None))
    draw_residual(axes[-1], result.time.values, result.energy_residual.values)
    if result.sizes["time"] > 1:
        axes[-1].set_xlim(float(result.time[0]), float(result.time[-1]))
    axes[-1].set_xlabel(abscissa_label(result, "time"))
    for axis in axes[:-1]:
        legend_beside(axis)
    return drawn


def _speed(axis: Axes, result: xr.Dataset) -> None:
    """The mean over each turn, the band within which the speed swings, and the two times that are asked for."""
    summary, time, blue = result.wucht.summary, result.time, COLOURS[0]
    start, half_time, reversal_time = (summary[key] for key in ("start_speed", "half_time", "reversal_time"))
    low, high, pale = result.min_speed, result.max_speed, COLOURS[4]
    axis.fill_between(time, low, high, color=pale, alpha=0.5, linewidth=0, label="range of the speed")
    if result.sizes["turn"] > 1:
        axis.plot(result.turn_time, result.mean_speed, color=blue, linewidth=1.3, label="mean over a turn")
    else:
        axis.plot(time, result.speed, color=blue, linewidth=1.3, label="speed")
    natural = np.unique(np.round(result.natural_frequency.values, 9))
    mark_levels(axis, np.sign(start) * natural[np.abs(natural) <= 1.05 * abs(start)], "natural frequency")
    if half_time is not None:
        axis.plot([half_time], [start / 2], "o", color=COLOURS[1], markersize=5, zorder=4, label="speed halved")
    if reversal_time is not None:
        axis.plot([reversal_time], [0.0], "s", color=COLOURS[2], markersize=5, zorder=4, label="turns back")
        axis.axhline(0.0, color=GREY, linewidth=0.6)
        after = time.values >= reversal_time
        axis.plot(time[after], result.speed[after], color=blue, linewidth=0.5)
    name_speeds(axis, result)
