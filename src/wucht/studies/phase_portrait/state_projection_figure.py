"""The figure of a projected portrait: trajectories, what they tend to, and equilibria, over two states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.limit_set_curves import TRANSIENT, draw_limit_set, wrapped_curve
from wucht.plots.sheet import legend_below, new_figure
from wucht.plots.stability_lines import entry
from wucht.plots.style import COLOURS
from wucht.results.attributes import number_in
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_POINTS: dict[str, dict[str, Any]] = {
    "stable": {"marker": "o", "markerfacecolor": "black"},
    "saddle": {"marker": "x", "markeredgewidth": 2.0},
    "unstable": {"marker": "o", "markerfacecolor": "white"},
    "degenerate": {"marker": "s", "markerfacecolor": "white"},
}
_BEGIN = (0.0, 0.0)  # of the turn in which angles are drawn


def draw_projection(result: xr.Dataset) -> Figure:
    """Draw the projection from the Dataset alone."""
    fig, (axis,) = new_figure(1, result.attrs["title"], answer_in_print(result), 4.2)
    rows = [int(number_in(result, "abscissa")), int(number_in(result, "ordinate"))]
    turning = np.atleast_1d(result.attrs["turning"])[rows] > 0
    for curve in result.trajectories.values:
        axis.plot(*wrapped_curve(curve[rows], turning, _BEGIN), **TRANSIENT)
    for curve, kind in zip(result.limit_sets.values, result.limit_set_kind.values.astype(str), strict=True):
        if kind != "equilibrium":
            draw_limit_set(axis, curve[rows], turning, kind, _BEGIN)
    kinds = result.equilibrium_kind.values.astype(str)
    for state, kind in zip(result.equilibria.values.T, kinds, strict=True):
        axis.plot(*state[rows], linestyle="", color="black", markersize=6.5, zorder=7, **_POINTS[kind])
    names = [str(result.state.values[row]) for row in rows]
    axis.set(xlabel=names[0], ylabel=names[1])
    handles = [
        entry(f"equilibrium, {k}", linestyle="", color="black", markersize=6, **_POINTS[k]) for k in dict.fromkeys(kinds)
    ]
    handles.append(entry("trajectory", **TRANSIENT))
    if (result.limit_set_kind.values.astype(str) != "equilibrium").any():
        handles.append(entry("what it tends to", color=COLOURS[1], linewidth=1.7))
    legend_below(fig, handles)
    return fig
