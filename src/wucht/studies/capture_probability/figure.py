"""The figure of a probability over a parameter with its band, and of the indices of the sensitivity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import legend_above, legend_beside, new_grid
from wucht.plots.style import COLOURS, GREY
from wucht.results.conventions import summary_of
from wucht.results.formatting import named, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BAR = 0.36
_LOOKS = (("first_order", -0.5, COLOURS[4], "//", "alone (first order)"), ("total", 0.5, COLOURS[5], "", "with others (total)"))


def figure(result: xr.Dataset) -> Figure:
    """The probability with its band, the one that is wanted, and where it is reached; beside it Sobol' indices if asked."""
    s = summary_of(result)
    known = s["sensitivity"] is not None and s["sensitivity"]["indices"] is not None
    runs = f"{s['samples']} runs at each value, {s['runs']} in all"
    drawn, panels = new_grid(1 + known, result.attrs["title"], runs, columns=1 + known, heights=2.8)
    _probability(panels[0], result, s)
    if known:
        legend_above(panels[0])
        _indices(panels[1], result, s)
    else:
        legend_beside(panels[0])
    return drawn


def _probability(axis: Axes, result: xr.Dataset, s: dict[str, Any]) -> None:
    x, estimate, open_ = (result[n].values for n in ("parameter", "estimate", "not_identified"))
    searched = result.searched.values.astype(bool)
    band = f"{100 * s['confidence']:g} % confidence"
    axis.fill_between(x, result.low.values, result.high.values, color=COLOURS[0], alpha=0.25, linewidth=0, label=band)
    if open_.any():
        counted = np.nan_to_num(estimate) * (1 - open_)
        axis.fill_between(
            x, counted, counted + open_, facecolor="none", edgecolor=GREY, hatch="xxx", linewidth=0, label="no verdict"
        )
    axis.plot(x, estimate, color=COLOURS[0], linewidth=1.1)
    for chosen, mark, name in ((~searched, "o", "estimate"), (searched, "D", "of the search")):
        if chosen.any():
            face = COLOURS[0] if mark == "o" else "white"
            axis.plot(x[chosen], estimate[chosen], mark, color=COLOURS[0], markerfacecolor=face, markersize=3.5, label=name)
    if s["wanted"] is not None:
        axis.axhline(s["wanted"], color=GREY, linestyle=":", linewidth=1.1, label=f"wanted: {s['wanted']:g}")
    if s["smallest"] is not None:
        symbol = "" if "." in s["along"] else f"{s['along']} = "
        shown = f"{symbol}{s['smallest']:.4g} {s['unit']}".rstrip()
        axis.axvline(s["smallest"], color=COLOURS[1], linestyle="--", linewidth=1.1, label=f"reached at {shown}")
    axis.set(ylim=(-0.03, 1.03), ylabel="probability of\n" + " or ".join(s["outcome"]))
    axis.set_xlim(*s["range"])
    axis.set_xlabel(with_unit(named(s["along"], str(result.parameter.attrs["long_name"])), s["unit"]))


def _indices(axis: Axes, result: xr.Dataset, s: dict[str, Any]) -> None:
    """A pair of bars for each quantity, the one that matters most at the top."""
    order = np.argsort(-result.total.values, kind="stable")
    at = np.arange(len(order))
    for name, side, colour, hatch, words in _LOOKS:
        axis.barh(
            at + side * _BAR, result[name].values[order], _BAR, xerr=result[f"{name}_off"].values[order], color=colour,
            hatch=hatch, edgecolor=GREY, linewidth=0.6, error_kw={"linewidth": 0.9, "capsize": 3}, label=words, zorder=2,
        )  # fmt: skip
    axis.axvline(0.0, color=GREY, linewidth=0.7)
    axis.set_yticks(at, [str(result.quantity.values[k]) for k in order])
    axis.set_ylim(len(order) - 0.4, -0.6)
    axis.grid(visible=False, axis="y")
    axis.set_xlabel("Sobol' index")
    axis.set_title(f"what matters at {s['sensitivity']['at']:.4g} {s['unit']}".rstrip())
    legend_above(axis)
