"""The figure of a cam's correction: the acceleration before and after, the speed of the shaft, and the contour."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.results import style
from wucht.results.conventions import summary_of
from wucht.results.style import COLOURS, GREY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAMES = {"original": "original cam", "corrected": "corrected cam"}
_LOOKS = {"original": (COLOURS[1], "--"), "corrected": (COLOURS[0], "-")}
_CAMS = {"counter": COLOURS[2], "outer": COLOURS[3]}
_LEAST = 1e-12  # of order 1: what is less is drawn there
_ROW = 2.55  # inches
_MOST_TICKS = 15


def figure(result: xr.Dataset) -> Figure:
    """Panels over time and orders, contour and pressure angle (or the law), and a measured acceleration if there is one."""
    measured = bool(np.isfinite(result.measured_amplitude.values).any())
    rows = 4 if measured else 3
    drawn, axes = style.new_grid(rows, 2, _ROW * rows + 1.2, result.attrs["title"], result.attrs["sentence"])
    _over_time(axes[0], result)
    _spectrum(axes[1], result)
    _speed(axes[2], result)
    _speed_orders(axes[3], result)
    if result.sizes["cam"]:
        _contour(axes[4], result)
        _pressure(axes[5], result)
    else:
        _table(axes[4], result, "output", "motion")
        _table(axes[5], result, "output_acceleration", "acceleration", "/rad²")
    if measured:
        _measured_time(axes[6], result)
        _measured_orders(axes[7], result)
    named = {label: handle for axis in axes for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)}
    drawn.legend(
        list(named.values()), list(named), loc="lower center", ncols=4 if len(named) < 9 else 5, frameon=False, fontsize=8
    )
    return drawn


def _unit(result: xr.Dataset) -> str:
    return str(result.acceleration.attrs["units"]).replace("^2", "²")


def _over_time(axis: Axes, result: xr.Dataset) -> None:
    for version, (colour, dashes) in _LOOKS.items():
        values = result.acceleration.sel(version=version).values
        axis.plot(1e3 * result.time.values, values, dashes, color=colour, linewidth=1.3, label=_NAMES[version])
    _time_axis(axis, result)
    axis.set_ylabel(style.with_unit("acceleration", _unit(result)))


def _time_axis(axis: Axes, result: xr.Dataset) -> None:
    axis.set_xlim(0, 1e3 * float(result.time.values[-1]))
    axis.set_xlabel("time (ms)")


def _order_axis(axis: Axes, count: int) -> None:
    step = -(-count // _MOST_TICKS)
    axis.set_xlim(0.3, count + 0.7)
    axis.set_xticks(np.arange(step, count + 1, step) if step > 1 else np.arange(1, count + 1))
    axis.set_xlabel("order")
    axis.set_axisbelow(True)


def _spectrum(axis: Axes, result: xr.Dataset) -> None:
    k, s = result.order.values, summary_of(result)
    reference = float(result.amplitude.sel(version="corrected", order=s["reference_order"]))
    floor = _LEAST * reference
    for side, version in zip((-0.2, 0.2), _LOOKS, strict=True):
        values = np.maximum(result.amplitude.sel(version=version).values, floor)
        axis.bar(k + side, values - floor / 2, 0.4, bottom=floor / 2, color=_LOOKS[version][0], edgecolor=GREY, linewidth=0.3)
    if np.isfinite(result.recovered.values).any():
        found = np.maximum(np.nanmax(result.recovered.values, axis=0), floor)
        axis.plot(k, found, "o", color=COLOURS[6], markersize=3, label="corrected, from its points", zorder=5)
    axis.axhline(
        floor, color=GREY, linestyle="-.", linewidth=0.8, label=f"{_LEAST:.0e} of order {s['reference_order']}, or less"
    )
    axis.set_yscale("log")
    style.plain_decades(axis.yaxis)
    axis.set_ylim(floor / 2, 3 * float(result.amplitude.max()))
    axis.set_yticks(10.0 ** np.arange(np.ceil(np.log10(floor)), np.log10(3 * float(result.amplitude.max())), 3))
    axis.minorticks_off()
    _order_axis(axis, len(k))
    axis.set_ylabel(style.with_unit("amplitude", _unit(result)))


def _speed(axis: Axes, result: xr.Dataset) -> None:
    rpm = 30 / np.pi
    axis.plot(1e3 * result.time.values, rpm * result.shaft_speed.values, color=COLOURS[0], linewidth=1.3)
    axis.axhline(rpm * summary_of(result)["mean_speed"], color=GREY, linestyle=":", linewidth=0.9, label="mean speed")
    _time_axis(axis, result)
    axis.ticklabel_format(axis="y", useOffset=False)
    axis.set_ylabel("camshaft (rpm)")


def _speed_orders(axis: Axes, result: xr.Dataset) -> None:
    j, errors = result.speed_order.values, result.speed_error.values
    bars = errors if np.isfinite(errors).any() else None
    axis.bar(j, result.speed_amplitude.values, 0.6, color=COLOURS[0], edgecolor=GREY, linewidth=0.4, yerr=bars, capsize=2)
    _order_axis(axis, max(len(j), 1))
    axis.set_ylabel("speed, amplitude (rad/s)")


def _contour(axis: Axes, result: xr.Dataset) -> None:
    closed = np.append(np.arange(result.sizes["cam_angle"]), 0)
    turn = np.linspace(0, 2 * np.pi, 181)
    for name in map(str, result.cam.values):
        for version, (_, dashes) in _LOOKS.items():
            of = result.sel(version=version, cam=name)
            x, y = (1e3 * of[c].values[closed] for c in ("contour_x", "contour_y"))
            axis.plot(x, y, dashes, color=_LOOKS[version][0] if name == "cam" else _CAMS[name], linewidth=1.1)
        base = 1e3 * float(result.base_radius.sel(version="corrected", cam=name))
        if name != "cam":
            axis.plot([], [], color=_CAMS[name], linewidth=1.1, label=f"{name} {'cam' if name == 'counter' else 'flank'}")
        else:
            axis.plot(base * np.cos(turn), base * np.sin(turn), ":", color=GREY, linewidth=0.9, label="base circle")
        _follower(axis, result.sel(cam=name), turn, y)
    axis.plot([0], [0], "+", color=GREY)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("x (mm)")
    axis.set_ylabel("y (mm)")


def _follower(axis: Axes, of: xr.Dataset, turn: np.ndarray, y: np.ndarray) -> None:
    """At cam angle 0: a roller, or a flat face."""
    x0, y0, r = (1e3 * float(of[name]) for name in ("follower_x", "follower_y", "roller_radius"))
    if np.isfinite(r):
        axis.plot(x0 + r * np.cos(turn), y0 + r * np.sin(turn), color=GREY, linewidth=1.2, label="roller")
    else:
        axis.plot([x0, x0], [y.min(), y.max()], color=GREY, linewidth=1.2, label="face")


def _pressure(axis: Axes, result: xr.Dataset) -> None:
    for name in (n for n in map(str, result.cam.values) if n != "outer"):  # the flanks of a groove have one
        for version, (colour, dashes) in _LOOKS.items():
            angle = np.degrees(result.pressure_angle.sel(version=version, cam=name).values)
            shown = colour if name == "cam" else _CAMS[name]
            axis.plot(np.degrees(result.cam_angle.values), angle, dashes, color=shown, linewidth=1.1)
    _cam_angle_axis(axis)
    axis.set_ylabel("pressure angle (°)")


def _table(axis: Axes, result: xr.Dataset, name: str, called: str, per: str = "") -> None:
    scale, unit = (np.degrees(1.0), "°") if result.output.attrs["units"] == "rad" else (1e3, "mm")
    for version, (colour, dashes) in _LOOKS.items():
        values = scale * result[name].sel(version=version).values
        axis.plot(np.degrees(result.cam_angle.values), values, dashes, color=colour, linewidth=1.1)
    _cam_angle_axis(axis)
    axis.set_ylabel(style.with_unit(f"{called} in the cam", unit + per))


def _cam_angle_axis(axis: Axes) -> None:
    axis.set_xlim(0, 360)
    axis.set_xticks(np.arange(0, 361, 60))
    axis.set_xlabel("cam angle (°)")


def _measured_time(axis: Axes, result: xr.Dataset) -> None:
    """As figures 2 and 4 of 004: beside what the cam should make."""
    version = summary_of(result)["measured"]["cam"]
    time = 1e3 * result.time.values
    colour, dashes = _LOOKS[version]
    axis.plot(time, result.acceleration.sel(version=version).values, dashes, color=colour, linewidth=2.6)
    axis.plot(time, result.measured_acceleration.values, color=COLOURS[6], linewidth=0.9, label="measured")
    _time_axis(axis, result)
    axis.set_ylabel(style.with_unit("acceleration", _unit(result)))


def _measured_orders(axis: Axes, result: xr.Dataset) -> None:
    k, colour = result.order.values, _LOOKS[summary_of(result)["measured"]["cam"]][0]
    axis.bar(k - 0.2, result.computed_amplitude.values, 0.4, color=colour, edgecolor=GREY, linewidth=0.3)
    axis.bar(k + 0.2, result.measured_amplitude.values, 0.4, color=COLOURS[6], edgecolor=GREY, linewidth=0.3)
    _order_axis(axis, len(k))
    axis.set_ylabel(style.with_unit("amplitude", _unit(result)))
