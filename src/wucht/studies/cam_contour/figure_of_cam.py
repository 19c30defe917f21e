"""The cam to scale, as it stands at cam angle 0, with its follower."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.style import COLOURS
from wucht.results.conventions import summary_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_COLOUR = {"cam": COLOURS[0], "counter": COLOURS[1], "outer": COLOURS[2]}
_NAMED = {"cam": "contour", "counter": "contour of the counter cam", "outer": "outer flank"}
_FOLLOWER = "#000000"
_EDGE = 0.5  # of the base circle: so long a rod is drawn behind an edge


def draw_cam(axis: Axes, result: xr.Dataset) -> None:
    """Contours, base circle, pitch curves, rollers, the cam's centre, the lever with its pivot, the rod or the face; in mm."""
    for i, name in enumerate(map(str, result.cam.values)):
        left = ~is_missing(result, name)
        x, y = (np.where(left, 1e3 * result[v].values[i], np.nan) for v in ("contour_x", "contour_y"))
        axis.plot(x, y, color=_COLOUR[name], linewidth=1.6, label=_NAMED[name], zorder=3)
        if name in ("cam", "counter"):
            # Twice the outline would be darker where contours overlap: the fill is pale enough for both.
            axis.fill(x[left], y[left], color=_COLOUR[name], alpha=0.0 if "outer" in result.cam.values else 0.08, linewidth=0)
            pitch = 1e3 * result.pitch_x.values[i], 1e3 * result.pitch_y.values[i]
            if np.isfinite(pitch[0]).all():
                axis.plot(*pitch, color=_COLOUR[name], linestyle="--", linewidth=0.8, label="pitch curve", zorder=3)
            base = 1e3 * float(result.base_radius[i])
            _circle(axis, 0, 0, base, label="base circle", color=_COLOUR[name], linestyle=":", linewidth=0.9)
            _roller(axis, result, i)
        _cut(axis, result, i, ~left)
    _turning(axis, result)
    axis.plot([0], [0], "+", color=_FOLLOWER, markersize=9, markeredgewidth=1.2, label="cam's centre", zorder=6)
    _face(axis, result)
    axis.set_aspect("equal", adjustable="datalim")
    axis.grid(visible=True, linewidth=0.4, color="#DDDDDD")
    axis.set_axisbelow(True)
    axis.set_xlabel("x (mm), cam at 0°")
    axis.set_ylabel("y (mm)")


def _turning(axis: Axes, result: xr.Dataset) -> None:
    """An arrow in the sense in which the cam turns."""
    extent = float(np.hypot(result.contour_x.values, result.contour_y.values).max())
    radius = 1e3 * max(0.3 * float(result.base_radius[0]), 0.12 * extent)
    ends = radius * np.exp(1j * np.radians([60, 120]))
    begin, end = ends[::-1] if summary_of(result)["clockwise"] else ends
    bend = -0.3 if summary_of(result)["clockwise"] else 0.3
    arrow = {"arrowstyle": "->", "connectionstyle": f"arc3,rad={bend}", "color": _FOLLOWER, "linewidth": 1.0}
    axis.annotate("", (end.real, end.imag), (begin.real, begin.imag), arrowprops=arrow, zorder=6)


def _circle(axis: Axes, x: float, y: float, radius: float, **appearance: Any) -> None:
    at = np.linspace(0, 2 * np.pi, 181)
    axis.plot(x + radius * np.cos(at), y + radius * np.sin(at), **appearance)


def _roller(axis: Axes, result: xr.Dataset, i: int) -> None:
    """At its place at cam angle 0, with its lever or its rod."""
    radius = 1e3 * float(result.roller_radius[i])
    if not np.isfinite(radius):
        return
    x, y = 1e3 * float(result.pitch_x[i, 0]), 1e3 * float(result.pitch_y[i, 0])
    _circle(axis, x, y, radius, label="roller", color=_FOLLOWER, linewidth=1.2, zorder=5)
    axis.plot([x], [y], ".", color=_FOLLOWER, markersize=4, zorder=5)
    pivot = 1e3 * float(result.pivot)
    if np.isfinite(pivot):
        axis.plot([pivot, x], [0, y], color=_FOLLOWER, linewidth=2.0, alpha=0.7, label="lever", zorder=4)
        axis.plot([pivot], [0], "o", color=_FOLLOWER, markerfacecolor="white", markersize=7, label="pivot", zorder=6)
    else:
        axis.plot(
            [x, x + (3 * radius or _EDGE * 1e3 * float(result.base_radius[i]))],
            [y, y],
            color=_FOLLOWER,
            linewidth=2.0,
            alpha=0.7,
            label="rod",
            zorder=4,
        )


def _face(axis: Axes, result: xr.Dataset) -> None:
    x = 1e3 * float(result.face_at)
    if not np.isfinite(x):
        return
    low, high = 1e3 * float(result.face_from), 1e3 * float(result.face_to)
    axis.plot([x, x], [low, high], color=_FOLLOWER, linewidth=2.0, label="face, as far as it is touched", zorder=5)
    axis.plot([x, x + (high - low)], [0, 0], color=_FOLLOWER, linewidth=2.0, alpha=0.7, label="rod", zorder=4)


def _cut(axis: Axes, result: xr.Dataset, i: int, missing: np.ndarray) -> None:
    """What is cut away of a contour."""
    if missing.any():
        x, y = (np.where(missing, 1e3 * result[v].values[i], np.nan) for v in ("contour_x", "contour_y"))
        axis.plot(x, y, color=COLOURS[3], linewidth=1.8, label="cut away", zorder=6)


def is_missing(result: xr.Dataset, name: str) -> np.ndarray:
    """Whether the contour of a cam is cut away (N,) at the cam angles of the result."""
    phi, missing = result.cam_angle.values, np.zeros(result.sizes["cam_angle"], bool)
    for k in np.flatnonzero((result.arc_cam.values == name) & (result.arc_of.values == "missing")).tolist():
        missing |= np.mod(phi - float(result.arc_begin[k]), 2 * np.pi) <= float(result.arc_end[k]) - float(result.arc_begin[k])
    return missing
