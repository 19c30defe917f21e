"""The figure of a sweep of equations: maxima and ranges of states over the parameter, up and down."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import legend_below, new_figure
from wucht.plots.stability_lines import entry
from wucht.plots.style import COLOURS, GUIDE
from wucht.results.attributes import text_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_PANELS = 4
_PANEL = 1.9  # inches
_WORDS = {"up": "maxima, rising", "down": "maxima, falling"}
_SIZES, _SIZE_OF_ALL = (1.5, 5.0), 240.0  # points: of a marker, and of the markers of all values together
_INNER = 0.6  # size of the markers of the falling sweep over that of the rising one, upon which they lie


def system_sweep_figure(result: Any) -> Figure:
    """Draw a panel for each state that is no angle, from the Dataset of a sweep of equations alone."""
    rows = np.flatnonzero(result.is_angle.values == 0)[:_MOST_PANELS]
    fig, axes = new_figure(max(len(rows), 1), result.attrs["title"], result.attrs["sentence"], _PANEL)
    size = float(np.clip(_SIZE_OF_ALL / result.sizes["step"], *_SIZES))
    ways = [str(d) for d in result.direction.values]
    jumps = result.wucht.summary["jumps"]
    for i, axis in zip(rows.tolist(), axes, strict=False):
        for k in range(len(ways)):
            value, peaks = result.value.values[k], result.maxima.values[k, i]
            low, high = result.low.values[k, i], result.high.values[k, i]
            axis.fill_between(value, low, high, color=COLOURS[k], alpha=0.15, linewidth=0)
            look = _marker(k) | {"markersize": size * (_INNER if k else 1.0)}
            axis.plot(np.repeat(value, peaks.shape[1]), peaks.ravel(), **look)
        for jump in jumps:
            axis.axvline(jump["value"], zorder=1, **GUIDE)
        axis.set_ylabel(str(result.state.values[i]))
    axes[-1].set_xlabel(text_in(result, "along"))
    handles = [entry(_WORDS[way], **_marker(k), markersize=_SIZES[1]) for k, way in enumerate(ways)]
    legend_below(fig, handles + ([entry("jump", **GUIDE)] if jumps else []))
    return fig


def _marker(way: int) -> dict[str, Any]:
    return {"linestyle": "", "marker": "o", "color": COLOURS[way], "markeredgewidth": 0}
