"""The panels of the cams before and after: the contours, by how much they differ, and what they are judged by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots.page import small
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

LOOKS = {"original": (COLOURS[1], "--"), "corrected": (COLOURS[0], "-")}
_CAMS = {"counter": (COLOURS[2], "counter cam"), "outer": (COLOURS[4], "outer flank")}
_FOLLOWER = "#000000"
_FINE = 1e-4  # m: less is drawn in micrometres
_CLIPPED = 2.5  # of the largest distance from the centre: larger radii of curvature are not drawn


def draw_contours(axes: list[Axes], result: xr.Dataset) -> None:
    """Four panels: the contours, their difference, the pressure angle (of a flat face the motion), the radius of curvature."""
    _contour(axes[0], result)
    _moved(axes[1], result)
    if np.isfinite(result.roller_radius.values).any():
        _pressure(axes[2], result)
    else:
        draw_table(axes[2], result, "output", "motion")
    _radius(axes[3], result)


def draw_table(axis: Axes, result: xr.Dataset, name: str, called: str, per: str = "") -> None:
    """The motion of the output over the cam angle, or a derivative of it."""
    scale, unit = (np.degrees(1.0), "°") if result.output.attrs["units"] == "rad" else (1e3, "mm")
    for version, (colour, dashes) in LOOKS.items():
        values = scale * result[name].sel(version=version).values
        axis.plot(np.degrees(result.cam_angle.values), values, dashes, color=colour, linewidth=1.1)
    _cam_angle_axis(axis)
    axis.set_ylabel(with_unit(f"{called} in the cam", unit + per))


def _cam_angle_axis(axis: Axes) -> None:
    axis.set_xlim(0, 360)
    axis.set_xticks(np.arange(0, 361, 60))
    axis.set_xlabel("cam angle (°)")


def _contour(axis: Axes, result: xr.Dataset) -> None:
    closed = np.append(np.arange(result.sizes["cam_angle"]), 0)
    turn = np.linspace(0, 2 * np.pi, 181)
    for name in map(str, result.cam.values):
        for version, (_, dashes) in LOOKS.items():
            of = result.sel(version=version, cam=name)
            x, y = (1e3 * of[c].values[closed] for c in ("contour_x", "contour_y"))
            axis.plot(x, y, dashes, color=_colour(name, version), linewidth=1.1)
        base = 1e3 * float(result.base_radius.sel(version="corrected", cam=name))
        if name != "cam":
            axis.plot([], [], color=_CAMS[name][0], linewidth=1.1, label=_CAMS[name][1])
        else:
            axis.plot(base * np.cos(turn), base * np.sin(turn), ":", color=GREY, linewidth=0.9, label="base circle")
        _follower(axis, result.sel(cam=name), turn, y)
    axis.plot([0], [0], "+", color=GREY)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("x (mm), cam at 0°")
    axis.set_ylabel("y (mm)")


def _colour(name: str, version: str) -> str:
    """Of the cam that of the version; the counter cam and the outer flank have their own."""
    return LOOKS[version][0] if name == "cam" else _CAMS[name][0]


def _follower(axis: Axes, of: xr.Dataset, turn: np.ndarray, y: np.ndarray) -> None:
    """At cam angle 0: a roller, or a flat face."""
    x0, y0, r = (1e3 * float(of[name]) for name in ("follower_x", "follower_y", "roller_radius"))
    if np.isfinite(r):
        axis.plot(x0 + r * np.cos(turn), y0 + r * np.sin(turn), color=_FOLLOWER, linewidth=1.2, label="roller")
    else:
        axis.plot([x0, x0], [y.min(), y.max()], color=_FOLLOWER, linewidth=1.2, label="face")


def _moved(axis: Axes, result: xr.Dataset) -> None:
    """To scale the contours can hardly be told apart."""
    scale, unit = (1e3, "mm") if np.abs(result.moved.values).max() >= _FINE else (1e6, "µm")
    axis.axhline(0, color=GREY, linewidth=0.8)
    for name in _once(result):
        values = scale * result.moved.sel(cam=name).values
        axis.plot(np.degrees(result.cam_angle.values), values, color=_colour(name, "corrected"), linewidth=1.1)
    _cam_angle_axis(axis)
    axis.set_ylabel(f"moved outwards ({unit})")


def _once(result: xr.Dataset) -> list[str]:
    """Cams, and of the flanks of a groove, which go together, one."""
    return [name for name in map(str, result.cam.values) if name != "outer"]


def _pressure(axis: Axes, result: xr.Dataset) -> None:
    for name in _once(result):
        for version, (_, dashes) in LOOKS.items():
            angle = np.degrees(result.pressure_angle.sel(version=version, cam=name).values)
            axis.plot(np.degrees(result.cam_angle.values), angle, dashes, color=_colour(name, version), linewidth=1.1)
    common = np.degrees(float(result.common_pressure_angle))
    for limit in (common, -common):
        axis.axhline(limit, color=COLOURS[3], linestyle=":", linewidth=1.2, label="common limit")
    _cam_angle_axis(axis)
    axis.set_ylabel("pressure angle (°)")


def _radius(axis: Axes, result: xr.Dataset) -> None:
    """Of curvature of the contour; none is drawn where it is nearly straight."""
    widest = _CLIPPED * 1e3 * float(np.hypot(result.contour_x.values, result.contour_y.values).max())
    with np.errstate(divide="ignore"):
        radius = 1e3 / result.curvature
    shown = radius.where(np.abs(radius) <= widest)
    for name in map(str, result.cam.values):
        for version, (_, dashes) in LOOKS.items():
            values = shown.sel(version=version, cam=name).values
            axis.plot(np.degrees(result.cam_angle.values), values, dashes, color=_colour(name, version), linewidth=1.1)
    axis.axhline(0, color=GREY, linewidth=0.8)
    if (shown < 0).any():
        axis.text(355, 0, "hollow", ha="right", va="top", fontsize=small(), color=GREY)
    _cam_angle_axis(axis)
    axis.set_ylabel("radius of curvature (mm)")
