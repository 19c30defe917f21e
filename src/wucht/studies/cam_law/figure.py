"""The figure of a motion law: the motion, its derivatives with what is restricted, and the spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots import sheet
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
    drawn, axes = sheet.new_grid(6, result.attrs["title"], result.attrs["sentence"])
    for order, (name, axis) in enumerate(zip(_NAMES, axes[:4], strict=True)):
        _derivative(axis, result, name, order)
    _spectrum(axes[4], result, 0, "position")
    _spectrum(axes[5], result, 2, "acceleration")
    sheet.legend_below(drawn, sheet.named_in(axes))
    return drawn


def _scale(result: xr.Dataset) -> tuple[float, str]:
    """The factor by which the motion is drawn, and its unit there."""
    return (np.degrees(1.0), "°") if result.position.attrs["units"] == "rad" else (1e3, "mm")


def _derivative(axis: Axes, result: xr.Dataset, name: str, order: int) -> None:
    scale, unit = _scale(result)
    phi = np.degrees(result.cam_angle.values)
    axis.plot(phi, scale * result[name].values, color=COLOURS[0], linewidth=1.3, label="motion law")
    low, high = axis.get_ylim()
    named = set[str]()
    for i in np.flatnonzero(result.restricted.values == order).tolist():
        _restriction(axis, result, i, scale, named)
    if order:
        axis.set_ylim(low, high)
    axis.set_xlim(0, 360)
    axis.set_xticks(np.arange(0, 361, 60))
    axis.set_xlabel("cam angle (°)")
    axis.set_ylabel(with_unit(name, f"{unit}{_PER[order]}"))


def _restriction(axis: Axes, result: xr.Dataset, i: int, scale: float, named: set[str]) -> None:
    """Bounds as lines over their arc, or as triangles at an angle, precision points as dots."""
    begin, end = np.degrees(result.begin.values[i]), np.degrees(result.end.values[i])
    low, high = float(result.low.values[i]), float(result.high.values[i])
    for bound, sign in {low: "^", high: "v"}.items():
        if not np.isfinite(bound):
            continue
        at = end - begin < _SHORT
        what = "precision point" if at and low == high else "restriction"
        label = None if what in named else what
        named.add(what)
        if at:
            mark = "o" if low == high else sign
            axis.plot([begin % 360], [scale * bound], mark, color=COLOURS[1], markersize=5, label=label, zorder=5)
            continue
        for turn in (-360.0, 0.0, 360.0):
            axis.plot([begin + turn, end + turn], [scale * bound] * 2, "--", color=COLOURS[1], linewidth=1.2, label=label)
            label = None


def _spectrum(axis: Axes, result: xr.Dataset, power: int, name: str) -> None:
    scale, unit = _scale(result)
    k = result.order.values
    axis.set_axisbelow(True)
    axis.bar(k, scale * k**power * result.amplitude.values, width=0.6, color=COLOURS[0], edgecolor=GREY, linewidth=0.4)
    axis.set_xlabel("order")
    axis.set_ylabel(with_unit(f"{name}, amplitude", f"{unit}{_PER[power]}"))
    axis.set_xlim(0.3, k[-1] + 0.7)
    axis.locator_params(axis="x", integer=True)
    for i in np.flatnonzero(result.harmonic.values).tolist():
        cap, at = scale * result.high.values[i], float(result.harmonic.values[i])
        axis.plot([at - 0.5, at + 0.5], [at**power * cap] * 2, color=COLOURS[1], linewidth=2, label="cap of a harmonic")
