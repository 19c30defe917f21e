"""The cam to scale, as it stands at cam angle 0, with its follower."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wucht.plots.cam_drawings import FOLLOWER, draw_circle, frame_cam
from wucht.plots.style import COLOURS

_COLOUR = {"cam": COLOURS[0], "counter": COLOURS[1], "outer": COLOURS[2]}
_NAMED = {"cam": "contour", "counter": "contour of the counter cam", "outer": "outer flank"}
_ROD: dict[str, Any] = {"color": FOLLOWER, "linewidth": 2.0, "alpha": 0.7, "zorder": 4}
_EDGE = 0.5  # of the base circle: so long a rod is drawn behind an edge


def draw_cam(axis: Axes, result: xr.Dataset) -> None:
    """Contours, base circle, pitch curves, rollers, the cam's centre, the lever with its pivot, the rod or the face; in mm."""
    for i, name in enumerate(map(str, result.cam.values)):
        cut, x, y = is_missing(result, name), 1e3 * result.contour_x.values[i], 1e3 * result.contour_y.values[i]
        colour = _COLOUR[name]
        axis.plot(*np.where(cut, np.nan, [x, y]), color=colour, linewidth=1.6, label=_NAMED[name], zorder=3)
        if name in ("cam", "counter"):
            # Twice the outline would be darker where contours overlap: the fill is pale enough for both.
            axis.fill(x[~cut], y[~cut], color=colour, alpha=0.0 if "outer" in result.cam.values else 0.08, linewidth=0)
            pitch = 1e3 * result.pitch_x.values[i], 1e3 * result.pitch_y.values[i]
            if np.isfinite(pitch[0]).all():
                axis.plot(*pitch, color=colour, linestyle="--", linewidth=0.8, label="pitch curve", zorder=3)
            base = 1e3 * float(result.base_radius[i])
            draw_circle(axis, 0, 0, base, label="base circle", color=colour, linestyle=":", linewidth=0.9)
            _roller(axis, result, i)
        if cut.any():
            axis.plot(*np.where(cut, [x, y], np.nan), color=COLOURS[3], linewidth=1.8, label="cut away", zorder=6)
    _turning(axis, result)
    axis.plot([0], [0], "+", color=FOLLOWER, markersize=9, markeredgewidth=1.2, label="cam's centre", zorder=6)
    _face(axis, result)
    frame_cam(axis)


def _turning(axis: Axes, result: xr.Dataset) -> None:
    """An arrow in the sense in which the cam turns."""
    extent = float(np.hypot(result.contour_x.values, result.contour_y.values).max())
    radius, clockwise = 1e3 * max(0.3 * float(result.base_radius[0]), 0.12 * extent), result.wucht.summary["clockwise"]
    begin, end = radius * np.exp(1j * np.radians([120, 60] if clockwise else [60, 120]))
    bend = f"arc3,rad={-0.3 if clockwise else 0.3}"
    arrow = {"arrowstyle": "->", "connectionstyle": bend, "color": FOLLOWER, "linewidth": 1.0}
    axis.annotate("", (end.real, end.imag), (begin.real, begin.imag), arrowprops=arrow, zorder=6)


def _roller(axis: Axes, result: xr.Dataset, i: int) -> None:
    """At its place at cam angle 0, with its lever or its rod."""
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
    x, low, high = (1e3 * float(result[f"face_{which}"]) for which in ("at", "from", "to"))
    if np.isfinite(x):
        axis.plot([x, x], [low, high], color=FOLLOWER, linewidth=2.0, label="face, as far as it is touched", zorder=5)
        axis.plot([x, x + (high - low)], [0, 0], label="rod", **_ROD)


def is_missing(result: xr.Dataset, name: str) -> np.ndarray:
    """Whether the contour of a cam is cut away (N,) at the cam angles of the result."""
    phi, missing = result.cam_angle.values, np.zeros(result.sizes["cam_angle"], bool)
    for k in np.flatnonzero((result.arc_cam.values == name) & (result.arc_of.values == "missing")).tolist():
        missing |= np.mod(phi - float(result.arc_begin[k]), 2 * np.pi) <= float(result.arc_end[k]) - float(result.arc_begin[k])
    return missing
