"""The figure of a cam's correction: the acceleration before and after, the speed of the shaft, and the cams."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wucht.plots.cam_drawings import draw_bars_from
from wucht.plots.scales import plain_decades
from wucht.plots.sheet import legend_below, named_in, new_grid
from wucht.plots.style import COLOURS, FREE, GREY, HATCHED
from wucht.results.formatting import with_unit
from wucht.studies.cam_correction.figure_of_contours import LOOKS, draw_contours, draw_table

_NAMES = {"original": "original cam", "corrected": "corrected cam"}
_LEAST = 1e-12  # of order 1: what is less is drawn there
_LEAST_MEASURED, _MOST_MEASURED = 1e-5, 1e-2  # of the largest order: between these the axis begins
_LEFT_OUT = "#BBBBBB"
_RPM = 30 / np.pi
_ROW = 1.8  # inches
_MOST_TICKS = 15


def figure(result: xr.Dataset) -> Figure:
    """Panels over time and orders, of the cams or of the law, and of a measured acceleration if there is one."""
    cams, measured = bool(result.sizes["cam"]), bool(np.isfinite(result.measured_amplitude.values).any())
    drawn, axes = new_grid(2 * (3 + cams + measured), result.attrs["title"], result.attrs["sentence"], heights=_ROW)
    for panel, axis in zip((_over_time, _spectrum, _speed, _speed_orders), axes, strict=False):
        panel(axis, result)
    if cams:
        draw_contours(axes[4:8], result)
    else:
        draw_table(axes[4], result, "output", "motion")
        draw_table(axes[5], result, "output_acceleration", "acceleration", "/rad²")
    if measured:
        _measured_time(axes[-2], result)
        _measured_orders(axes[-1], result)
    legend_below(drawn, named_in(axes))
    return drawn


def _accelerations(result: xr.Dataset, name: str) -> str:
    return with_unit(name, str(result.acceleration.attrs["units"]))


def _over_time(axis: Axes, result: xr.Dataset) -> None:
    for version, look in LOOKS.items():
        values = result.acceleration.sel(version=version).values
        axis.plot(1e3 * result.time.values, values, linewidth=1.3, label=_NAMES[version], **look)
    _time_axis(axis, result)
    axis.set_ylabel(_accelerations(result, "acceleration"))


def _time_axis(axis: Axes, result: xr.Dataset) -> None:
    axis.set(xlim=(0, 1e3 * float(result.time.values[-1])), xlabel="time (ms)")


def _order_axis(axis: Axes, count: int) -> None:
    step = -(-count // _MOST_TICKS)
    axis.set(xlim=(0.3, count + 0.7), xticks=np.arange(step, count + 1, step), xlabel="order", axisbelow=True)


def _spectrum(axis: Axes, result: xr.Dataset) -> None:
    k, s = result.order.values, result.wucht.summary
    floor = _LEAST * float(result.amplitude.sel(version="corrected", order=s["reference_order"]))
    for side, version in zip((-0.2, 0.2), LOOKS, strict=True):
        values = np.maximum(result.amplitude.sel(version=version).values, floor)
        draw_bars_from(axis, floor / 2, k + side, values, color=LOOKS[version]["color"], **HATCHED[side < 0])
    if np.isfinite(result.recovered.values).any():
        recovered = np.maximum(np.fmax.reduce(result.recovered.values), floor)  # NaN where an order was not looked for
        axis.plot(k, recovered, "o", color=COLOURS[6], markersize=3, label="corrected, from its points", zorder=5)
    name = f"{_LEAST:.0e} of order {s['reference_order']}, or less"
    axis.axhline(floor, color=GREY, linestyle="-.", linewidth=0.8, label=name)
    _decades(axis, floor, float(result.amplitude.max()), 3)
    _order_axis(axis, len(k))
    axis.set_ylabel(_accelerations(result, "acceleration, amplitude"))


def _decades(axis: Axes, floor: float, highest: float, step: int) -> None:
    """A logarithmic axis from below a floor, with a tick every so many decades."""
    axis.set_yscale("log")
    plain_decades(axis.yaxis)
    axis.set_ylim(floor / 2, 3 * highest)
    axis.set_yticks(10.0 ** np.arange(np.ceil(np.log10(floor)), np.log10(3 * highest), step))
    axis.minorticks_off()


def _speed(axis: Axes, result: xr.Dataset) -> None:
    axis.plot(1e3 * result.time.values, _RPM * result.shaft_speed.values, color=COLOURS[0], linewidth=1.3)
    axis.axhline(_RPM * result.wucht.summary["mean_speed"], **FREE, label="mean speed")
    _time_axis(axis, result)
    axis.ticklabel_format(axis="y", useOffset=False)
    axis.set_ylabel("speed of the shaft (rpm)")


def _speed_orders(axis: Axes, result: xr.Dataset) -> None:
    """Those that are corrected for, and those of a record that are not."""
    j, errors, others = result.speed_order.values, result.speed_error.values, result.left_out_order.values
    frame: dict[str, Any] = {"width": 0.6, "edgecolor": GREY, "linewidth": 0.4, "capsize": 2}
    bars = errors if np.isfinite(errors).any() else None
    axis.bar(j, result.speed_amplitude.values, yerr=bars, color=COLOURS[0], **frame)
    if len(others):
        axis.bar(others, result.left_out_amplitude.values, color=_LEFT_OUT, **frame, label="left out, in the record")
    _order_axis(axis, max([1, *j, *others]))
    axis.set_ylabel("speed, amplitude (rad/s)")


def _measured_time(axis: Axes, result: xr.Dataset) -> None:
    """As figures 2 and 4 of 004: beside what the cam should make. The samples are those of all turns."""
    version, time = result.wucht.summary["measured"]["cam"], 1e3 * result.time.values
    sampled = time[-1] * result.sample_tau.values / (2 * np.pi)
    dots: dict[str, Any] = {"color": GREY, "marker": ".", "linestyle": "", "markeredgewidth": 0}
    axis.plot(sampled, result.sample_acceleration.values, markersize=2.2, alpha=0.35, rasterized=True, **dots)
    axis.plot([], [], markersize=6, label="measured, samples", **dots)
    axis.plot(time, result.acceleration.sel(version=version).values, linewidth=2.6, **LOOKS[version])
    axis.plot(time, result.measured_acceleration.values, color=COLOURS[6], linewidth=0.9, label="measured (orders fitted)")
    _time_axis(axis, result)
    axis.set_ylabel(_accelerations(result, "measured"))


def _measured_orders(axis: Axes, result: xr.Dataset) -> None:
    k, colour = result.order.values, LOOKS[result.wucht.summary["measured"]["cam"]]["color"]
    both = np.array([result.computed_amplitude.values, result.measured_amplitude.values])
    highest = float(np.nanmax(both))
    floor = min(max(_LEAST_MEASURED * highest, 0.5 * float(np.nanmin(both))), _MOST_MEASURED * highest)
    for side, values, of in zip((-0.2, 0.2), both, (colour, COLOURS[6]), strict=True):
        shown = np.maximum(values, floor)  # what there is not stays so
        draw_bars_from(axis, floor / 2, k + side, shown, color=of, edgecolor=GREY, linewidth=0.3)
    _decades(axis, floor, highest, 1)
    _order_axis(axis, len(k))
    axis.set_ylabel(_accelerations(result, "measured, amplitude"))
