"""The figure of a motion law: the motion, its derivatives with what is restricted, and the spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots.cam_drawings import draw_motion, order_scale
from wucht.plots.scales import travel_unit, turn_scale
from wucht.plots.sheet import legend_below, named_in, new_grid
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAMES = ("position", "velocity", "acceleration", "jerk")
_PER = ("", "/rad", "/rad²", "/rad³")
_SHORT = 2.0  # degrees: arcs that are shorter are drawn as points


def figure(result: xr.Dataset) -> Figure:
    """Four panels over the cam angle, and the orders of motion and acceleration."""
    drawn, axes = new_grid(6, result.attrs["title"], result.attrs["sentence"])
    for order, axis in enumerate(axes[:4]):
        _derivative(axis, result, order)
    _spectrum(axes[4], result, 0, "position")
    _spectrum(axes[5], result, 2, "acceleration")
    legend_below(drawn, named_in(axes))
    return drawn


def _derivative(axis: Axes, result: xr.Dataset, order: int) -> None:
    look = {"color": COLOURS[0], "linewidth": 1.3, "label": "motion law"}
    unit = draw_motion(axis, result, _NAMES[order], _PER[order], **look)
    low, high = axis.get_ylim()
    for i in np.flatnonzero(result.restricted.values == order).tolist():
        _restriction(axis, result, i, travel_unit(result.position)[0])
    if order:
        axis.set_ylim(low, high)
    turn_scale(axis)
    axis.set_ylabel(with_unit(_NAMES[order], unit))


def _restriction(axis: Axes, result: xr.Dataset, i: int, scale: float) -> None:
    """Bounds as lines over their arc, or as triangles at an angle, precision points as dots."""
    begin, end = np.degrees(result.begin.values[i]), np.degrees(result.end.values[i])
    low, high = float(result.low.values[i]), float(result.high.values[i])
    at = end - begin < _SHORT
    for bound, sign in {low: "^", high: "v"}.items():
        if np.isfinite(bound) and at:
            mark, name = ("o", "precision point") if low == high else (sign, "restriction")
            axis.plot([begin % 360], [scale * bound], mark, color=COLOURS[1], markersize=5, label=name, zorder=5)
        elif np.isfinite(bound):
            for turn in (-360.0, 0.0, 360.0):
                ends = [begin + turn, end + turn]
                axis.plot(ends, [scale * bound] * 2, "--", color=COLOURS[1], linewidth=1.2, label="restriction")


def _spectrum(axis: Axes, result: xr.Dataset, power: int, name: str) -> None:
    scale, unit = travel_unit(result.position)
    k = result.order.values
    axis.bar(k, scale * k**power * result.amplitude.values, width=0.6, color=COLOURS[0], edgecolor=GREY, linewidth=0.4)
    axis.set_ylabel(with_unit(f"{name}, amplitude", f"{unit}{_PER[power]}"))
    order_scale(axis, k)
    for i in np.flatnonzero(result.harmonic.values).tolist():
        cap, at = scale * result.high.values[i], float(result.harmonic.values[i])
        axis.plot([at - 0.5, at + 0.5], [at**power * cap] * 2, color=COLOURS[1], linewidth=2, label="cap of a harmonic")
