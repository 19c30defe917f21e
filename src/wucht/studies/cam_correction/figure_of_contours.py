"""The panels of the cams before and after: the contours, by how much they differ, and what they are judged by."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wucht.plots.cam_drawings import FOLLOWER, draw_circle, frame_cam, radii_of_curvature
from wucht.plots.page import small
from wucht.plots.scales import travel_unit, turn_scale
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import with_unit

LOOKS: dict[str, dict[str, Any]] = {
    "original": {"color": COLOURS[1], "linestyle": "--"},
    "corrected": {"color": COLOURS[0], "linestyle": "-"},
}
_CAMS = {"counter": (COLOURS[2], "counter cam"), "outer": (COLOURS[4], "outer flank")}
_FINE = 1e-4  # m: less is drawn in micrometres


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
    scale, unit = travel_unit(result.output)
    for version, look in LOOKS.items():
        values = scale * result[name].sel(version=version).values
        axis.plot(np.degrees(result.cam_angle.values), values, linewidth=1.1, **look)
    turn_scale(axis)
    axis.set_ylabel(with_unit(f"{called} in the cam", unit + per))


def _versions(axis: Axes, names: list[str], curve: Callable[[str, str], tuple[np.ndarray, np.ndarray]]) -> None:
    """Of each cam and each version of it a curve; the counter cam and the outer flank have colours of their own."""
    for name in names:
        for version, look in LOOKS.items():
            axis.plot(*curve(name, version), linewidth=1.1, **look | {"color": _colour(name, version)})


def _colour(name: str, version: str) -> str:
    return str(LOOKS[version]["color"]) if name == "cam" else _CAMS[name][0]


def _all(result: xr.Dataset) -> list[str]:
    return list(map(str, result.cam.values))


def _once(result: xr.Dataset) -> list[str]:
    """Cams, and of the flanks of a groove, which go together, one."""
    return [name for name in _all(result) if name != "outer"]


def _contour(axis: Axes, result: xr.Dataset) -> None:
    closed = np.append(np.arange(result.sizes["cam_angle"]), 0)

    def contour(name: str, version: str) -> tuple[np.ndarray, np.ndarray]:
        of = result.sel(version=version, cam=name)
        return 1e3 * of.contour_x.values[closed], 1e3 * of.contour_y.values[closed]

    for name in _all(result):
        _versions(axis, [name], contour)
        if name != "cam":
            axis.plot([], [], color=_CAMS[name][0], linewidth=1.1, label=_CAMS[name][1])
        else:
            base = 1e3 * float(result.base_radius.sel(version="corrected", cam=name))
            draw_circle(axis, 0, 0, base, linestyle=":", color=GREY, linewidth=0.9, label="base circle")
        _follower(axis, result.sel(cam=name), contour(name, "corrected")[1])
    axis.plot([0], [0], "+", color=GREY)
    frame_cam(axis)


def _follower(axis: Axes, of: xr.Dataset, y: np.ndarray) -> None:
    """At cam angle 0: a roller, or a flat face."""
    x0, y0, r = (1e3 * float(of[name]) for name in ("follower_x", "follower_y", "roller_radius"))
    if np.isfinite(r):
        draw_circle(axis, x0, y0, r, color=FOLLOWER, linewidth=1.2, label="roller")
    else:
        axis.plot([x0, x0], [y.min(), y.max()], color=FOLLOWER, linewidth=1.2, label="face")


def _moved(axis: Axes, result: xr.Dataset) -> None:
    """To scale the contours can hardly be told apart."""
    scale, unit = (1e3, "mm") if np.abs(result.moved.values).max() >= _FINE else (1e6, "µm")
    axis.axhline(0, color=GREY, linewidth=0.8)
    for name in _once(result):
        values = scale * result.moved.sel(cam=name).values
        axis.plot(np.degrees(result.cam_angle.values), values, color=_colour(name, "corrected"), linewidth=1.1)
    turn_scale(axis)
    axis.set_ylabel(f"moved outwards ({unit})")


def _pressure(axis: Axes, result: xr.Dataset) -> None:
    degrees, angles = np.degrees(result.cam_angle.values), np.degrees(result.pressure_angle)
    _versions(axis, _once(result), lambda name, version: (degrees, angles.sel(version=version, cam=name).values))
    common = np.degrees(float(result.common_pressure_angle))
    for limit in (common, -common):
        axis.axhline(limit, color=COLOURS[3], linestyle=":", linewidth=1.2, label="common limit")
    turn_scale(axis)
    axis.set_ylabel("pressure angle (°)")


def _radius(axis: Axes, result: xr.Dataset) -> None:
    """Of curvature of the contour; none is drawn where it is nearly straight."""
    degrees, shown = np.degrees(result.cam_angle.values), radii_of_curvature(result)[0]
    _versions(axis, _all(result), lambda name, version: (degrees, shown.sel(version=version, cam=name).values))
    axis.axhline(0, color=GREY, linewidth=0.8)
    if (shown < 0).any():
        axis.text(355, 0, "hollow", ha="right", va="top", fontsize=small(), color=GREY)
    turn_scale(axis)
    axis.set_ylabel("radius of curvature (mm)")
