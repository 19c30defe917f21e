"""The figure of a search: the front over each two objectives, the machine as it is, all that was tried; the damping curve."""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import summary_of
from wucht.results.style import COLOURS, GREY, new_grid, plain_decades, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKS = "os^Dv<>ph*"
_NAMES = {
    "settling-time": "settling time",
    "residual": "unbalance left",
    "peak": "peak amplitude",
    "capture-probability": "do not end well",
}
_PRINTED = {"kg m": (1e6, "g mm"), "m": (1e3, "mm"), "": (100.0, "%")}
_DECAYED = math.log(100)  # a deviation has decayed to 1 %


def figure(result: xr.Dataset) -> Figure:
    """From the Dataset alone: panels of two objectives each that differ at all, and the damping curve."""
    s = summary_of(result)
    objectives = [str(o) for o in result.objective.values]
    shown = [o for o in s["objectives"] if _differs(result, objectives.index(o))] or s["objectives"][:1]
    pairs = list(combinations(shown, 2)) or [(shown[0], shown[0])]
    curve = "damping" in result.coords
    count = len(pairs) + curve
    rows = math.ceil(count / 2)
    height = 1.7 + 2.5 * rows
    drawn, axes = new_grid(rows, min(2, count), height, result.attrs["title"], s["sentence"])
    drawn.subplots_adjust(hspace=0.36, wspace=0.26)
    for axis, (x, y) in zip(axes, pairs, strict=False):
        _plane(axis, result, s, objectives, x, y)
    if curve:
        _damping(axes[len(pairs)], result, s)
    for axis in axes[count:]:
        axis.set_axis_off()
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.08, 0.0), ncols=3, frameon=False, fontsize=8)
    return drawn


def _differs(result: xr.Dataset, k: int) -> bool:
    """Whether an objective is not the same for all that is shown."""
    values = np.concatenate([result.front_objective.values[:, k], result.own_objective.values[k : k + 1]])
    values = values[np.isfinite(values)]
    return len(values) > 1 and bool(np.ptp(values) > 1e-9 * np.abs(values).max())


def _scale(s: dict[str, Any], objective: str) -> tuple[float, str]:
    unit = s["units"][objective]
    return _PRINTED.get(unit, (1.0, unit))


def _plane(axis: Axes, result: xr.Dataset, s: dict[str, Any], objectives: list[str], x: str, y: str) -> None:
    i, j = objectives.index(x), objectives.index(y)
    (a, x_unit), (b, y_unit) = _scale(s, x), _scale(s, y)
    tried = result.tried_objective.values
    axis.plot(a * tried[:, i], b * tried[:, j], ".", color="#BBBBBB", markersize=3, label="tried", zorder=1)
    front, checked = result.front_objective.values, result.front_checked.values
    for one, full in zip(front, checked, strict=True):
        axis.plot(a * np.array([one[i], full[i]]), b * np.array([one[j], full[j]]), color=GREY, linewidth=0.5, zorder=2)
    counts = result.front_bodies.values
    for k, count in enumerate(s["numbers_of_bodies"]):
        mine = counts == count
        look: dict[str, Any] = {"marker": _MARKS[k % len(_MARKS)], "linestyle": "", "color": COLOURS[k % len(COLOURS)]}
        word = "1 body" if count == 1 else f"{count} bodies"
        axis.plot(
            a * front[mine, i],
            b * front[mine, j],
            **look,
            fillstyle="none",
            markersize=5,
            label=f"front, {word}: by the search",
        )
        axis.plot(a * checked[mine, i], b * checked[mine, j], **look, markersize=4, label=f"{word}: full equations", zorder=3)
    own = result.own_checked.values if np.isfinite(result.own_checked.values[[i, j]]).all() else result.own_objective.values
    axis.plot(
        a * own[i], b * own[j], "X", color="#D55E00", markeredgecolor="black", markersize=9, label="machine as it is", zorder=4
    )
    _limits(axis.set_xlim, a * np.r_[front[:, i], checked[:, i], own[i]])
    _limits(axis.set_ylim, b * np.r_[front[:, j], checked[:, j], own[j]])
    axis.set_xlabel(with_unit(_NAMES[x], x_unit))
    axis.set_ylabel(with_unit(_NAMES[y], y_unit))


def _limits(set_limits: Any, values: np.ndarray) -> None:
    """Room about what counts: candidates that are far off would leave no room for the front."""
    values = values[np.isfinite(values)]
    if len(values):
        low, high = float(values.min()), float(values.max())
        room = 0.08 * (high - low) or 0.1 * abs(high) or 1.0
        set_limits(low - room, high + 2 * room)


def _damping(axis: Axes, result: xr.Dataset, s: dict[str, Any]) -> None:
    """Settling times over the damping, and how long linearised equations say that a small deviation takes."""
    from matplotlib.ticker import LogLocator, NullFormatter

    damping, rate = result.damping.values, result.decay_rate.values
    settling, well = result.settling_time.values, result.well.values
    all_end = well >= np.nanmax(well)
    axis.plot(damping, np.where(all_end, settling, np.nan), "o-", color=COLOURS[0], markersize=3, linewidth=1.1, label="runs")
    if not all_end.all():
        look: dict[str, Any] = {"color": COLOURS[0], "fillstyle": "none", "markersize": 3, "linestyle": ""}
        axis.plot(damping[~all_end], settling[~all_end], "o", **look, label="fewer runs end in time")
    with np.errstate(divide="ignore"):
        linear = np.where(rate > 0, _DECAYED / rate, np.nan)
    axis.plot(damping, linear, "--", color="black", linewidth=0.9, label="linearised, to 1 %")
    values = np.r_[result.settling_time.values, linear]
    values = values[np.isfinite(values) & (values > 0)]
    axis.set_xscale("log")
    plain_decades(axis.xaxis)
    if len(values):
        axis.set_yscale("log")
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.yaxis.set_major_formatter(lambda value, _position: f"{value:g}")
        axis.yaxis.set_minor_formatter(NullFormatter())
        axis.set_ylim(values.min() / 1.5, values.max() * 1.5)
    if s["damping"]["optimum"] is not None:
        axis.axvline(s["damping"]["optimum"], color=COLOURS[0], linewidth=0.8, linestyle=":")
    if s["damping"]["of_rates"] is not None:
        axis.axvline(s["damping"]["of_rates"], color="black", linewidth=0.8, linestyle=":")
    axis.set_xlabel(with_unit("damping of the bodies", str(result.damping.attrs["units"])))
    axis.set_ylabel(with_unit("settling time", str(result.settling_time.attrs["units"])))
    axis.legend(frameon=False, fontsize=8, loc="upper center")
