"""The figure of a voltage dip: speed and vibration at the critical duration, and the end of all dips over their duration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.several_runs import draw_runs
from wucht.plots.sheet import draw_panels
from wucht.plots.stability_lines import draw_classes
from wucht.plots.style import COLOURS, FREE, GREY, line_style
from wucht.results.formatting import abscissa_label, label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BELOW = 0.04  # of the largest speed: room for marks at standstill
_FALL = (0, (6, 1, 1, 1, 1, 1))  # dashes that no other line has
_MANY = 4  # times the end of the shortest course: longer ones are cut off


def figure(result: xr.Dataset) -> Figure:
    """Draw two panels (three if the carrier moves) from a voltage dip's Dataset alone."""
    moves = bool(np.nanmax(result.amplitude.values, initial=0.0) > 0)
    panels = [_speed, *([_amplitude] if moves else []), *([_ends] if result.sizes["dip"] else [])]
    return draw_panels(result, panels, columns=1)[0]


def _courses(result: xr.Dataset) -> list[tuple[int, dict[str, Any]]]:
    """Return the courses in order, each with its style and name."""
    unit = result.time.attrs["units"]
    pairs = zip(result.course.values, result.course_duration.values, strict=True)
    names = [f"{name}: {duration:.4g} {unit}".rstrip() if np.isfinite(duration) else str(name) for name, duration in pairs]
    return [(k, line_style(k) | {"label": name}) for k, name in enumerate(names)]


def _limit_time(axis: Axes, result: xr.Dataset) -> None:
    """Set the range of the time, with all dips, and mark where the voltage falls and returns."""
    ends = np.nanmax(result.time.values, axis=1)
    until = np.nanmax(result.course_duration.values, initial=0.0)
    last = float(max(min(ends.max(), _MANY * ends.min()), 1.1 * until))
    if (first := float(np.nanmin(result.time.values))) < last:
        axis.set_xlim(first, last)
    axis.axvline(0.0, color=GREY, linestyle=_FALL, linewidth=0.9, label="the voltage falls")
    for k, duration in enumerate(np.unique(result.course_duration.values[np.isfinite(result.course_duration.values)])):
        axis.axvline(duration, color=GREY, linestyle=":", linewidth=0.9, label=None if k else "the voltage is back")
    axis.set_xlabel(abscissa_label(result, "time"))


def _speed(axis: Axes, result: xr.Dataset) -> None:
    for k, style in _courses(result):
        for i, _ in enumerate(result.rotor.values):
            look = style | ({"label": None, "linewidth": 0.6} if i else {})
            axis.plot(result.time[k], result.speed[k, i], **look)
    axis.axhline(result.wucht.summary["operating_speed"], **FREE, label="in operation")
    axis.set_ylim(0, None)
    several = result.sizes["rotor"] > 1
    axis.set_title(f"speed of {result.rotor.values[0]}, thin: of the other rotors" if several else "speed")
    _limit_time(axis, result)
    name_speeds(axis, result)


def _amplitude(axis: Axes, result: xr.Dataset) -> None:
    values, name = printed_values(result, "amplitude")
    draw_runs(axis, result.time.values, values, [style for _, style in _courses(result)])
    axis.set(title="vibration", ylabel=name, ylim=(0, None))
    _limit_time(axis, result)


def _ends(axis: Axes, result: xr.Dataset) -> None:
    """Draw the speed at the end, and when the voltage returns, over the duration of the dips."""
    duration, speed, returns = result.dip_duration.values, result.dip_speed.values, result.dip_returns.values > 0
    axis.plot(duration, result.dip_speed_at_recovery, color=GREY, linewidth=0.9, marker=".", label="when the voltage returns")
    classes = ((returns, "o", COLOURS[0], "at the end, returned"), (~returns, "X", COLOURS[1], "at the end, not returned"))
    draw_classes(axis, duration, speed, classes, color=GREY, markersize=6, markeredgewidth=0.5, linestyle="none")
    if (critical := result.wucht.summary["critical_duration"]) is not None:
        axis.axvline(critical, color="black", linestyle="--", linewidth=1.0, label="critical duration")
    axis.set(
        title="dips that were tried",
        xlim=(0, None),
        ylim=(-_BELOW * float(np.nanmax(speed)), None),
        xlabel=label(result, "dip_duration"),
    )
    name_speeds(axis, result, "dip_speed")
