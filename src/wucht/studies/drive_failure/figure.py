"""The figure of drives that fail: the speeds of the rotors in each case, the amplitude, and the torques of the drives."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.sheet import draw_panels, leading_clauses, legend_beside
from wucht.plots.style import BAR_STYLES, COLOURS, line_style
from wucht.results.formatting import abscissa_label, label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_CASES = 6  # with a panel of their own
_TOLERANCE, _LONGER, _LEAST, _BEFORE = (
    0.01,
    2.0,
    0.05,
    0.15,
)  # of final values; times that time; shares of the whole, and before
_FAILURE: dict[str, Any] = {"color": "black", "linestyle": "--", "linewidth": 0.9}


def figure(result: xr.Dataset) -> Figure:
    """Draw a panel of speeds for each case, the amplitudes, and the mean torques, from the Dataset alone."""
    if not result.sizes.get("case"):
        return draw_panels(result, [_nothing])[0]
    count = min(result.sizes["case"], _MOST_CASES)
    panels: list[Callable[[Axes, Any], None]] = [partial(_speeds, k) for k in range(count)]
    fig, axes = draw_panels(
        result, [*panels, _amplitudes, _torques], legend_beside, subtitle=leading_clauses(result.attrs["sentence"]),
        columns=1, heights=1.5,
    )  # fmt: skip
    for axis in axes[1:-1]:
        axis.sharex(axes[0])
    axes[0].set_xlim(*_limits(result))
    for axis in axes[:-2]:
        axis.tick_params(labelbottom=False)
    axes[-2].set_xlabel(abscissa_label(result, "time"))
    return fig


def _nothing(axis: Axes, result: xr.Dataset) -> None:
    axis.set(xlabel="time", ylabel="speed")


def _case(result: xr.Dataset, index: int) -> str:
    """The drive that fails, and the configuration before if there are several."""
    row = result.wucht.summary["cases"][index]
    several = len({r["configuration"] for r in result.wucht.summary["cases"]}) > 1
    configuration = f" ({row['configuration']})" if several else ""
    return f"{row['drive']}{configuration}"


def _speeds(index: int, axis: Axes, result: xr.Dataset) -> None:
    """Draw the speed of each rotor, forwards, before and after a failure."""
    case = result.isel(case=index)
    for k, name in enumerate(map(str, result.rotor.values)):
        speed = case.rotor_speed.values[k]
        forwards = np.sign(speed[np.isfinite(speed)][0]) or 1.0
        axis.plot(case.time.values, forwards * speed, label=name, **line_style(k))
    axis.axvline(0.0, label=f"{_case(result, index)} fails", **_FAILURE)
    low, high = axis.get_ylim()
    least = 0.02 * max(abs(low), abs(high))
    if high - low < least:
        axis.set_ylim((low + high - least) / 2, (low + high + least) / 2)
    name_speeds(axis, result, "rotor_speed")


def _amplitudes(axis: Axes, result: xr.Dataset) -> None:
    values, name = printed_values(result, "amplitude")
    for k in range(result.sizes["case"]):
        axis.plot(result.time.values[k], values[k], label=f"{_case(result, k)} fails", **line_style(k + 2))
    axis.axvline(0.0, **_FAILURE)
    axis.set(ylabel=name, ylim=(0, None))


def _torques(axis: Axes, result: xr.Dataset) -> None:
    """Draw the magnitude of each drive's mean torque before and after each failure, as bars."""
    before, after = np.abs(result.operation_torque.values), np.abs(result.drive_torque.values)
    cases, drives = after.shape
    places = (np.arange(cases)[:, None] * (drives + 0.5) + np.arange(drives)).ravel()
    for side, (torques, name) in enumerate(((before, "before the failure"), (after, "after it"))):
        axis.bar(places + 0.4 * side - 0.2, torques.ravel(), 0.4, color=COLOURS[4 * (1 - side)], label=name, **BAR_STYLES[side])
    names = [f"{drive}\nif {_case(result, k)}\nfails" for k in range(cases) for drive in map(str, result.drive.values)]
    axis.set_xticks(places, names)
    axis.set(xlabel="drive", ylabel=label(result, "drive_torque"))


def _limits(result: xr.Dataset) -> tuple[float, float]:
    """The part of the time in which something happens."""
    last, end = 0.0, float(np.nanmax(result.time.values))
    for k in range(result.sizes["case"]):
        time, rows = result.time.values[k], [*result.rotor_speed.values[k], result.amplitude.values[k]]
        for values in rows:
            inside = np.isfinite(values)
            size = np.abs(values[inside]).max(initial=0.0)
            moving = np.abs(values[inside] - values[inside][-1]) > _TOLERANCE * size
            last = max(last, float(time[inside][moving].max(initial=0.0)))
    right = min(end, max(_LONGER * last, _LEAST * end))
    return max(float(np.nanmin(result.time.values)), -_BEFORE * right), right
