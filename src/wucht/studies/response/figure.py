"""The figure of a response: amplitude, phase, centre of mass and torque over the speed, as 002 figures 2.17 to 2.19."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.configuration_lines import draw_configurations
from wucht.plots.curves import thinned, without_jumps
from wucht.plots.style import COLOURS, GREY, line_style
from wucht.results.formatting import label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_NAMES = 7  # bodies named one by one in a legend
_BELOW = 0.04  # of the panel: its part below zero
_CLIPPED = 7.5  # times the median: there an infinite amplitude is cut


def figure(result: xr.Dataset) -> Figure:
    """Four panels (three where there is no centre of mass in the plane) from a response's Dataset alone."""
    panels = [_amplitude, _phase, _centre, _torque]
    if not (np.isfinite(result.centre_distance.values).any() and float(result.eccentricity) > 0):
        panels.remove(_centre)
    drawn, axes = sheet.new_figure(len(panels), result.attrs["title"], result.attrs["sentence"])
    for panel, axis in zip(panels, axes, strict=True):
        panel(axis, result)
    free = abs(float(result.free_speed))
    style.mark_speeds(axes, result, ("critical speed", "critical speeds"), (free, "speed of the drive"), 0)
    return drawn


def _limit(axis: Axes, result: xr.Dataset, scale: float) -> None:
    """From zero up to the largest value that is finite at a resonance."""
    peaks = scale * result.peak_amplitude.values
    clipped = _CLIPPED * float(np.nanmedian(scale * result.amplitude.values))
    axis.set_ylim(0, 1.1 * max([*peaks[np.isfinite(peaks)], clipped]) if np.isinf(peaks).any() else None)


def _several(result: xr.Dataset) -> bool:
    """Whether there is a curve for each configuration of the balancing bodies."""
    return "configuration" in result.amplitude.dims


def _amplitude(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = printed_unit(result, "amplitude")
    if _several(result):
        draw_configurations(axis, result, scale * result.amplitude.values)
        axis.set_ylabel(label(result, "amplitude", unit))
        _limit(axis, result, scale)
        axis.set_ylim(-_BELOW * axis.get_ylim()[1], None)  # where bodies compensate the line is at zero
        return
    speed, amplitude = result.speed.values, result.amplitude.values
    axis.plot(*thinned(speed, scale * amplitude), color=COLOURS[0], linewidth=1.4, label="axis")
    for i, name in enumerate(map(str, result.direction.values)):
        along = result.displacement_amplitude.values[i]
        if name != "r" and np.abs(along - amplitude).max(initial=0.0) > 1e-6 * amplitude.max(initial=0.0):
            named = name if name == "foundation" else f"carrier {name}"
            axis.plot(*thinned(speed, scale * along), label=named, **line_style(i + 1))
    axis.set_ylabel(label(result, "amplitude", unit))
    _limit(axis, result, scale)


def _phase(axis: Axes, result: xr.Dataset) -> None:
    """From -90 to 270 degrees, so that what is in phase or in opposition does not lie on an edge."""
    directions, drawn = list(map(str, result.direction.values)), list[np.ndarray]()
    if _several(result):
        lags = np.mod(np.degrees(result.lag.values[:, 0]) + 90, 360) - 90
        draw_configurations(axis, result, np.array([without_jumps(lag, 360.0) for lag in lags]))
        axis.set_yticks([-90, 0, 90, 180, 270])
        axis.set_ylim(-10, 190 if np.nanmax(lags, initial=0.0) <= 190 else 270)
        axis.set_ylabel(f"phase lag of {directions[0]} (°)")
        return
    for i, lag in enumerate(result.lag.values):  # those of what does not move are NaN, and equal to none
        equal = [name for name, other in zip(directions, result.lag.values, strict=True) if np.abs(other - lag).max() < 1e-6]
        if equal[:1] == [directions[i]]:
            drawn.append(np.mod(np.degrees(lag) + 90, 360) - 90)
            appearance = line_style(0 if equal == directions else i + 1)
            axis.plot(result.speed.values, without_jumps(drawn[-1], 360.0), label=" and ".join(equal), **appearance)
    angles = np.concatenate([[0.0], *drawn])
    low, high = -90 if angles.min() < -10 else -10, 270 if angles.max() > 190 else 190
    axis.set_ylim(low, high)
    axis.set_yticks([t for t in (-90, 0, 90, 180, 270) if low <= t <= high])
    axis.set_ylabel("phase lag (°)")


def _centre(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = printed_unit(result, "centre_distance")
    speed = result.speed.values
    if _several(result):
        draw_configurations(axis, result, scale * result.centre_distance.values)
    else:
        axis.plot(
            *thinned(speed, scale * result.centre_distance.values), color=COLOURS[1], linewidth=1.1, label="centre of mass"
        )
        axis.plot(
            *thinned(speed, scale * result.amplitude.values), color=COLOURS[0], linewidth=0.9, linestyle="--", label="axis"
        )
    axis.axhline(scale * float(result.eccentricity), color=GREY, linestyle="-.", linewidth=0.8, label="eccentricity")
    axis.set_ylabel(with_unit("distance from rest", unit))
    _limit(axis, result, scale)


def _torque(axis: Axes, result: xr.Dataset) -> None:
    speed, required, losses = result.speed.values, result.required_torque.values, result.loss_torque.values
    if _several(result):
        if np.abs(losses).any():
            axis.plot(*thinned(speed, losses), color=COLOURS[2], linewidth=1.0, linestyle="-.", label="loads and bearings")
        draw_configurations(axis, result, result.vibration_torque.values)
        axis.set_ylabel(with_unit("vibration torque", result.vibration_torque.attrs["units"]))
        return
    if np.abs(losses).any():
        axis.plot(*thinned(speed, required), color=COLOURS[6], linewidth=1.1, linestyle="--", label="with losses")
        axis.plot(*thinned(speed, losses), color=COLOURS[2], linewidth=1.0, linestyle="-.", label="loads and bearings")
    axis.plot(*thinned(speed, result.vibration_torque.values), color=COLOURS[0], linewidth=1.1, label="vibration")
    on_bodies = np.abs(result.torque_on_body.values).max(axis=1, initial=0.0)
    shown = np.flatnonzero(on_bodies > 1e-3 * on_bodies.max())[:_MOST_NAMES]
    for i in shown if len(on_bodies) > 1 else ():
        name, torque = f"on {result.body.values[i]}", result.torque_on_body.values[i]
        axis.plot(*thinned(speed, torque), linewidth=0.6, color=COLOURS[(i + 1) % 6], linestyle=":", label=name)
    free = abs(float(result.free_speed))
    used = required[speed <= 1.1 * free] if np.isfinite(free) else required
    top = max(float(result.vibration_torque.max()), float(used.max(initial=0.0)))
    if 0 < 1.5 * top < float(required.max()):
        axis.set_ylim(-0.05 * top, 1.15 * top)  # a fan's load far beyond the speed of the drive would hide all else
    axis.set_ylabel(label(result, "required_torque"))
