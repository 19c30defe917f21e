"""The stability map: which steady phase configurations are stable in the slow equations, over speed and unbalance ratio."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.style import GREY, label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

# Light enough to be told apart in grey, too: regions of the map, and where nothing is stable.
_REGIONS = ("#8FC7E8", "#F0B27A", "#FBE3A1", "#B7A0CF", "#C9E4CA", "#E8B7D4", "#9E9E9E", "#D7CCC8")


def draw_map(axis: Axes, result: xr.Dataset) -> None:
    """Which states are stable in the slow equations, over speed and unbalance ratio."""
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    stable = result.map_stable.values.astype(int)
    code = (stable * (2 ** np.arange(len(stable)))[:, None, None]).sum(axis=0)
    present = [int(c) for c in np.unique(code)]
    coloured = [c for c in present if c]
    colours = {0: "white"} | {c: _REGIONS[_place(c, coloured)] for c in coloured}
    index = np.searchsorted(present, code)
    norm = BoundaryNorm(np.arange(len(present) + 1) - 0.5, len(present))
    axis.pcolormesh(
        result.map_speed.values, result.map_ratio.values, index, cmap=ListedColormap([colours[c] for c in present]), norm=norm,
        shading="nearest", rasterized=True,
    )  # fmt: skip
    names = [str(n) for n in result.region.values]
    words = {c: " and ".join(n for k, n in enumerate(names) if c >> k & 1) or "none" for c in present}
    handles: list[Any] = [Patch(facecolor=colours[c], edgecolor=GREY, linewidth=0.5, label=words[c]) for c in present]
    low, high = float(result.map_speed[0]), float(result.map_speed[-1])
    for f in np.unique(np.round(np.abs(result.natural_frequency.values), 9)):
        if low <= f <= high:
            axis.axvline(float(f), color=GREY, linestyle=":", linewidth=1.0)
    handles.append(Line2D([], [], color=GREY, linestyle=":", label="natural frequencies"))
    _this_machine(axis, result, handles)
    axis.set_xlabel(label(result, "map_speed"))
    axis.set_ylabel("unbalance of the balancing\nbodies over that of the rotor")
    axis.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(1.02, 1.02),
        frameon=False,
        fontsize=8,
        title="stable (slow equations)",
    )


def _place(code: int, coloured: list[int]) -> int:
    """A colour for a combination: single regions keep theirs, others take those that are left."""
    if code & (code - 1) == 0:
        return min(code.bit_length() - 1, len(_REGIONS) - 1)
    several = [c for c in coloured if c & (c - 1)]
    return min(4 + several.index(code), len(_REGIONS) - 1)


def _this_machine(axis: Axes, result: xr.Dataset, handles: list[Any]) -> None:
    """The machine's own place, where it has one on the map."""
    from matplotlib.lines import Line2D

    own = result.unbalance.values
    ratio = own[1:].sum() / own[0] if own[0] else math.inf
    speeds = np.abs(result.speed.values)
    low, high = axis.get_ylim()
    if low <= ratio <= high and len(speeds):
        inside = np.unique(np.round(speeds, 6))
        inside = inside[(inside >= axis.get_xlim()[0]) & (inside <= axis.get_xlim()[1])]
        if len(inside):
            style: dict[str, Any] = {
                "marker": "o",
                "color": "black",
                "markerfacecolor": "white",
                "linestyle": "none",
                "markersize": 5,
            }
            axis.plot(inside, np.full(len(inside), ratio), **style)
            handles.append(Line2D([], [], label="states above", **style))
