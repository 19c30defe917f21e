"""The figure of a cam's contour: the cam to scale with its follower, and below it the criteria over the cam angle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.cam_drawings import CAM_NAMES, FOLLOWER, draw_circle, draw_limit, frame_cam, radii_of_curvature
from wucht.plots.page import small
from wucht.plots.scales import travel_unit, turn_scale
from wucht.plots.sheet import draw_panels, labelled_handles, legend_below
from wucht.plots.style import COLOURS, GREY, line_style
from wucht.results.formatting import label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOUR = {"cam": COLOURS[0], "counter": COLOURS[1], "outer": COLOURS[2]}
_CONTOURS = {"cam": "contour", "counter": "contour of the counter cam", "outer": "outer flank"}
_ROD: dict[str, Any] = {"color": FOLLOWER, "linewidth": 2.0, "alpha": 0.7, "zorder": 4}
_EDGE = 0.5  # of the base circle: length of the rod drawn behind an edge
_ROW, _CAM = 1.5, 4.0  # inches
_LINE = {"cam": 0, "counter": 1, "outer": 2}


def _draw_cam(axis: Axes, result: xr.Dataset) -> None:
    """Draw contours, base circle, pitch curves, rollers, the cam's centre, the lever with its pivot, rod or face; in mm."""
    for i, name in enumerate(map(str, result.cam.values)):
        is_missing, x, y = _is_missing(result, name), 1e3 * result.contour_x.values[i], 1e3 * result.contour_y.values[i]
        colour = _COLOUR[name]
        axis.plot(
            *np.where(is_missing, np.nan, [x, y]), color=colour, linewidth=1.6, label=_contour_name(result, name), zorder=3
        )
        if name in ("cam", "counter"):
            # An outline drawn twice would be darker where contours overlap: the fill is pale enough for both.
            axis.fill(
                x[~is_missing], y[~is_missing], color=colour, alpha=0.0 if "outer" in result.cam.values else 0.08, linewidth=0
            )
            pitch = 1e3 * result.pitch_x.values[i], 1e3 * result.pitch_y.values[i]
            if np.isfinite(pitch[0]).all():
                axis.plot(*pitch, color=colour, linestyle="--", linewidth=0.8, label="pitch curve", zorder=3)
            base = 1e3 * float(result.base_radius[i])
            draw_circle(axis, 0, 0, base, label="base circle", color=colour, linestyle=":", linewidth=0.9)
            _roller(axis, result, i)
        if is_missing.any():
            axis.plot(*np.where(is_missing, [x, y], np.nan), color=COLOURS[3], linewidth=1.8, label="cut away", zorder=6)
    _draw_turning_sense(axis, result)
    axis.plot([0], [0], "+", color=FOLLOWER, markersize=9, markeredgewidth=1.2, label="cam's centre", zorder=6)
    _face(axis, result)
    frame_cam(axis)


def _contour_name(result: xr.Dataset, name: str) -> str:
    """Name a contour: of the original or the corrected cam, where a speed of the shaft is stated."""
    version = result.wucht.summary.get("cam_version")  # results of earlier versions lack it
    return f"{_CONTOURS[name]}, {version}" if version else _CONTOURS[name]


def _draw_turning_sense(axis: Axes, result: xr.Dataset) -> None:
    """Draw an arrow in the sense in which the cam turns."""
    extent = float(np.hypot(result.contour_x.values, result.contour_y.values).max())
    radius, clockwise = 1e3 * max(0.3 * float(result.base_radius[0]), 0.12 * extent), result.wucht.summary["clockwise"]
    begin, end = radius * np.exp(1j * np.radians([120, 60] if clockwise else [60, 120]))
    bend = f"arc3,rad={-0.3 if clockwise else 0.3}"
    arrow = {"arrowstyle": "->", "connectionstyle": bend, "color": FOLLOWER, "linewidth": 1.0}
    axis.annotate("", (end.real, end.imag), (begin.real, begin.imag), arrowprops=arrow, zorder=6)


def _roller(axis: Axes, result: xr.Dataset, i: int) -> None:
    """Draw the roller at cam angle 0, with its lever or its rod."""
    radius = 1e3 * float(result.roller_radius[i])
    if not np.isfinite(radius):
        return
    x, y, pivot = 1e3 * float(result.pitch_x[i, 0]), 1e3 * float(result.pitch_y[i, 0]), 1e3 * float(result.pivot)
    draw_circle(axis, x, y, radius, label="roller", color=FOLLOWER, linewidth=1.2, zorder=5)
    axis.plot([x], [y], ".", color=FOLLOWER, markersize=4, zorder=5)
    if np.isfinite(pivot):
        axis.plot([pivot, x], [0, y], label="lever", **_ROD)
        axis.plot([pivot], [0], "o", color=FOLLOWER, markerfacecolor="white", markersize=7, label="pivot", zorder=6)
    else:
        length = 3 * radius or _EDGE * 1e3 * float(result.base_radius[i])
        axis.plot([x, x + length], [y, y], label="rod", **_ROD)


def _face(axis: Axes, result: xr.Dataset) -> None:
    x, low, high = (1e3 * float(result[f"face_{end}"]) for end in ("at", "from", "to"))
    if np.isfinite(x):
        axis.plot([x, x], [low, high], color=FOLLOWER, linewidth=2.0, label="face, touched part", zorder=5)
        axis.plot([x, x + (high - low)], [0, 0], label="rod", **_ROD)


def _is_missing(result: xr.Dataset, name: str) -> np.ndarray:
    """Return where (N,) the contour of a cam is cut away, at the cam angles of the result."""
    phi, missing = result.cam_angle.values, np.zeros(result.sizes["cam_angle"], bool)
    for k in np.flatnonzero((result.arc_cam.values == name) & (result.arc_of.values == "missing")).tolist():
        missing |= np.mod(phi - float(result.arc_begin[k]), 2 * np.pi) <= float(result.arc_end[k]) - float(result.arc_begin[k])
    return missing


def draw_contour(result: xr.Dataset) -> Figure:
    """Draw the cam above, and below it two panels a row: radius of curvature, pressure angle, and further criteria."""
    panels = [_curvature_radius, _motion if np.isfinite(float(result.face_at)) else _pressure_angle]
    if np.isfinite(result.transmission_angle.values).any():
        panels.append(_transmission)
    if (result.contact_force.values > 0).any():
        panels += [_force, _pressure, _torque] if np.isfinite(result.contact_pressure.values).any() else [_force, _torque]
    if len(panels) % 2:
        panels.append(_face_contact if _motion in panels else _motion)
    fig, axes = draw_panels(result, [_draw_cam, *panels], None, heights=(_CAM, _ROW), wide=1)
    for axis in axes[1:]:
        turn_scale(axis)
    legend_below(fig, labelled_handles(axes))
    return fig


def _lines(axis: Axes, result: xr.Dataset, values: np.ndarray) -> None:
    """Draw a line for each cam, with its name where there are several."""
    for name, row in zip(map(str, result.cam.values), values, strict=True):
        if np.isfinite(row).any():
            _line(axis, result, row, _LINE[name], CAM_NAMES[name] if len(values) > 1 else None)


def _line(axis: Axes, result: xr.Dataset, values: np.ndarray, look: int = 4, name: str | None = None) -> None:
    axis.plot(np.degrees(result.cam_angle.values), values, label=name, **line_style(look))


def _curvature_radius(axis: Axes, result: xr.Dataset) -> None:
    """Draw the radius of curvature of the contour, except where it is nearly straight or cut away."""
    radii, widest = radii_of_curvature(result)
    is_missing = np.array([_is_missing(result, name) for name in map(str, result.cam.values)])
    visible_radii = np.where(is_missing, np.nan, radii.values)
    _lines(axis, result, visible_radii)
    _bands(axis, result, "missing", "cut away", COLOURS[3])
    draw_limit(axis, 1e3 * float(result.permitted_radius), "permitted")
    draw_limit(axis, -1e3 * float(result.wheel_radius), "grinding wheel", COLOURS[5])
    axis.axhline(0, color=GREY, linewidth=0.8)
    low = min(0.0, float(np.nanmin(visible_radii, initial=0.0)), -1e3 * float(np.nan_to_num(result.wheel_radius)))
    high = float(np.nanmax(visible_radii, initial=0.05 * widest))
    axis.set(ylim=(1.1 * low - 0.03 * widest, 1.1 * high), ylabel="radius of curvature (mm)")
    if low < 0:
        # Beside the panel: in it the word would lie under a curve.
        axis.text(1.01, 0.0, "hollow", transform=axis.transAxes, rotation=90, va="bottom", fontsize=small(), color=GREY)


def _pressure_angle(axis: Axes, result: xr.Dataset) -> None:
    angles = np.degrees(result.pressure_angle.values)
    _lines(axis, result, np.where(result.cam.values[:, None] == "outer", np.nan, angles))  # the same roller touches both flanks
    limit, name = np.degrees(float(result.permitted_pressure_angle)), "permitted"
    if not np.isfinite(limit):
        limit, name = np.degrees(float(result.common_pressure_angle)), "common limit"
    for sign in (1, -1):
        draw_limit(axis, sign * limit, name)
    axis.set_ylabel("pressure angle (°)")


def _transmission(axis: Axes, result: xr.Dataset) -> None:
    _line(axis, result, np.degrees(result.transmission_angle.values))
    axis.set(ylim=(0, 92), ylabel="transmission angle (°)")


def _force(axis: Axes, result: xr.Dataset) -> None:
    _lines(axis, result, result.contact_force.values)
    if "outer" not in result.cam.values:
        _bands(axis, result, "lift-off", "lifts off", COLOURS[1])
    axis.set(ylim=(0, None), ylabel=label(result, "contact_force"))


def _bands(axis: Axes, result: xr.Dataset, event: str, name: str, colour: str) -> None:
    """Shade each arc of the cam angle with an event of this kind, and the same arc a turn earlier."""
    for i in np.flatnonzero(result.arc_of.values == event).tolist():
        for turn in (0.0, -360.0):
            low, high = np.clip(np.degrees([float(result.arc_begin[i]), float(result.arc_end[i])]) + turn, 0, 360)
            if high > low:
                axis.axvspan(low, high, color=colour, alpha=0.15, linewidth=0, label=name)


def _torque(axis: Axes, result: xr.Dataset) -> None:
    _line(axis, result, result.camshaft_torque.values)
    axis.set_ylabel(label(result, "camshaft_torque"))


def _pressure(axis: Axes, result: xr.Dataset) -> None:
    _lines(axis, result, 1e-6 * result.contact_pressure.values)
    draw_limit(axis, 1e-6 * float(result.permitted_contact_pressure), "permitted")
    axis.set(ylim=(0, None), ylabel="contact pressure (MPa)")


def _face_contact(axis: Axes, result: xr.Dataset) -> None:
    """Draw where a flat face is touched: its distance from the rod's axis equals the velocity by the cam angle."""
    _line(axis, result, (1e3 if result.wucht.summary["clockwise"] else -1e3) * result.follower_velocity.values)
    axis.set_ylabel("face touched at y (mm)")


def _motion(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = travel_unit(result.follower)
    _line(axis, result, scale * result.follower.values)
    axis.set_ylabel(f"motion of the {'lever' if unit == '°' else 'follower'} ({unit})")
