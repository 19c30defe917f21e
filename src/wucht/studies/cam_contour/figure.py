"""The figure of a cam's contour: the cam to scale with its follower, and below it what it is judged by over the cam angle."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wucht.plots.cam_drawings import radii_of_curvature
from wucht.plots.page import small
from wucht.plots.scales import travel_unit, turn_scale
from wucht.plots.sheet import draw_panels, legend_below, named_in
from wucht.plots.style import COLOURS, GREY, line_style
from wucht.results.formatting import label
from wucht.studies.cam_contour.figure_of_cam import draw_cam, is_missing

_ROW, _CAM = 1.5, 4.0  # inches
_LINE = {"cam": 0, "counter": 1, "outer": 2}
_NAMED = {"cam": "cam", "counter": "counter cam", "outer": "outer flank"}


def figure(result: xr.Dataset) -> Figure:
    """The cam above; below it two panels a row: radius of curvature, pressure angle, and what else there is to show."""
    panels = [_radius, _motion if np.isfinite(float(result.face_at)) else _pressure_angle]
    if np.isfinite(result.transmission_angle.values).any():
        panels.append(_transmission)
    if (result.contact_force.values > 0).any():
        panels += [_force, _pressure, _torque] if np.isfinite(result.contact_pressure.values).any() else [_force, _torque]
    if len(panels) % 2:
        panels.append(_touched if _motion in panels else _motion)
    drawn, axes = draw_panels(result, [draw_cam, *panels], None, heights=(_CAM, _ROW), wide=1)
    for axis in axes[1:]:
        turn_scale(axis)
    legend_below(drawn, named_in(axes))
    return drawn


def _lines(axis: Axes, result: xr.Dataset, values: np.ndarray) -> None:
    """Of each cam a line, with its name where there are several."""
    for name, row in zip(map(str, result.cam.values), values, strict=True):
        if np.isfinite(row).any():
            _line(axis, result, row, _LINE[name], _NAMED[name] if len(values) > 1 else None)


def _line(axis: Axes, result: xr.Dataset, values: np.ndarray, look: int = 4, name: str | None = None) -> None:
    axis.plot(np.degrees(result.cam_angle.values), values, label=name, **line_style(look))


def _limit(axis: Axes, value: float, name: str, colour: str = COLOURS[3]) -> None:
    if np.isfinite(value):
        axis.axhline(value, color=colour, linestyle=":", linewidth=1.2, label=name)


def _radius(axis: Axes, result: xr.Dataset) -> None:
    """Of curvature of the contour; none is drawn where it is nearly straight, or cut away."""
    radii, widest = radii_of_curvature(result)
    cut = np.array([is_missing(result, name) for name in map(str, result.cam.values)])
    shown = np.where(cut, np.nan, radii.values)
    _lines(axis, result, shown)
    _bands(axis, result, "missing", "cut away", COLOURS[3])
    _limit(axis, 1e3 * float(result.permitted_radius), "permitted")
    _limit(axis, -1e3 * float(result.wheel_radius), "grinding wheel", COLOURS[5])
    axis.axhline(0, color=GREY, linewidth=0.8)
    low = min(0.0, float(np.nanmin(shown, initial=0.0)), -1e3 * float(np.nan_to_num(result.wheel_radius)))
    high = float(np.nanmax(shown, initial=0.05 * widest))
    axis.set(ylim=(1.1 * low - 0.03 * widest, 1.1 * high), ylabel="radius of curvature (mm)")
    if low < 0:
        # Beside the panel: in it the word would lie under a curve.
        axis.text(1.01, 0.0, "hollow", transform=axis.transAxes, rotation=90, va="bottom", fontsize=small(), color=GREY)


def _pressure_angle(axis: Axes, result: xr.Dataset) -> None:
    angles = np.degrees(result.pressure_angle.values)
    _lines(axis, result, np.where(result.cam.values[:, None] == "outer", np.nan, angles))  # one roller has one
    limit, name = np.degrees(float(result.permitted_pressure_angle)), "permitted"
    if not np.isfinite(limit):
        limit, name = np.degrees(float(result.common_pressure_angle)), "common limit"
    for sign in (1, -1):
        _limit(axis, sign * limit, name)
    axis.set_ylabel("pressure angle (°)")


def _transmission(axis: Axes, result: xr.Dataset) -> None:
    _line(axis, result, np.degrees(result.transmission_angle.values))
    axis.set(ylim=(0, 92), ylabel="transmission angle (°)")


def _force(axis: Axes, result: xr.Dataset) -> None:
    _lines(axis, result, result.contact_force.values)
    if "outer" not in result.cam.values:
        _bands(axis, result, "lift-off", "lifts off", COLOURS[1])
    axis.set(ylim=(0, None), ylabel=label(result, "contact_force"))


def _bands(axis: Axes, result: xr.Dataset, what: str, name: str, colour: str) -> None:
    """A band over each arc of the cam angle on which something happens, and where it comes again a turn earlier."""
    for i in np.flatnonzero(result.arc_of.values == what).tolist():
        for turn in (0.0, -360.0):
            low, high = np.clip(np.degrees([float(result.arc_begin[i]), float(result.arc_end[i])]) + turn, 0, 360)
            if high > low:
                axis.axvspan(low, high, color=colour, alpha=0.15, linewidth=0, label=name)


def _torque(axis: Axes, result: xr.Dataset) -> None:
    _line(axis, result, result.camshaft_torque.values)
    axis.set_ylabel(label(result, "camshaft_torque"))


def _pressure(axis: Axes, result: xr.Dataset) -> None:
    _lines(axis, result, 1e-6 * result.contact_pressure.values)
    _limit(axis, 1e-6 * float(result.permitted_contact_pressure), "permitted")
    axis.set(ylim=(0, None), ylabel="contact pressure (MPa)")


def _touched(axis: Axes, result: xr.Dataset) -> None:
    """Where a flat face is touched: as far from the rod's axis as its velocity by the cam angle says."""
    _line(axis, result, (1e3 if result.wucht.summary["clockwise"] else -1e3) * result.follower_velocity.values)
    axis.set_ylabel("face touched at y (mm)")


def _motion(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = travel_unit(result.follower)
    _line(axis, result, scale * result.follower.values)
    axis.set_ylabel(f"motion of the {'lever' if unit == '°' else 'follower'} ({unit})")
