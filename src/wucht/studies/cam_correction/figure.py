"""The figure of a cam's correction: acceleration before and after, speed of the shaft, the cams and their difference."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.cam_drawings import (
    CAM_LOOKS,
    CAM_NAMES,
    FOLLOWER,
    decade_scale,
    draw_bars_from,
    draw_circle,
    draw_limit,
    frame_cam,
    radii_of_curvature,
)
from wucht.plots.page import small
from wucht.plots.scales import power_text, travel_unit, turn_scale
from wucht.plots.sheet import labelled_handles, legend_below, new_grid
from wucht.plots.style import BAR_STYLES, COLOURS, FREE, GREY
from wucht.results.formatting import with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {"counter": COLOURS[2], "outer": COLOURS[4]}  # of the cam itself those of its versions
_FINE = 1e-4  # m: smaller displacements are drawn in micrometres
_LEAST = 1e-6  # of order 1: smaller amplitudes are drawn at this floor
_MOST_BARS = 24  # orders that are drawn, at most
_LEAST_MEASURED, _MOST_MEASURED = 1e-5, 1e-2  # of the largest order: between these the axis begins
_LEFT_OUT = "#BBBBBB"
_RPM = 30 / np.pi
_ROW = 1.8  # inches
_MOST_TICKS = 15


def _draw_table(axis: Axes, result: xr.Dataset, name: str, title: str, per: str = "") -> None:
    """Draw the motion of the output over the cam angle, or a derivative of it."""
    scale, unit = travel_unit(result.output)
    for version, look in CAM_LOOKS.items():
        values = scale * result[name].sel(version=version).values
        axis.plot(np.degrees(result.cam_angle.values), values, linewidth=1.1, **look)
    turn_scale(axis)
    axis.set_ylabel(with_unit(f"{title} in the cam", unit + per))


def _versions(axis: Axes, names: list[str], curve: Callable[[str, str], tuple[np.ndarray, np.ndarray]]) -> None:
    """Draw a curve for each cam and version; the counter cam and the outer flank have separate colours."""
    for name in names:
        for version, look in CAM_LOOKS.items():
            axis.plot(*curve(name, version), linewidth=1.1, **look | {"color": _colour(name, version)})


def _colour(name: str, version: str) -> str:
    return _COLOURS.get(name, str(CAM_LOOKS[version]["color"]))


def _distinct_cams(result: xr.Dataset) -> list[str]:
    """Return the names of the cams, with one flank of a groove, since both flanks move together."""
    return [name for name in result.cam.values.tolist() if name != "outer"]


def _contour(axis: Axes, result: xr.Dataset) -> None:
    closed_indices = np.append(np.arange(result.sizes["cam_angle"]), 0)

    def contour(name: str, version: str) -> tuple[np.ndarray, np.ndarray]:
        of = result.sel(version=version, cam=name)
        return 1e3 * of.contour_x.values[closed_indices], 1e3 * of.contour_y.values[closed_indices]

    for name in result.cam.values.tolist():
        _versions(axis, [name], contour)
        if name != "cam":
            axis.plot([], [], color=_COLOURS[name], linewidth=1.1, label=CAM_NAMES[name])
        else:
            base = 1e3 * float(result.base_radius.sel(version="corrected", cam=name))
            draw_circle(axis, 0, 0, base, linestyle=":", color=GREY, linewidth=0.9, label="base circle")
        _follower(axis, result.sel(cam=name), contour(name, "corrected")[1])
    axis.plot([0], [0], "+", color=GREY)
    frame_cam(axis)


def _follower(axis: Axes, of: xr.Dataset, y: np.ndarray) -> None:
    """Draw the follower at cam angle 0: a roller, or a flat face."""
    x0, y0, r = (1e3 * float(of[name]) for name in ("follower_x", "follower_y", "roller_radius"))
    if np.isfinite(r):
        draw_circle(axis, x0, y0, r, color=FOLLOWER, linewidth=1.2, label="roller")
    else:
        axis.plot([x0, x0], [y.min(), y.max()], color=FOLLOWER, linewidth=1.2, label="face")


def _displacement(axis: Axes, result: xr.Dataset) -> None:
    """Draw the displacement of the contours, which are hard to distinguish to scale."""
    scale, unit = (1e3, "mm") if np.abs(result.moved.values).max() >= _FINE else (1e6, "µm")
    axis.axhline(0, color=GREY, linewidth=0.8)
    for name in _distinct_cams(result):
        values = scale * result.moved.sel(cam=name).values
        axis.plot(np.degrees(result.cam_angle.values), values, color=_colour(name, "corrected"), linewidth=1.1)
    turn_scale(axis)
    axis.set_ylabel(f"moved outwards ({unit})")


def _pressure(axis: Axes, result: xr.Dataset) -> None:
    """Draw the pressure angle; of a flat face, which has none, the motion."""
    if not np.isfinite(result.roller_radius.values).any():
        _draw_table(axis, result, "output", "motion")
        return
    degrees, angles = np.degrees(result.cam_angle.values), np.degrees(result.pressure_angle)
    _versions(axis, _distinct_cams(result), lambda name, version: (degrees, angles.sel(version=version, cam=name).values))
    common = np.degrees(float(result.common_pressure_angle))
    for limit in (common, -common):
        draw_limit(axis, limit, "common limit")
    turn_scale(axis)
    axis.set_ylabel("pressure angle (°)")


def _curvature_radius(axis: Axes, result: xr.Dataset) -> None:
    """Draw the radius of curvature of the contour, except where it is nearly straight."""
    degrees, radii = np.degrees(result.cam_angle.values), radii_of_curvature(result)[0]
    _versions(axis, result.cam.values.tolist(), lambda name, version: (degrees, radii.sel(version=version, cam=name).values))
    axis.axhline(0, color=GREY, linewidth=0.8)
    if (radii < 0).any():
        axis.text(355, 0, "hollow", ha="right", va="top", fontsize=small(), color=GREY)
    turn_scale(axis)
    axis.set_ylabel("radius of curvature (mm)")


def draw_correction(result: xr.Dataset) -> Figure:
    """Draw panels over time and orders, of the cams or of the law, and of a measured acceleration if there is one."""
    cams, has_measurement = bool(result.sizes["cam"]), bool(np.isfinite(result.measured_amplitude.values).any())
    fig, axes = new_grid(2 * (3 + cams + has_measurement), result.attrs["title"], answer_in_print(result), heights=_ROW)
    for panel, axis in zip((_acceleration_history, _spectrum, _speed, _speed_orders), axes, strict=False):
        panel(axis, result)
    if cams:
        for panel, axis in zip((_contour, _displacement, _pressure, _curvature_radius), axes[4:8], strict=True):
            panel(axis, result)
    else:
        _draw_table(axes[4], result, "output", "motion")
        _draw_table(axes[5], result, "output_acceleration", "acceleration", "/rad²")
    if has_measurement:
        _measured_history(axes[-2], result)
        _measured_orders(axes[-1], result)
    legend_below(fig, labelled_handles(axes))
    return fig


def _acceleration_label(result: xr.Dataset, name: str) -> str:
    return with_unit(name, str(result.acceleration.attrs["units"]))


def _acceleration_history(axis: Axes, result: xr.Dataset) -> None:
    for version, look in CAM_LOOKS.items():
        values = result.acceleration.sel(version=version).values
        axis.plot(1e3 * result.time.values, values, linewidth=1.3, label=f"{version} cam", **look)
    _time_axis(axis, result)
    axis.set_ylabel(_acceleration_label(result, "acceleration"))


def _time_axis(axis: Axes, result: xr.Dataset) -> None:
    axis.set(xlim=(0, 1e3 * float(result.time.values[-1])), xlabel="time (ms)")


def _order_axis(axis: Axes, count: int) -> None:
    step = -(-count // _MOST_TICKS)
    axis.set(xlim=(0.3, count + 0.7), xticks=np.arange(step, count + 1, step), xlabel="order", axisbelow=True)


def _spectrum(axis: Axes, result: xr.Dataset) -> None:
    s, reference = result.wucht.summary, result.amplitude.sel(version="corrected")
    floor = _LEAST * float(reference.sel(order=s["reference_order"]))
    result = result.isel(order=slice(_drawn_orders(result, floor)))
    k = result.order.values
    for side, version in zip((-0.2, 0.2), CAM_LOOKS, strict=True):
        values = np.maximum(result.amplitude.sel(version=version).values, floor)
        draw_bars_from(axis, floor / 2, k + side, values, color=CAM_LOOKS[version]["color"], **BAR_STYLES[side < 0])
    if np.isfinite(result.recovered.values).any():
        recovered_amplitudes = np.maximum(
            np.fmax.reduce(result.recovered.values), floor
        )  # NaN for orders that were not computed
        axis.plot(k, recovered_amplitudes, "o", color=COLOURS[6], markersize=3, label="corrected, from its points", zorder=5)
    name = f"{power_text(_LEAST)} of order {s['reference_order']}, or less"
    axis.axhline(floor, color=GREY, linestyle="-.", linewidth=0.8, label=name)
    decade_scale(axis, floor, float(result.amplitude.max()), 3)
    _order_axis(axis, len(k))
    axis.set_ylabel(_acceleration_label(result, "acceleration, amplitude"))


def _drawn_orders(result: xr.Dataset, floor: float) -> int:
    """The number of orders up to the last above a floor, and one more, that its place is seen."""
    above = np.flatnonzero((result.amplitude.values > floor).any(axis=result.amplitude.get_axis_num("version")))
    return int(min(above.max(initial=0) + 2, _MOST_BARS))


def _speed(axis: Axes, result: xr.Dataset) -> None:
    axis.plot(1e3 * result.time.values, _RPM * result.shaft_speed.values, color=COLOURS[0], linewidth=1.3)
    axis.axhline(_RPM * result.wucht.summary["mean_speed"], **FREE, label="mean speed")
    _time_axis(axis, result)
    axis.ticklabel_format(axis="y", useOffset=False)
    axis.set_ylabel("speed of the shaft (rpm)")


def _speed_orders(axis: Axes, result: xr.Dataset) -> None:
    """Draw the orders of the speed that are corrected, and those of a record that are left out."""
    j, errors, left_out_orders = result.speed_order.values, result.speed_error.values, result.left_out_order.values
    frame: dict[str, Any] = {"width": 0.6, "edgecolor": GREY, "linewidth": 0.4, "capsize": 2}
    bars = errors if np.isfinite(errors).any() else None
    axis.bar(j, result.speed_amplitude.values, yerr=bars, color=COLOURS[0], **frame)
    if len(left_out_orders):
        axis.bar(left_out_orders, result.left_out_amplitude.values, color=_LEFT_OUT, **frame, label="left out, in the record")
    _order_axis(axis, max([1, *j, *left_out_orders]))
    axis.set_ylabel("speed, amplitude (rad/s)")


def _measured_history(axis: Axes, result: xr.Dataset) -> None:
    """Draw the measured acceleration beside the computed one, as figures 2 and 4 of 004, with samples of all turns."""
    version, time = result.wucht.summary["measured"]["cam"], 1e3 * result.time.values
    sample_times = time[-1] * result.sample_tau.values / (2 * np.pi)
    dots: dict[str, Any] = {"color": GREY, "marker": ".", "linestyle": "", "markeredgewidth": 0}
    axis.plot(sample_times, result.sample_acceleration.values, markersize=2.2, alpha=0.35, rasterized=True, **dots)
    axis.plot([], [], markersize=6, label="measured, samples", **dots)
    axis.plot(time, result.acceleration.sel(version=version).values, linewidth=2.6, **CAM_LOOKS[version])
    axis.plot(time, result.measured_acceleration.values, color=COLOURS[6], linewidth=0.9, label="measured (orders fitted)")
    _time_axis(axis, result)
    axis.set_ylabel(_acceleration_label(result, "measured"))


def _measured_orders(axis: Axes, result: xr.Dataset) -> None:
    k, colour = result.order.values, CAM_LOOKS[result.wucht.summary["measured"]["cam"]]["color"]
    amplitudes = np.array([result.computed_amplitude.values, result.measured_amplitude.values])
    highest = float(np.nanmax(amplitudes))
    floor = min(max(_LEAST_MEASURED * highest, 0.5 * float(np.nanmin(amplitudes))), _MOST_MEASURED * highest)
    for side, values, of in zip((-0.2, 0.2), amplitudes, (colour, COLOURS[6]), strict=True):
        bars = np.maximum(values, floor)  # NaN stays NaN
        draw_bars_from(axis, floor / 2, k + side, bars, color=of, edgecolor=GREY, linewidth=0.3)
    decade_scale(axis, floor, highest, 1)
    _order_axis(axis, len(k))
    axis.set_ylabel(_acceleration_label(result, "measured, amplitude"))
