"""The figure of a torque balance: characteristic, load line and vibration torque over the speed, as 002 figure 3.2b."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots.style import COLOURS, GREY, label, new_figure

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
        _speeds(axis, result, named=axis is axes[-1])
        axis.set_xlim(float(result.speed[0]), float(result.speed[-1]))
        if axis.get_legend_handles_labels()[0]:
            axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8)
    axes[-1].set_xlabel(label(result, "speed") if result.speed.attrs["units"] else "speed $\\omega$")
    return drawn


def _torques(axis: Axes, result: xr.Dataset) -> None:
    speed, load = result.speed.values, result.load_torque.values
    axis.plot(speed, result.drive_torque.values, color=COLOURS[1], linewidth=1.2, label="drive")
    axis.plot(speed, load, color=COLOURS[2], linewidth=1.0, linestyle="-.", label="load and bearings")
    _resistance(axis, result, load + result.vibration_torque.values, "load and vibration")
    _points(axis, result, result.point_torque.values)
    _limits(axis, result, result.drive_torque.values)
    unit = result.drive_torque.attrs["units"]
    axis.set_ylabel(f"torque ({unit})" if unit else "torque")


def _difference(axis: Axes, result: xr.Dataset, name: str) -> None:
    net = result.drive_torque.values - result.load_torque.values
    axis.plot(result.speed.values, net, color=COLOURS[1], linewidth=1.2, label=name)
    vibration = result.vibration_torque.values
    _resistance(axis, result, vibration, "vibration")
    _points(axis, result, np.interp(result.point_speed.values, result.speed.values, net))
    _limits(axis, result, net)
    unit = result.drive_torque.attrs["units"]
    axis.set_ylabel(f"torque ({unit})" if unit else "torque")


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


def _limits(axis: Axes, result: xr.Dataset, drive: np.ndarray) -> None:
    """So that the drive is seen, however high the resonance."""
    vibration = result.vibration_torque.values + result.load_torque.values
    driving = drive[drive * result.speed.values >= 0]
    largest = float(np.abs(driving).max(initial=0.0))
    low, high = float(min(drive.min(), vibration.min(), 0.0)), float(max(drive.max(), vibration.max(), 0.0))
    if largest > 0:
        above, below = (_TALLEST if driving[np.abs(driving).argmax()] * s > 0 else _BRAKING for s in (1, -1))
        low, high = max(low, -below * largest), min(high, above * largest)
    if high > low:
        axis.set_ylim(low - 0.05 * (high - low), high + 0.08 * (high - low))


def _speeds(axis: Axes, result: xr.Dataset, named: bool) -> None:
    """The natural frequencies on the side to which the rotor turns, and the speed reached without vibration."""
    low, high = float(result.speed[0]), float(result.speed[-1])
    both = {s * float(f) for f in np.round(result.natural_frequency.values, 9) for s in (1, -1)}
    shown = sorted(f for f in both if low <= f <= high)
    for k, f in enumerate(shown):
        name = ("natural frequencies" if len(shown) > 1 else "natural frequency") if named and k == 0 else None
        axis.axvline(f, color=GREY, linestyle=":", linewidth=0.9, label=name, zorder=1)
    free = float(result.free_speed)
    if low <= free <= high:
        name = "speed without vibration" if named else None
        axis.axvline(free, color=GREY, linestyle="--", linewidth=0.9, label=name, zorder=1)
    axis.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
