"""Cams to scale, their radii of curvature and motions, and spectra over the orders of a turn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import plain_decades, travel_unit
from wucht.plots.style import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LAW_NAMES = ("position", "velocity", "acceleration", "jerk")  # of a law and its derivatives by the cam angle, in a result
PER_ANGLE = ("", "/rad", "/rad^2", "/rad^3")  # units of these
FOLLOWER = "#000000"
CAM_NAMES = {"cam": "cam", "counter": "counter cam", "outer": "outer flank"}
CAM_LOOKS: dict[str, dict[str, Any]] = {  # so that both curves are visible where they coincide
    "original": {"color": COLOURS[1], "linestyle": "--"},
    "corrected": {"color": COLOURS[0], "linestyle": "-"},
}
_RADIUS_LIMIT = 2.5  # of the largest distance from the centre: larger radii of curvature are not drawn


def draw_circle(axis: Axes, x: float, y: float, radius: float, **look: Any) -> None:
    """Draw a circle about a point."""
    at = np.linspace(0, 2 * np.pi, 181)
    axis.plot(x + radius * np.cos(at), y + radius * np.sin(at), **look)


def frame_cam(axis: Axes) -> None:
    """Set up a panel in which a cam is drawn to scale."""
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel="x (mm), cam at 0°", ylabel="y (mm)")


def draw_limit(axis: Axes, value: float, name: str, colour: str = COLOURS[3]) -> None:
    """Draw a limit across a panel, if it is a number."""
    if np.isfinite(value):
        axis.axhline(value, color=colour, linestyle=":", linewidth=1.2, label=name)


def radii_of_curvature(result: Any) -> tuple[Any, float]:
    """Radii of curvature of the contours in mm, left out where they are nearly straight, and the largest one drawn."""
    widest = _RADIUS_LIMIT * 1e3 * float(np.hypot(result.contour_x.values, result.contour_y.values).max())
    with np.errstate(divide="ignore"):
        radius = 1e3 / result.curvature
    return radius.where(np.abs(radius) <= widest), widest


def draw_motion(axis: Axes, result: Any, name: str, per: str = "", **look: Any) -> str:
    """Draw a motion or a derivative of it over the cam angle, from its law (``position``). Return the unit of the drawing."""
    scale, unit = travel_unit(result.position)
    axis.plot(np.degrees(result.cam_angle.values), scale * result[name].values, **look)
    return unit + per


def order_scale(axis: Axes, orders: np.ndarray) -> None:
    """Set the abscissa of a panel to the orders of a spectrum (N,)."""
    axis.set(xlim=(0.3, orders[-1] + 0.7), xlabel="order", axisbelow=True)
    axis.locator_params(axis="x", integer=True)


def draw_bars_from(axis: Axes, bottom: float, at: np.ndarray, tops: np.ndarray, width: float = 0.4, **look: Any) -> None:
    """Draw bars (N,) over a logarithmic scale, which has no zero."""
    axis.bar(at, tops - bottom, width, bottom=bottom, **look)


def decade_scale(axis: Axes, floor: float, highest: float, step: int) -> None:
    """Set a logarithmic ordinate from below a floor, with a number every so many decades."""
    axis.set_yscale("log")
    plain_decades(axis.yaxis)
    axis.set_ylim(floor / 2, 3 * highest)
    axis.set_yticks(10.0 ** np.arange(np.ceil(np.log10(floor)), np.log10(3 * highest), step))
    axis.minorticks_off()
