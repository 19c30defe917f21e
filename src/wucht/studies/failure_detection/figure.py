"""The figure of a failure: speed, load and stiffness over time, its detection, and the signal at other values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots.scales import name_speeds
from wucht.plots.sheet import draw_panels
from wucht.plots.style import COLOURS, line_style
from wucht.plots.time_courses import draw_mean_and_range
from wucht.results.attributes import text_in
from wucht.results.formatting import abscissa_label, label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_MARKED = 60  # readings drawn with a mark each


def figure(result: xr.Dataset) -> Figure:
    """Draw three or four panels from a failure's Dataset alone."""
    panels = [_speed, _load, *([_alarm] if "seen" in result else []), _signal if "signal" in result else _stiffness]
    return draw_panels(result, panels)[0]


def _mark_failure(axis: Axes, result: xr.Dataset, name: str) -> None:
    """Mark the failure, and name the scale of time."""
    if np.isfinite(at := float(result["failure_time"])):
        axis.axvline(at, color="black", linestyle="--", linewidth=0.9, label="failure")
    axis.set_xlabel(abscissa_label(result, name, "time"))


def _speed(axis: Axes, result: xr.Dataset) -> None:
    s, time = result.wucht.summary, result["reading_time"].values
    axis.set_title("speed measured by the sensor")
    axis.plot(time, result["reading"].values, ".", color=COLOURS[4], markersize=2.5, label="readings, with noise")
    axis.plot(time, result["speed"].values, color=COLOURS[0], linewidth=1.0, label="without noise")
    levels = [x for x in (s["averaged"]["before"], s["averaged"]["after"]) if x is not None]
    for k, level in enumerate(levels):
        axis.axhline(level, **line_style(1) | {"linestyle": ":"}, label=None if k else "averaged equations")
    _mark_failure(axis, result, "reading_time")
    name_speeds(axis, result)


def _load(axis: Axes, result: xr.Dataset) -> None:
    """Draw the range of the load."""
    scale, unit = printed_unit(result, "highest")
    time, high, low = result["reading_time"].values, scale * result["highest"].values, scale * result["lowest"].values
    is_finite = np.isfinite(high) & np.isfinite(low)
    draw_mean_and_range(axis, time[is_finite], None, (low[is_finite], high[is_finite]), color=COLOURS[0])
    _mark_failure(axis, result, "reading_time")
    axis.set(title="load of the specimen", ylabel=with_unit(text_in(result, "signal"), unit))


def _alarm(axis: Axes, result: xr.Dataset) -> None:
    axis.set(title="probability of detection", ylabel="probability", ylim=(0.0, 1.02))
    at, probability = result["alarm_time"].values, result["seen"].values
    last = max(int(np.searchsorted(probability, 0.999)) + 3, 8)
    axis.step(at[:last], probability[:last], where="post", label="alarm of the chart", **line_style(0))
    if last <= _MOST_MARKED:
        axis.plot(at[:last], probability[:last], "o", color=COLOURS[0], markersize=2.5)
    if (mean := result.wucht.summary["delay"]["mean"]) is not None:
        axis.axvline(mean, color=COLOURS[1], linestyle="--", linewidth=1.0, label="on average")
    axis.set_xlabel(label(result, "alarm_time"))


def _stiffness(axis: Axes, result: xr.Dataset) -> None:
    time = result["time"].values
    axis.plot(time, result["stiffness"].values, label="stiffness, share of the initial one", **line_style(0))
    if np.isfinite(result["damage"].values).any():
        axis.plot(time, result["damage"].values, label="damage", **line_style(1))
    _mark_failure(axis, result, "time")
    axis.set(title="stiffness and damage", ylim=(0, None), ylabel="share of the stiffness, damage")


def _signal(axis: Axes, result: xr.Dataset) -> None:
    """Draw the signal over one parameter, or over two as a line for each value of the second."""
    signal, along = result["signal"].values, result["along"].values
    rows = signal[:, None] if signal.ndim == 1 else signal
    for k in range(rows.shape[1]):
        name = "signal" if signal.ndim == 1 else f"{result['second'].attrs['long_name']} = {float(result['second'][k]):.4g}"
        axis.plot(along, rows[:, k], marker="o", markersize=2.5, label=name, **line_style(k))
    _mark_largest(axis, result)
    axis.locator_params(axis="x", nbins=5)
    axis.set(xlabel=label(result, "along"), ylabel="change of speed / standard deviation", ylim=(0, None))
    axis.set_title("signal at the failure")


def _mark_largest(axis: Axes, result: xr.Dataset) -> None:
    """Mark the largest signal, the cliff beside it along the abscissa, and the largest one away from cliffs."""
    s, path = result.wucht.summary, result["along"].attrs["long_name"]
    largest, safe = s.get("largest"), s.get("largest_safe")
    if largest is None:
        return
    axis.plot(largest[path], largest["signal"], "*", color="black", markersize=9, label="largest", zorder=5)
    if (cliff := largest.get("cliff")) is not None and cliff["parameter"] == path:
        side = "below" if cliff["distance"] < 0 else "above"
        name = f"cliff, {100 * abs(cliff['distance']):.2g} % {side} it"
        axis.axvline((cliff["value"] + cliff["inside"]) / 2, color=COLOURS[1], linestyle="--", linewidth=1.0, label=name)
    if safe is not None and safe[path] != largest[path]:
        axis.plot(safe[path], safe["signal"], "D", color=COLOURS[2], markersize=6, label="largest away from it", zorder=5)
