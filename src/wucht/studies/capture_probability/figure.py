"""The figure of a probability over a parameter with its band, and of the indices of the sensitivity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import legend_above, legend_beside, new_grid, write_counts
from wucht.plots.stability_lines import draw_classes
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import formula_in_print, parameter_in_words, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BAR = 0.36
_VISIBLE = 5e-4  # of the panel: a smaller area is a dot, which needs no name
_RIM = 0.015  # of the range of the parameter: at its ends, and the bar of a single value
_LOOKS = (("first_order", -0.5, COLOURS[4], "//", "alone (first order)"), ("total", 0.5, COLOURS[5], "", "with interactions"))


def figure(result: xr.Dataset) -> Figure:
    """Draw the probability with its band, its target, and where that is reached; beside it Sobol' indices, if computed."""
    s = result.wucht.summary
    has_indices = s["sensitivity"] is not None and s["sensitivity"]["indices"] is not None
    fig, panels = new_grid(
        1 + has_indices, result.attrs["title"], answer_in_print(result), columns=1 + has_indices, heights=2.8
    )
    write_counts(fig, f"{s['samples']} runs at each value, {s['runs']} in all")
    _draw_probability(panels[0], result, s)
    (legend_above if has_indices else legend_beside)(panels[0])
    if has_indices:
        _draw_indices(panels[1], result, s)
    return fig


def _draw_probability(axis: Axes, result: xr.Dataset, s: dict[str, Any]) -> None:
    x, estimate, open_ = (result[n].values for n in ("parameter", "estimate", "not_identified"))
    is_from_search, blue = result.searched.values.astype(bool), COLOURS[0]
    band = f"{100 * s['confidence']:g} % confidence"
    _fill(axis, x, result.low.values, result.high.values, s["range"], color=blue, alpha=0.25, linewidth=0, label=band)
    if _share_of_panel(x, open_, s["range"]) >= _VISIBLE:
        look: dict[str, Any] = {"hatch": "xxx", "linewidth": 0}
        counted_share = np.nan_to_num(estimate) * (1 - open_)
        look |= {"facecolor": "none", "edgecolor": GREY, "label": "no verdict"}
        _fill(axis, x, counted_share, counted_share + open_, s["range"], **look)
    axis.plot(x, estimate, color=blue, linewidth=1.1)
    is_finite = np.isfinite(estimate)
    classes = (
        (is_finite & ~is_from_search, "o", blue, "estimate"),
        (is_finite & is_from_search, "D", "white", "of the search"),
    )
    draw_classes(axis, x, estimate, classes, color=blue, markersize=3.5)
    if s["wanted"] is not None:
        axis.axhline(s["wanted"], color=GREY, linestyle=":", linewidth=1.1, label=f"target: {s['wanted']:g}")
    if s["smallest"] is not None:
        symbol = "" if "." in s["along"] else f"{s['along']} = "
        value_text = f"{symbol}{s['smallest']:.4g} {s['unit']}".rstrip()
        axis.axvline(s["smallest"], color=COLOURS[1], linestyle="--", linewidth=1.1, label=f"reached at {value_text}")
    low, high = s["range"]
    rim = _RIM * (high - low)  # points at the ends are shown whole
    axis.set(ylim=(-0.03, 1.03), ylabel="probability of\n" + " or ".join(s["outcome"]), xlim=(low - rim, high + rim))
    axis.set_xlabel(with_unit(parameter_in_words(s["along"], str(result.parameter.attrs["long_name"])), s["unit"]))


def _share_of_panel(x: np.ndarray, height: np.ndarray, ends: list[float]) -> float:
    """Return the area of a band over values (N,) of the parameter, as ``_fill`` draws it, over that of the panel."""
    area = ((height[1:] + height[:-1]) / 2 * np.diff(x)).sum() / (ends[1] - ends[0])
    return float(_RIM * height[0] if len(x) == 1 else area)


def _fill(axis: Axes, x: np.ndarray, low: np.ndarray, high: np.ndarray, ends: list[float], **look: Any) -> None:
    """Fill a band over values (N,) of the parameter; of a single value, which has no width, a bar of some."""
    if len(x) == 1:
        half = _RIM / 2 * (ends[1] - ends[0])
        x, low, high = np.r_[x - half, x + half], np.repeat(low, 2), np.repeat(high, 2)
    axis.fill_between(x, low, high, **look)


def _draw_indices(axis: Axes, result: xr.Dataset, s: dict[str, Any]) -> None:
    """Draw a pair of bars for each quantity, the most influential at the top."""
    order = np.argsort(-result.total.values, kind="stable")
    at = np.arange(len(order))
    for name, side, colour, hatch, words in _LOOKS:
        axis.barh(
            at + side * _BAR, result[name].values[order], _BAR, xerr=result[f"{name}_off"].values[order], color=colour,
            hatch=hatch, edgecolor=GREY, linewidth=0.6, error_kw={"linewidth": 0.9, "capsize": 3}, label=words, zorder=2,
        )  # fmt: skip
    axis.axvline(0.0, color=GREY, linewidth=0.7)
    axis.set_yticks(at, [formula_in_print(str(result.quantity.values[k])) for k in order])
    axis.grid(visible=False, axis="y")
    axis.set(ylim=(len(order) - 0.4, -0.6), xlabel="Sobol' index", ylabel="random quantity")
    axis.set_title(f"sensitivity at {s['sensitivity']['at']:.4g} {s['unit']}".rstrip())
    legend_above(axis)
