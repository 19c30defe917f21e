"""The figure of a coast-down: the speed over time, and the amplitude where the carrier moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.results.conventions import summary_of
from wucht.results.style import COLOURS, GREY, label, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def figure(result: xr.Dataset) -> Figure:
    """Two panels (three where the carrier moves) from a coast-down's Dataset alone."""
    moves = bool(np.nanmax(result.amplitude.values, initial=0.0) > 0)
    drawn, axes = new_figure(3 if moves else 2, 6.6 if moves else 5.2, result.attrs["title"], result.attrs["sentence"])
    _speed(axes[0], result)
    if moves:
        metres = result.amplitude.attrs["units"] == "m"
        shown = (1e3 if metres else 1.0) * result.amplitude
        axes[1].plot(result.time, shown, color=COLOURS[0], linewidth=1.1, label="amplitude")
        axes[1].set_ylabel(label(result, "amplitude", "mm" if metres else None))
        axes[1].set_ylim(bottom=0)
    axes[-1].semilogy(
        result.time, np.maximum(result.energy_residual, 1e-18), color=GREY, linewidth=0.8, label="energy residual"
    )
    axes[-1].set_ylim(1e-18, max(1e-8, 10 * float(result.energy_residual.max())))
    axes[-1].set_ylabel("energy residual (1)")
    end = float(result.time[-1])
    if end > float(result.time[0]):
        axes[-1].set_xlim(float(result.time[0]), end)
    axes[-1].set_xlabel(label(result, "time") if result.time.attrs["units"] else "time $\\tau$")
    for axis in axes:
        axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8)
    return drawn


def _speed(axis: Axes, result: xr.Dataset) -> None:
    """The mean over each turn, the band within which the speed swings, and the two times that are asked for."""
    summary = summary_of(result)
    axis.fill_between(
        result.time, result.min_speed, result.max_speed, color=COLOURS[4], alpha=0.5, linewidth=0, label="range of the speed"
    )
    if result.sizes["turn"] > 1:
        axis.plot(result.turn_time, result.mean_speed, color=COLOURS[0], linewidth=1.3, label="mean over a turn")
    else:
        axis.plot(result.time, result.speed, color=COLOURS[0], linewidth=1.3, label="speed")
    for k, frequency in enumerate(sorted(set(np.round(result.natural_frequency.values, 9)))):
        if abs(frequency) <= 1.05 * abs(summary["start_speed"]):
            sign = np.sign(summary["start_speed"])
            axis.axhline(
                sign * frequency, color=GREY, linestyle=":", linewidth=0.9, label="natural frequency" if k == 0 else None
            )
    if summary["half_time"] is not None:
        half = summary["start_speed"] / 2
        axis.plot([summary["half_time"]], [half], "o", color=COLOURS[1], markersize=5, zorder=4, label="speed halved")
    if summary["reversal_time"] is not None:
        axis.plot([summary["reversal_time"]], [0.0], "s", color=COLOURS[2], markersize=5, zorder=4, label="turns back")
        axis.axhline(0.0, color=GREY, linewidth=0.6)
        after = result.time.values >= summary["reversal_time"]
        axis.plot(result.time[after], result.speed[after], color=COLOURS[0], linewidth=0.5)
    axis.set_ylabel(label(result, "speed"))
