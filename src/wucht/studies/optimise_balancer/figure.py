"""The figure of a search: the front in each pair of objectives, the present machine, all candidates; the damping curve."""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import label_one_two_five, limits_about
from wucht.plots.sheet import labelled_handles, legend_above, legend_below, new_grid
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import bodies_in_words, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKS = "os^Dv<>ph*"
_NAMES = {
    "settling-time": "median settling time", "residual": "residual unbalance", "peak": "peak amplitude",
    "capture-probability": "capture probability",
}  # fmt: skip
_PRINTED_UNITS = {"kg m": (1e6, "g mm"), "m": (1e3, "mm"), "": (100.0, "%")}
_BASELINE_STYLE: dict[str, Any] = {
    "marker": "X",
    "linestyle": "",
    "color": COLOURS[1],
    "markeredgecolor": "black",
    "markersize": 9,
    "zorder": 4,
}
_RECOMMENDED_STYLE: dict[str, Any] = {
    "marker": "*", "linestyle": "", "color": "gold", "markeredgecolor": "black", "markersize": 12, "zorder": 5,
}  # fmt: skip
_CAPTURE = "capture-probability"
_DECAY = math.log(100)  # a deviation has decayed to 1 %


def figure(result: xr.Dataset) -> Figure:
    """Draw, from the Dataset alone, a panel for each pair of objectives that vary, and the damping curve."""
    s = result.wucht.summary
    objectives = [str(o) for o in result.objective.values]
    varying_objectives = [o for o in s["objectives"] if _differs(result, objectives.index(o))] or s["objectives"][:1]
    pairs = list(combinations(varying_objectives, 2)) or [(varying_objectives[0], varying_objectives[0])]
    curve = "damping" in result.coords
    count = len(pairs) + curve
    fig, axes = new_grid(count, result.attrs["title"], answer_in_print(result), columns=min(2, count))
    for axis, (x, y) in zip(axes, pairs, strict=False):
        _plane(axis, result, s, objectives, x, y)
    if curve:
        _damping(axes[-1], result, s)
    legend_below(fig, labelled_handles(axes[:1]))
    return fig


def _differs(result: xr.Dataset, k: int) -> bool:
    """True if an objective varies over the drawn points."""
    baseline = result.own_objective.values[k : k + 1], result.own_checked.values[k : k + 1]
    values = np.concatenate([result.front_objective.values[:, k], result.front_checked.values[:, k], *baseline])
    values = values[np.isfinite(values)]
    return len(values) > 1 and bool(np.ptp(values) > 1e-9 * np.abs(values).max())


def _scale(s: dict[str, Any], objective: str) -> tuple[float, str]:
    unit = s["units"][objective]
    return _PRINTED_UNITS.get(unit, (1.0, unit))


def _plane(axis: Axes, result: xr.Dataset, s: dict[str, Any], objectives: list[str], x: str, y: str) -> None:
    i, j = objectives.index(x), objectives.index(y)
    (a, x_unit), (b, y_unit) = _scale(s, x), _scale(s, y)
    candidates = result.tried_objective.values
    axis.plot(a * candidates[:, i], b * candidates[:, j], ".", color="#BBBBBB", markersize=3, label="candidates", zorder=1)
    front, check_values = result.front_objective.values, result.front_checked.values
    for one, full in zip(front, check_values, strict=True):
        axis.plot(a * np.array([one[i], full[i]]), b * np.array([one[j], full[j]]), color=GREY, linewidth=0.5, zorder=2)
    counts = result.front_bodies.values
    for k, count in enumerate(s["numbers_of_bodies"]):
        if not (mine := counts == count).any():
            continue
        look: dict[str, Any] = {"marker": _MARKS[k % len(_MARKS)], "linestyle": "", "color": COLOURS[k % len(COLOURS)]}
        word, search_style = f"front, {bodies_in_words(count)}", look | {"fillstyle": "none", "markersize": 5}
        axis.plot(a * front[mine, i], b * front[mine, j], label=f"{word}: by the search", **search_style)
        axis.plot(
            a * check_values[mine, i], b * check_values[mine, j], label=f"{word}: checked", markersize=4, zorder=3, **look
        )
    is_checked = np.isfinite(result.own_checked.values[[i, j]]).all()
    baseline = result.own_checked.values if is_checked else result.own_objective.values
    axis.plot(a * baseline[i], b * baseline[j], label="present machine", **_BASELINE_STYLE)
    place = None if s["recommended"] is None else s["recommended"]["point"]
    if place is not None:
        axis.plot(a * check_values[place, i], b * check_values[place, j], label="recommended", **_RECOMMENDED_STYLE)
    baseline_undecided = s["as_it_is"]["checked_undecided" if is_checked else "undecided"]
    undecided_shares = np.r_[result.front_undecided.values, result.front_checked_undecided.values, baseline_undecided]
    points = np.concatenate([front, check_values, baseline[None]])[:, [i, j]] * [a, b]
    less = points - undecided_shares[:, None] * [a * (x == _CAPTURE), b * (y == _CAPTURE)]  # by runs without a verdict
    for most, least in zip(points, less, strict=True):
        axis.plot(*zip(least, most, strict=True), color=COLOURS[1], linewidth=1.5, zorder=2)
    around = np.stack([points, less])  # distant candidates would leave no room for the front
    axis.set(xlim=limits_about(around[..., 0]), ylim=limits_about(around[..., 1]))
    axis.set(xlabel=with_unit(_NAMES[x], x_unit), ylabel=with_unit(_NAMES[y], y_unit))


def _damping(axis: Axes, result: xr.Dataset, s: dict[str, Any]) -> None:
    """Draw settling times over the damping, and the decay time of a small deviation by the linearised equations."""
    damping, rate = result.damping.values, result.decay_rate.values
    settling, through = result.settling_time.values, result.through.values
    all_end = through >= np.nanmax(through)
    axis.plot(damping, np.where(all_end, settling, np.nan), "o-", color=COLOURS[0], markersize=3, linewidth=1.1, label="runs")
    if not all_end.all():
        look: dict[str, Any] = {"color": COLOURS[0], "fillstyle": "none", "markersize": 3, "linestyle": ""}
        axis.plot(damping[~all_end], settling[~all_end], "o", **look, label="more runs captured")
    with np.errstate(divide="ignore"):
        linear = np.where(rate > 0, _DECAY / rate, np.nan)
    axis.plot(damping, linear, "--", color="black", linewidth=0.9, label="linearised, to 1 %")
    _compared_dampings(axis, s)
    values = np.r_[result.settling_time.values, linear]
    values = values[np.isfinite(values) & (values > 0)]
    axis.set_xscale("log")
    label_one_two_five(axis.xaxis)
    if len(values):
        axis.set_yscale("log")
        label_one_two_five(axis.yaxis)
        axis.set_ylim(values.min() / 1.5, values.max() * 1.5)
    for best, colour, dashes, name in (("optimum", COLOURS[0], "-.", "of the runs"), ("of_rates", "black", ":", "linearised")):
        if s["damping"][best] is not None:
            axis.axvline(s["damping"][best], color=colour, linewidth=0.8, linestyle=dashes, label=f"best {name}")
    axis.set_xlabel(with_unit("damping of the bodies", str(result.damping.attrs["units"])))
    axis.set_ylabel(with_unit("median settling time", str(result.settling_time.attrs["units"])))
    legend_above(axis)


def _compared_dampings(axis: Axes, s: dict[str, Any]) -> None:
    """Draw settling times of the check, of those that differ from the present machine in the damping alone."""
    baseline, points = s["as_it_is"], list[tuple[float, float]]()
    rest = {name: x for name, x in baseline["parameters"].items() if name != "damping"}
    for row in s["compared"]:
        parameters = rest | row["parameters"]
        is_alone = row["bodies"] == baseline["bodies"] and all(math.isclose(parameters[n], x) for n, x in rest.items())
        if is_alone and "damping" in parameters and row["settling_time"] is not None:
            points.append((parameters["damping"], row["settling_time"]))
    if points:
        axis.plot(*zip(*points, strict=True), "D", color=COLOURS[1], markersize=4, zorder=3, label="checked")
