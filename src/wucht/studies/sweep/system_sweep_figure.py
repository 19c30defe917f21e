"""The figure of a sweep of equations: maxima and ranges of states over the parameter, up and down."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_PANELS = 4
_PANEL = 1.9  # inches
_WORDS = {"up": "maxima, rising", "down": "maxima, falling"}


def system_sweep_figure(result: Any) -> Figure:
    """Draw a panel for each state that is no angle, from the Dataset of a sweep of equations alone."""
    rows = np.flatnonzero(result.is_angle.values == 0)[:_MOST_PANELS]
    fig, axes = new_figure(max(len(rows), 1), result.attrs["title"], result.attrs["sentence"], _PANEL)
    for i, axis in zip(rows.tolist(), axes, strict=False):
        for k, way in enumerate(str(d) for d in result.direction.values):
            value, peaks = result.value.values[k], result.maxima.values[k, i]
            low, high = result.low.values[k, i], result.high.values[k, i]
            axis.fill_between(value, low, high, color=COLOURS[k], alpha=0.15, linewidth=0)
            look: dict[str, Any] = {"color": COLOURS[k], "markersize": 2.6 - k, "markeredgewidth": 0, "label": _WORDS[way]}
            axis.plot(np.repeat(value, peaks.shape[1]), peaks.ravel(), ".", **look)
        axis.set_ylabel(str(result.state.values[i]))
        legend_beside(axis)
    axes[-1].set_xlabel(result.attrs["along"])
    return fig
