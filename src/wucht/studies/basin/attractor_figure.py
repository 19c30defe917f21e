"""The figure of a map of attractors of equations: the basins over two states, with the attractors in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.limit_set_curves import draw_limit_set
from wucht.plots.scales import multiples_of_pi
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.stability_lines import entry, field
from wucht.plots.style import GREY
from wucht.results.attributes import number_in, text_in
from wucht.results.formatting import percent

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TONES = ("#5FAEDF", "#F5C04A", "#D9EFC9", "#E8A0BF", "#B9A7DA", "#F0E3B0", "#9CCFC0", "#C7C7C7")
_SADDLES: dict[str, tuple[str, dict[str, Any]]] = {  # of each kind: its name, and how it is drawn
    "equilibrium": ("saddle", {"linestyle": "", "marker": "x", "markersize": 6.5, "markeredgewidth": 2.0}),
    "periodic": ("saddle orbit", {"linestyle": "--"}),
}
_WITHOUT = {"unsettled": "#FFFFFF", "diverges": "#404040", "failed": "#000000", "neutral": "#8C8C8C"}


def attractor_figure(result: xr.Dataset) -> Figure:
    """Draw the basins, and the attractors projected on both states, from the Dataset alone."""
    from matplotlib.colors import ListedColormap

    fig, (axis,) = new_figure(1, result.attrs["title"], result.attrs["sentence"], 3.6)
    s, at = result.wucht.summary, result.attrs
    outcome = result["refined_outcome" if "refined_outcome" in result else "outcome"]
    values = outcome.values
    flags = dict(zip(np.asarray(outcome.flag_values).tolist(), str(outcome.flag_meanings).split(), strict=True))
    present = [k for k in flags if (values == k).any()]
    tones = {k: _WITHOUT.get(flags[k]) or _TONES[k % len(_TONES)] for k in present}
    extent = tuple(at[f"{k}_{end}"] for k in "xy" for end in ("low", "high"))
    image: dict[str, Any] = {"origin": "lower", "extent": extent, "aspect": "auto", "interpolation": "nearest"}
    axis.imshow(
        np.searchsorted(present, values), cmap=ListedColormap(list(tones.values())), vmin=-0.5, vmax=len(present) - 0.5, **image
    )
    axis.grid(visible=False)
    unstable = {a["label"]: str(a["kind"]) for a in s["attractors"] if a["stable"] is False}
    _draw_limit_sets(axis, result, unstable)
    axis.set(xlim=extent[:2], ylim=extent[2:], xlabel=str(at["x_axis"]), ylabel=str(at["y_axis"]))
    for k in "xy":
        if at[f"{k}_is_angle"] and (ticks := multiples_of_pi(at[f"{k}_low"], at[f"{k}_high"])):
            getattr(axis, f"set_{k}ticks")([t for t, _ in ticks], [word for _, word in ticks])
    shares = sorted(present, key=lambda k: -s["fractions"][flags[k]])
    handles = [field(f"{flags[k]}: {_share_text(s, flags[k], flags[k] in unstable)}", tones[k], edge=GREY) for k in shares]
    if len(s["attractors"]) > len(unstable):
        handles.append(entry("attractors", color="black", linestyle="", marker="o", markersize=3))
    for name, look in (_SADDLES[kind] for kind in dict.fromkeys(unstable.values())):
        handles.append(entry(f"{name}, reached from a set without area", color="black", **look))
    legend_beside(axis, handles)
    return fig


def _share_text(s: dict[str, Any], label: str, is_unstable: bool) -> str:
    """Return a share with its uncertainty, without a line break in it; what is unstable has a share of the starts only."""
    error = 0.0 if is_unstable else s["standard_errors"][label]
    text = percent(s["fractions"][label], 2 * error).replace(" ", "\N{NO-BREAK SPACE}")
    return f"{text} of the starts" if is_unstable else text


def _draw_limit_sets(axis: Axes, result: xr.Dataset, unstable: Mapping[str, str]) -> None:
    """Draw the attractors, and what is unstable otherwise: an equilibrium as a cross, an orbit dashed."""
    names = [str(n) for n in result.state.values]
    rows = [names.index(text_in(result, f"{k}_axis")) for k in "xy"]
    turning = np.array([number_in(result, f"{k}_is_angle") for k in "xy"]) > 0
    begin = number_in(result, "x_low"), number_in(result, "y_low")
    kinds = {a["label"]: a["kind"] for a in result.wucht.summary["attractors"]}
    for samples, name in zip(result.attractor_states.values, result.attractor.values.astype(str), strict=True):
        look = _SADDLES[unstable[name]][1] if name in unstable else {}
        draw_limit_set(axis, samples[rows], turning, kinds[name], begin, color="black", **look)
