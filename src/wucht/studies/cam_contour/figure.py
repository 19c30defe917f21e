"""The figure of a cam's contour: the cam to scale with its follower, and below it what it is judged by over the cam angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.page import small
from wucht.plots.style import COLOURS, GREY
from wucht.results.conventions import summary_of
from wucht.results.formatting import label
from wucht.studies.cam_contour.figure_of_cam import draw_cam, is_missing

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW, _CAM = 1.5, 4.0  # inches
_CLIPPED = 2.5  # of the largest distance from the centre: larger radii of curvature are not drawn
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
    drawn, (above, *axes) = sheet.new_grid(
        1 + len(panels), result.attrs["title"], result.attrs["sentence"], heights=(_CAM, _ROW), wide=1
    )
    draw_cam(above, result)
    for panel, axis in zip(panels, axes, strict=True):
        panel(axis, result)
        axis.set_xlim(0, 360)
        axis.set_xticks(np.arange(0, 361, 60))
        axis.set_xlabel("cam angle (°)")
    sheet.legend_below(drawn, sheet.named_in([above, *axes]))
    return drawn


def _lines(axis: Axes, result: xr.Dataset, values: np.ndarray) -> None:
    """Of each cam a line, with its name where there are several."""
    phi = np.degrees(result.cam_angle.values)
    for name, row in zip(map(str, result.cam.values), values, strict=True):
        if np.isfinite(row).any():
            axis.plot(phi, row, label=_NAMED[name] if len(values) > 1 else None, **style.line_style(_LINE[name]))


def _limit(axis: Axes, value: float, name: str, colour: str = COLOURS[3]) -> None:
    if np.isfinite(value):
        axis.axhline(value, color=colour, linestyle=":", linewidth=1.2, label=name)


def _radius(axis: Axes, result: xr.Dataset) -> None:
    """Of curvature of the contour; none is drawn where it is nearly straight, or cut away."""
    widest = _CLIPPED * 1e3 * float(np.hypot(result.contour_x.values, result.contour_y.values).max())
    with np.errstate(divide="ignore"):
        radius = 1e3 / result.curvature.values
    cut = np.array([is_missing(result, name) for name in map(str, result.cam.values)])
    shown = np.where((np.abs(radius) <= widest) & ~cut, radius, np.nan)
    _lines(axis, result, shown)
    _bands(axis, result, "missing", "cut away", COLOURS[3])
    _limit(axis, 1e3 * float(result.permitted_radius), "permitted")
    _limit(axis, -1e3 * float(result.wheel_radius), "grinding wheel", COLOURS[5])
    axis.axhline(0, color=GREY, linewidth=0.8)
    low = min(0.0, float(np.nanmin(shown, initial=0.0)), -1e3 * float(np.nan_to_num(result.wheel_radius)))
    high = float(np.nanmax(shown, initial=0.05 * widest))
    axis.set_ylim(1.1 * low - 0.03 * widest, 1.1 * high)
    axis.set_ylabel("radius of curvature (mm)")
    if low < 0:
        # Beside the panel: in it the word would lie under a curve.
        axis.text(1.01, 0.0, "hollow", transform=axis.transAxes, rotation=90, va="bottom", fontsize=small(), color=GREY)


def _pressure_angle(axis: Axes, result: xr.Dataset) -> None:
    angles = np.degrees(result.pressure_angle.values)
    _lines(axis, result, np.where(result.cam.values[:, None] == "outer", np.nan, angles))  # one roller has one
    permitted = np.degrees(float(result.permitted_pressure_angle))
    limit, name = permitted, "permitted"
    if not np.isfinite(permitted):
        limit, name = np.degrees(float(result.common_pressure_angle)), "common limit"
    for sign in (1, -1):
        _limit(axis, sign * limit, name)
    axis.set_ylabel("pressure angle (°)")


def _transmission(axis: Axes, result: xr.Dataset) -> None:
    axis.plot(np.degrees(result.cam_angle.values), np.degrees(result.transmission_angle.values), **style.line_style(4))
    axis.set_ylim(0, 92)
    axis.set_ylabel("transmission angle (°)")


def _force(axis: Axes, result: xr.Dataset) -> None:
    _lines(axis, result, result.contact_force.values)
    if "outer" not in result.cam.values:
        _bands(axis, result, "lift-off", "lifts off", COLOURS[1])
    axis.set_ylim(bottom=0)
    axis.set_ylabel(label(result, "contact_force"))


def _bands(axis: Axes, result: xr.Dataset, what: str, name: str, colour: str) -> None:
    """A band over each arc of the cam angle on which something happens, and where it comes again a turn earlier."""
    for i in np.flatnonzero(result.arc_of.values == what).tolist():
        for turn in (0.0, -360.0):
            low, high = np.clip(np.degrees([float(result.arc_begin[i]), float(result.arc_end[i])]) + turn, 0, 360)
            if high > low:
                axis.axvspan(low, high, color=colour, alpha=0.15, linewidth=0, label=name)


def _torque(axis: Axes, result: xr.Dataset) -> None:
    axis.plot(np.degrees(result.cam_angle.values), result.camshaft_torque.values, **style.line_style(4))
    axis.set_ylabel(label(result, "camshaft_torque"))


def _pressure(axis: Axes, result: xr.Dataset) -> None:
    _lines(axis, result, 1e-6 * result.contact_pressure.values)
    _limit(axis, 1e-6 * float(result.permitted_contact_pressure), "permitted")
    axis.set_ylim(bottom=0)
    axis.set_ylabel("contact pressure (MPa)")


def _touched(axis: Axes, result: xr.Dataset) -> None:
    """Where a flat face is touched: as far from the rod's axis as its velocity by the cam angle says."""
    sense = -1 if summary_of(result)["clockwise"] else 1
    axis.plot(np.degrees(result.cam_angle.values), -1e3 * sense * result.follower_velocity.values, **style.line_style(4))
    axis.set_ylabel("face touched at y (mm)")


def _motion(axis: Axes, result: xr.Dataset) -> None:
    turns = result.follower.attrs["units"] == "rad"
    motion = np.degrees(result.follower.values) if turns else 1e3 * result.follower.values
    axis.plot(np.degrees(result.cam_angle.values), motion, **style.line_style(4))
    axis.set_ylabel(f"motion of the {'lever (°)' if turns else 'follower (mm)'}")
