"""The figure of a response: amplitude, phase, centre of mass and torque over the speed, as 002 figures 2.17 to 2.19."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.results.speed_axis import finish_panels
from wucht.results.style import COLOURS, GREY, label, line_style, new_figure, thinned, without_jumps

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_NAMES = 7  # bodies named one by one in a legend
_CLIPPED = 30.0  # an infinite amplitude is cut at this many times that at the end of the range


def figure(result: xr.Dataset) -> Figure:
    """Four panels (three where there is no centre of mass in the plane) from a response's Dataset alone."""
    with_centre = bool(np.isfinite(result.centre_distance.values).any()) and float(result.eccentricity) > 0
    drawn, axes = new_figure(
        4 if with_centre else 3, 8.2 if with_centre else 6.4, result.attrs["title"], result.attrs["sentence"]
    )
    panels = iter(axes)
    _amplitude(next(panels), result)
    _phase(next(panels), result)
    if with_centre:
        _centre(next(panels), result)
    _torque(next(panels), result)
    free = abs(float(result.free_speed))
    finish_panels(axes, result, ("critical speed", "critical speeds"), (free, "speed of the drive"), 0)
    return drawn


def _scale(result: xr.Dataset, name: str) -> tuple[float, str]:
    unit = str(result[name].attrs["units"])
    return (1e3, "mm") if unit == "m" else (1.0, unit)


def _limit(axis: Axes, result: xr.Dataset, scale: float) -> None:
    """From zero up to the largest value that is finite at a resonance."""
    amplitude = scale * result.amplitude.values
    if np.isinf(result.peak_amplitude.values).any():
        finite = scale * result.peak_amplitude.values[np.isfinite(result.peak_amplitude.values)]
        axis.set_ylim(0, 1.1 * max([*finite, _CLIPPED * float(np.median(amplitude)) / 4]))
    else:
        axis.set_ylim(bottom=0)


def _amplitude(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = _scale(result, "amplitude")
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
    drawn: list[np.ndarray] = []
    for i, name in enumerate(map(str, result.direction.values)):
        lag = np.mod(np.degrees(result.lag.values[i]) + 90, 360) - 90
        if np.isnan(lag).all() or any(np.abs(lag - other).max() < 1e-6 for other in drawn):
            continue
        drawn.append(lag)
        together = [
            str(n) for n, other in zip(result.direction.values, result.lag.values, strict=True)
            if np.abs(other - result.lag.values[i]).max() < 1e-6
        ]  # fmt: skip
        style = line_style(0 if len(together) == result.sizes["direction"] else i + 1)
        axis.plot(result.speed.values, without_jumps(lag, 360.0), label=" and ".join(together) or name, **style)
    least = min((float(np.nanmin(x)) for x in drawn), default=0.0)
    most = max((float(np.nanmax(x)) for x in drawn), default=180.0)
    axis.set_ylim(-90 if least < -10 else -10, 270 if most > 190 else 190)
    axis.set_yticks([t for t in (-90, 0, 90, 180, 270) if axis.get_ylim()[0] <= t <= axis.get_ylim()[1]])
    axis.set_ylabel("phase lag (°)")


def _centre(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = _scale(result, "centre_distance")
    speed = result.speed.values
    axis.plot(*thinned(speed, scale * result.centre_distance.values), color=COLOURS[1], linewidth=1.1, label="centre of mass")
    axis.plot(*thinned(speed, scale * result.amplitude.values), color=COLOURS[0], linewidth=0.9, linestyle="--", label="axis")
    axis.axhline(scale * float(result.eccentricity), color=GREY, linestyle="-.", linewidth=0.8, label="eccentricity")
    axis.set_ylabel(f"distance from rest ({unit})" if unit else "distance from rest")
    _limit(axis, result, scale)


def _torque(axis: Axes, result: xr.Dataset) -> None:
    speed, required = result.speed.values, result.required_torque.values
    losses = result.loss_torque.values
    if np.abs(losses).any():
        axis.plot(*thinned(speed, required), color=COLOURS[6], linewidth=1.1, linestyle="--", label="with losses")
        axis.plot(*thinned(speed, losses), color=COLOURS[2], linewidth=1.0, linestyle="-.", label="loads and bearings")
    axis.plot(*thinned(speed, result.vibration_torque.values), color=COLOURS[0], linewidth=1.1, label="vibration")
    bodies, shown = list(map(str, result.body.values)), 0
    largest = np.abs(result.torque_on_body.values).max(initial=0.0)
    for i, on in enumerate(result.torque_on_body.values if len(bodies) > 1 else ()):
        if np.abs(on).max(initial=0.0) > 1e-3 * largest and shown < _MOST_NAMES:
            axis.plot(*thinned(speed, on), linewidth=0.6, color=COLOURS[(i + 1) % 6], linestyle=":", label=f"on {bodies[i]}")
            shown += 1
    free = abs(float(result.free_speed))
    used = required[speed <= 1.1 * free] if np.isfinite(free) else required
    top = max(float(result.vibration_torque.max()), float(used.max(initial=0.0)))
    if 0 < 1.5 * top < float(required.max()):
        axis.set_ylim(-0.05 * top, 1.15 * top)  # a fan's load far beyond the speed of the drive would hide all else
    axis.set_ylabel(label(result, "required_torque"))
