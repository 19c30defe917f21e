"""The figure of a response: amplitude, phase, centre of mass and torque over the speed, as 002 figures 2.17 to 2.19."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.curves import thin_curve, without_jumps
from wucht.plots.scales import printed_values
from wucht.plots.sheet import new_figure
from wucht.plots.stability_lines import draw_configurations
from wucht.plots.style import COLOURS, GREY, line_style, mark_speeds
from wucht.results.formatting import label, printed_unit, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_NAMES = 7  # bodies named one by one in a legend
_BELOW = 0.04  # of the panel: its part below zero
_CENTRING = 0.1  # of the eccentricity: where the axis moves less, beyond all resonances, the rotor does not centre itself
_CLIP_FACTOR = 7.5  # times the median: the limit of the axis for an infinite amplitude


def figure(result: xr.Dataset) -> Figure:
    """Draw four panels from a response's Dataset alone, three for a machine without a rotor that centres itself."""
    panels = [_amplitude, _phase, _centre, _torque] if _centres_itself(result) else [_amplitude, _phase, _torque]
    fig, axes = new_figure(len(panels), result.attrs["title"], answer_in_print(result))
    for panel, axis in zip(panels, axes, strict=True):
        panel(axis, result)
    free = abs(float(result.free_speed))
    mark_speeds(axes, result, ("critical speed", "critical speeds"), (free, "speed of the drive"), 0)
    return fig


def _centres_itself(result: xr.Dataset) -> bool:
    """True for a single rotor whose axis moves by a share of its eccentricity at the highest speed.

    The axis of an exciter on a heavy deck hardly moves, and its centre of mass remains at the eccentricity from rest.
    """
    bodies = result.wucht.machine.get("bodies") or ()
    has_several = sum(not on for _, _, on in bodies) > 1
    eccentricity, last = float(result.eccentricity), result.amplitude.values[..., -1]
    is_known = bool(np.isfinite(result.centre_distance.values).any()) and eccentricity > 0
    moves = float(np.max(last[np.isfinite(last)], initial=0.0)) >= _CENTRING * eccentricity
    return is_known and moves and not has_several


def _limit(axis: Axes, result: xr.Dataset, scale: float) -> None:
    """Set limits from zero up to the largest finite maximum at a resonance."""
    peaks = scale * result.peak_amplitude.values
    clip_level = _CLIP_FACTOR * float(np.nanmedian(scale * result.amplitude.values))
    axis.set_ylim(0, 1.1 * max([*peaks[np.isfinite(peaks)], clip_level]) if np.isinf(peaks).any() else None)


def _has_configurations(result: xr.Dataset) -> bool:
    """True if there is a curve for each configuration of the balancing bodies."""
    return "configuration" in result.amplitude.dims


def _plot_over_speed(axis: Axes, result: xr.Dataset, values: np.ndarray, name: str, color: str, **look: Any) -> None:
    axis.plot(*thin_curve(result.speed.values, values), label=name, color=color, **look)


def _amplitude(axis: Axes, result: xr.Dataset) -> None:
    (scale, _), (amplitude, axis_label) = printed_unit(result, "amplitude"), printed_values(result, "amplitude")
    axis.set_ylabel(axis_label)
    if _has_configurations(result):
        draw_configurations(axis, result, amplitude)
        _limit(axis, result, scale)
        axis.set_ylim(-_BELOW * axis.get_ylim()[1], None)  # where bodies compensate the line is at zero
        return
    _plot_over_speed(axis, result, amplitude, "axis", COLOURS[0], linewidth=1.4)
    largest = amplitude.max(initial=0.0)
    for i, name in enumerate(map(str, result.direction.values)):
        along = scale * result.displacement_amplitude.values[i]
        if name != "r" and np.abs(along - amplitude).max(initial=0.0) > 1e-6 * largest:
            _plot_over_speed(axis, result, along, name if name == "foundation" else f"carrier {name}", **line_style(i + 1))
    _limit(axis, result, scale)


def _phase(axis: Axes, result: xr.Dataset) -> None:
    """Draw phases from -90 to 270 degrees, so that those in phase or in opposition do not lie on an edge."""
    directions, drawn_lags = list(map(str, result.direction.values)), list[np.ndarray]()
    if _has_configurations(result):
        lags = np.mod(np.degrees(result.lag.values[:, 0]) + 90, 360) - 90
        draw_configurations(axis, result, np.array([without_jumps(lag, 360.0) for lag in lags]))
        top = 190 if np.nanmax(lags, initial=0.0) <= 190 else 270
        axis.set(yticks=[-90, 0, 90, 180, 270], ylim=(-10, top), ylabel=f"phase lag of {directions[0]} (°)")
        return
    for i, lag in enumerate(result.lag.values):  # lags without motion are NaN, and equal to none
        equal = [
            name
            for name, second_lag in zip(directions, result.lag.values, strict=True)
            if np.abs(second_lag - lag).max() < 1e-6
        ]
        if equal[:1] == [directions[i]]:
            drawn_lags.append(np.mod(np.degrees(lag) + 90, 360) - 90)
            appearance = line_style(0 if equal == directions else i + 1)
            axis.plot(result.speed.values, without_jumps(drawn_lags[-1], 360.0), label=" and ".join(equal), **appearance)
    angles = np.concatenate([[0.0], *drawn_lags])
    low, high = -90 if angles.min() < -10 else -10, 270 if angles.max() > 190 else 190
    ticks = [t for t in (-90, 0, 90, 180, 270) if low <= t <= high]
    axis.set(ylim=(low, high), yticks=ticks, ylabel="phase lag (°)")


def _centre(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = printed_unit(result, "centre_distance")
    distance = scale * result.centre_distance.values
    if _has_configurations(result):
        draw_configurations(axis, result, distance)
    else:
        _plot_over_speed(axis, result, distance, "centre of mass", COLOURS[1], linewidth=1.1)
        _plot_over_speed(axis, result, scale * result.amplitude.values, "axis", COLOURS[0], linewidth=0.9, linestyle="--")
    axis.axhline(scale * float(result.eccentricity), color=GREY, linestyle="-.", linewidth=0.8, label="eccentricity")
    axis.set_ylabel(with_unit("distance from rest", unit))
    _limit(axis, result, scale)


def _torque(axis: Axes, result: xr.Dataset) -> None:
    speed, required_torque, losses = result.speed.values, result.required_torque.values, result.loss_torque.values
    has_losses = bool(np.abs(losses).any())
    if has_losses and not _has_configurations(result):
        _plot_over_speed(axis, result, required_torque, "with losses", COLOURS[6], linewidth=1.1, linestyle="--")
    if has_losses:
        _plot_over_speed(axis, result, losses, "loads and bearings", COLOURS[2], linewidth=1.0, linestyle="-.")
    if _has_configurations(result):
        draw_configurations(axis, result, result.vibration_torque.values)
        axis.set_ylabel(with_unit("vibration torque", result.vibration_torque.attrs["units"]))
        return
    _plot_over_speed(axis, result, result.vibration_torque.values, "vibration", COLOURS[0], linewidth=1.1)
    on_bodies = np.abs(result.torque_on_body.values).max(axis=1, initial=0.0)
    visible_bodies = np.flatnonzero(on_bodies > 1e-3 * on_bodies.max())[:_MOST_NAMES]
    for i in visible_bodies if len(on_bodies) > 1 else ():
        name, torque = f"on {result.body.values[i]}", result.torque_on_body.values[i]
        _plot_over_speed(axis, result, torque, name, COLOURS[(i + 1) % 6], linewidth=0.6, linestyle=":")
    free = abs(float(result.free_speed))
    operating_torque = required_torque[speed <= 1.1 * free] if np.isfinite(free) else required_torque
    top = max(float(result.vibration_torque.max()), float(operating_torque.max(initial=0.0)))
    if 0 < 1.5 * top < float(required_torque.max()):
        axis.set_ylim(-0.05 * top, 1.15 * top)  # a fan's load far beyond the speed of the drive would hide all else
    axis.set_ylabel(label(result, "required_torque"))
