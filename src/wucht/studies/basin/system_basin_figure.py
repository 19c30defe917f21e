"""The figure of a map of attractors of equations: the basins over two states, with the attractors in them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import ListedColormap

from wucht.plots.limit_set_curves import draw_limit_set
from wucht.plots.scales import multiples_of_pi
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.stability_lines import entry, field
from wucht.plots.style import GREY
from wucht.results.formatting import percent

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TONES = ("#5FAEDF", "#F5C04A", "#D9EFC9", "#E8A0BF", "#B9A7DA", "#F0E3B0", "#9CCFC0", "#C7C7C7")
_WITHOUT = {"unsettled": "#FFFFFF", "diverges": "#404040", "failed": "#000000", "neutral": "#8C8C8C"}


def system_basin_figure(result: xr.Dataset) -> Figure:
    """Draw the basins, and the attractors projected on both states, from the Dataset alone."""
    fig, (axis,) = new_figure(1, result.attrs["title"], result.attrs["sentence"], 3.6)
    s, at = result.wucht.summary, result.attrs
    outcome = result["refined_outcome" if "refined_outcome" in result else "outcome"]
    values = outcome.values
    flags = dict(zip(np.asarray(outcome.flag_values).tolist(), str(outcome.flag_meanings).split(), strict=True))
    present = [k for k in flags if (values == k).any()]
    tones = {k: _WITHOUT.get(flags[k]) or _TONES[k % len(_TONES)] for k in present}
    extent = tuple(at[f"{k}_{end}"] for k in "xy" for end in ("low", "high"))
    look: dict[str, Any] = {"origin": "lower", "extent": extent, "aspect": "auto", "interpolation": "nearest"}
    axis.imshow(
        np.searchsorted(present, values), cmap=ListedColormap(list(tones.values())), vmin=-0.5, vmax=len(present) - 0.5, **look
    )
    axis.grid(visible=False)
    has_attractors = _draw_attractors(axis, result)
    axis.set(xlim=extent[:2], ylim=extent[2:], xlabel=str(at["x_axis"]), ylabel=str(at["y_axis"]))
    for k in "xy":
        if at[f"{k}_is_angle"] and (ticks := multiples_of_pi(at[f"{k}_low"], at[f"{k}_high"])):
            getattr(axis, f"set_{k}ticks")([t for t, _ in ticks], [word for _, word in ticks])
    shares = sorted(present, key=lambda k: -s["fractions"][flags[k]])
    handles = [
        field(f"{flags[k]}: {_share_text(s['fractions'][flags[k]], s['standard_errors'][flags[k]])}", tones[k], edge=GREY)
        for k in shares
    ]
    handles += [entry("attractors", color="black", linestyle="", marker="o", markersize=3)] if has_attractors else []
    legend_beside(axis, handles)
    return fig


def _share_text(share: float, error: float) -> str:
    """Return a share with its uncertainty, without a line break in it."""
    return percent(share, 2 * error).replace(" ", "\N{NO-BREAK SPACE}")


def _draw_attractors(axis: Axes, result: xr.Dataset) -> bool:
    """Draw the attractors; return whether there are any."""
    names = [str(n) for n in result.state.values]
    rows = [names.index(str(result.attrs[f"{k}_axis"])) for k in "xy"]
    turning = np.array([result.attrs[f"{k}_is_angle"] for k in "xy"]) > 0
    begin = float(result.attrs["x_low"]), float(result.attrs["y_low"])
    kinds = {a["label"]: a["kind"] for a in result.wucht.summary["attractors"]}
    for samples, name in zip(result.attractor_states.values, result.attractor.values.astype(str), strict=True):
        draw_limit_set(axis, samples[rows], turning, kinds[name], begin, color="black")
    return len(result.attractor_states) > 0
