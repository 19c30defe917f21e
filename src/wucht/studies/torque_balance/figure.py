"""The figure of a torque balance: characteristic, load line and vibration torque over the speed, as 002 figure 3.2b."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots.marks import draw_classes
from wucht.plots.sheet import new_figure
from wucht.plots.stability_lines import draw_by_stability, draw_configurations
from wucht.plots.style import COLOURS, GREY, mark_speeds
from wucht.results.formatting import with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TALLEST, _BRAKING = 2.5, 0.5  # of the drive's largest torque: resonances are cut above, and its braking below this share
_STARTING = 3.0  # times all torques that it has to meet: the torque of a motor at standstill is cut above


def figure(result: xr.Dataset) -> Figure:
    """Two panels from a torque balance's Dataset alone: all torques; and drive less load against the vibration.

    Without load the second says it all, and is the only one.
    """
    speed, drive, load, vibration = (result[n].values for n in ("speed", "drive_torque", "load_torque", "vibration_torque"))
    loaded, net = bool(np.abs(load).any()), drive - load
    heights = 2.5 if loaded else 3.4
    drawn, axes = new_figure(2 if loaded else 1, result.attrs["title"], result.attrs["sentence"], heights)
    if loaded:
        axes[0].plot(speed, drive, color=COLOURS[1], linewidth=1.2, label="drive")
        axes[0].plot(speed, load, color=COLOURS[2], linewidth=1.0, linestyle="-.", label="load and bearings")
        _resistance(axes[0], result, load + vibration, "load and vibration", result.point_torque.values)
        _ordinate(axes[0], result, drive, result.point_torque.values)
    axes[-1].plot(speed, net, color=COLOURS[1], linewidth=1.2, label="drive less load" if loaded else "drive")
    # Not of the net torque, which jumps at the set speed of a controlled drive.
    net_points = result.point_torque.values - np.interp(result.point_speed.values, speed, load)
    _resistance(axes[-1], result, vibration, "vibration", net_points)
    _ordinate(axes[-1], result, net, net_points)
    free = (float(result.free_speed), "speed without vibration")
    mark_speeds(axes, result, ("natural frequency", "natural frequencies"), free, -1)
    at = result.point_speed.values
    axes[-1].set_xlim(min(speed[0], at.min(initial=speed[0])), max(speed[-1], at.max(initial=speed[-1])))
    return drawn


def _resistance(axis: Axes, result: xr.Dataset, torque: np.ndarray, name: str, at_points: np.ndarray) -> None:
    """A line, dashed where a working point on it would not be stable; one for each configuration of the balancing bodies.

    Working points are filled where stable, open where not; crosses where bodies would be in each other's place.
    """
    if torque.ndim > 1:
        draw_configurations(axis, result, torque)
    else:
        stable = result.stable.values.astype(bool)
        draw_by_stability(axis, result.speed.values, torque, stable, name, color=COLOURS[0], linewidth=1.2)
    over, stable = np.zeros(len(at_points), bool), result.point_stable.values.astype(bool)
    if "point_overlapping" in result:
        over = result.point_overlapping.values.astype(bool)
        axis.plot(result.point_speed.values[over], at_points[over], "x", color=GREY, markersize=4, zorder=5)
    classes = (
        (stable & ~over, "o", COLOURS[6], "working point, stable"), (~stable & ~over, "o", "white", "working point, not stable")
    )  # fmt: skip
    draw_classes(axis, result.point_speed.values, at_points, classes, color=COLOURS[6], markersize=6, zorder=5)


def _ordinate(axis: Axes, result: xr.Dataset, drive: np.ndarray, shown_points: np.ndarray) -> None:
    """The line of zero, the name of the axis, and limits so that the drive is seen, however high the resonance."""
    vibration = result.vibration_torque.values + result.load_torque.values
    driving = drive[drive * result.speed.values >= 0]
    largest = float(np.abs(driving).max(initial=0.0))
    shown = np.concatenate([[0.0], drive, vibration[np.isfinite(vibration)]])
    low, high = float(shown.min()), float(shown.max())
    if largest > 0:
        above, below = (_TALLEST if driving[np.abs(driving).argmax()] * s > 0 else _BRAKING for s in (1, -1))
        low, high = max(low, -below * largest), min(high, above * largest)
        met = np.concatenate([np.abs(vibration[np.isfinite(vibration)]), np.abs(result.point_torque.values)])
        most = _STARTING * float(met.max(initial=0.0)) or largest
        low, high = max(low, -most), min(high, most)
    points = shown_points[np.isfinite(shown_points)]
    low, high = min(low, points.min(initial=low)), max(high, points.max(initial=high))  # wherever the machine works is shown
    if high > low:
        axis.set_ylim(low - 0.05 * (high - low), high + 0.08 * (high - low))
    axis.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axis.set_ylabel(with_unit("torque", result.drive_torque.attrs["units"]))
