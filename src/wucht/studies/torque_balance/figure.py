"""The figure of a torque balance: characteristic, load line and vibration torque over the speed, as 002 figure 3.2b."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.results.speed_axis import finish_panels
from wucht.results.style import COLOURS, GREY, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TALLEST, _BRAKING = 2.5, 0.5  # of the drive's largest torque: resonances are cut above, and its braking below this share


def figure(result: xr.Dataset) -> Figure:
    """Two panels from a torque balance's Dataset alone: all torques; and drive less load against the vibration.

    Without load the second says it all, and is the only one.
    """
    loaded = bool(np.abs(result.load_torque.values).any())
    drawn, axes = new_figure(2 if loaded else 1, 6.8 if loaded else 4.6, result.attrs["title"], result.attrs["sentence"])
    if loaded:
        _torques(axes[0], result)
    _difference(axes[-1], result, "drive less load" if loaded else "drive")
    for axis in axes:
        axis.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    natural, free = ("natural frequency", "natural frequencies"), (float(result.free_speed), "speed without vibration")
    finish_panels(axes, result, natural, free, -1)
    return drawn


def _torques(axis: Axes, result: xr.Dataset) -> None:
    speed, load = result.speed.values, result.load_torque.values
    axis.plot(speed, result.drive_torque.values, color=COLOURS[1], linewidth=1.2, label="drive")
    axis.plot(speed, load, color=COLOURS[2], linewidth=1.0, linestyle="-.", label="load and bearings")
    _resistance(axis, result, load + result.vibration_torque.values, "load and vibration")
    _points(axis, result, result.point_torque.values)
    _ordinate(axis, result, result.drive_torque.values)


def _difference(axis: Axes, result: xr.Dataset, name: str) -> None:
    net = result.drive_torque.values - result.load_torque.values
    axis.plot(result.speed.values, net, color=COLOURS[1], linewidth=1.2, label=name)
    _resistance(axis, result, result.vibration_torque.values, "vibration")
    _points(axis, result, np.interp(result.point_speed.values, result.speed.values, net))
    _ordinate(axis, result, net)


def _resistance(axis: Axes, result: xr.Dataset, torque: np.ndarray, name: str) -> None:
    """A line, dashed where a working point on it would not be stable."""
    speed, stable = result.speed.values, result.stable.values.astype(bool)
    unstable = ~stable
    unstable[1:] |= ~stable[:-1]  # so that the two kinds of line meet
    solid, dashed = np.where(stable, torque, np.nan), np.where(unstable, torque, np.nan)
    axis.plot(speed, solid, color=COLOURS[0], linewidth=1.2, label=name)
    if unstable.any():
        axis.plot(speed, dashed, color=COLOURS[0], linewidth=1.2, linestyle="--", label=f"{name}, unstable")


def _points(axis: Axes, result: xr.Dataset, torque: np.ndarray) -> None:
    """Filled where stable, open where not."""
    for stable, face, name in ((True, COLOURS[6], "stable"), (False, "white", "not stable")):
        chosen = result.point_stable.values.astype(bool) == stable
        if chosen.any():
            axis.plot(
                result.point_speed.values[chosen], torque[chosen], linestyle="none", marker="o", markersize=6, color=COLOURS[6],
                markerfacecolor=face, label=f"working point, {name}", zorder=5,
            )  # fmt: skip


def _ordinate(axis: Axes, result: xr.Dataset, drive: np.ndarray) -> None:
    """Its name, and limits so that the drive is seen, however high the resonance."""
    vibration = result.vibration_torque.values + result.load_torque.values
    driving = drive[drive * result.speed.values >= 0]
    largest = float(np.abs(driving).max(initial=0.0))
    low, high = float(min(drive.min(), vibration.min(), 0.0)), float(max(drive.max(), vibration.max(), 0.0))
    if largest > 0:
        above, below = (_TALLEST if driving[np.abs(driving).argmax()] * s > 0 else _BRAKING for s in (1, -1))
        low, high = max(low, -below * largest), min(high, above * largest)
    if high > low:
        axis.set_ylim(low - 0.05 * (high - low), high + 0.08 * (high - low))
    unit = result.drive_torque.attrs["units"]
    axis.set_ylabel(f"torque ({unit})" if unit else "torque")
