"""Runs of equations of a table ``[system]``: each state over time, and what they tend to in two states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.curves import draw_swings, thin_curve
from wucht.plots.limit_set_curves import TRANSIENT, draw_limit_set, wrapped_curve
from wucht.plots.sheet import labelled_handles, legend_below, new_figure
from wucht.plots.style import COLOURS, looks_of_many
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MOST_PANELS = 6
_PANEL, _PLANE = 1.1, 2.6  # inches
_MOST_TURNING_POINTS = 250  # of a curve that is drawn as a line
_FEW_PERIODS, _FEWER_PERIODS = 40, 12  # drawn of a motion that has settled: of one run, and of each of many
_SETTLED_SHARE = 1.5  # times the settling time: until then a run is drawn
_IRREGULAR = ("chaotic", "quasi-periodic")


def figure_of_states(result: xr.Dataset) -> Figure:
    """Draw the states over time, and below two of them over each other; of many runs all in the same panels."""
    names, many = [str(n) for n in result.state.values], "case" in result.dims
    cases: list[Mapping[str, Any]] = result.wucht.summary["cases"] if many else [result.wucht.summary]
    pairs = [[0, k] for k in dict.fromkeys((1, len(names) - 1)) if 0 < k < len(names)]
    heights = [_PANEL] * min(len(names), _MOST_PANELS) + [_PLANE] * len(pairs)
    fig, axes = new_figure(len(heights) - len(pairs), result.attrs["title"], answer_in_print(result), heights, apart=len(pairs))
    courses, planes = axes[: len(axes) - len(pairs)], axes[len(axes) - len(pairs) :]
    runs = [result.isel(case=k, sample=np.isfinite(result.time.values[k])) for k in range(len(cases))] if many else [result]
    counts = [_sample_count(*one, _FEWER_PERIODS if many else _FEW_PERIODS) for one in zip(runs, cases, strict=True)]
    end = max(float(run.time.values[count - 1]) for run, count in zip(runs, counts, strict=True))
    looks: list[dict[str, Any]] = [{"color": COLOURS[0], "linewidth": 0.9}]
    if many:
        looks = looks_of_many([f"{case['label']}: {case['outcome']}" for case in cases], (0.9, 0.6))
    for run, case, count, look in zip(runs, cases, counts, looks, strict=True):
        inside = run.time.values <= end
        for axis, values in zip(courses, run.states.values[:, inside], strict=False):
            if not many and np.count_nonzero(np.diff(np.sign(np.diff(values)))) > _MOST_TURNING_POINTS:
                draw_swings(axis, run.time.values[inside], values, **look)
            else:
                axis.plot(*thin_curve(run.time.values[inside], values), **look)
        tone, until = ({"color": look["color"], "linewidth": 0.5}, count) if many else ({}, None)
        for axis, rows in zip(planes, pairs, strict=True):
            turning, limit = result.is_angle.values[rows] > 0, run.limit_states.values[rows]
            if many or case["outcome"] == "equilibrium" or not limit.shape[1]:
                axis.plot(*wrapped_curve(run.states.values[rows, :until], turning), **TRANSIENT | tone)
            if np.isfinite(limit).any():
                draw_limit_set(axis, limit, turning, case["outcome"], color=look["color"] if many else COLOURS[1])
    courses[0].set_xlim(0.0, end or 1.0)
    courses[-1].set_xlabel("time t")
    for axis, name in zip(courses, names, strict=False):
        axis.set_ylabel(name)
    for axis, (across, upwards) in zip(planes, pairs, strict=True):
        axis.set(xlabel=names[across], ylabel=names[upwards])
    if many:
        legend_below(fig, labelled_handles(courses[:1]))
    return fig


def _sample_count(result: xr.Dataset, summary: Mapping[str, Any], periods: int) -> int:
    """Return the number of samples that are drawn over time: until 1.5 times the settling time, and some oscillations.

    The settling time of an irregular motion says nothing of its course.
    """
    time, settled = result.time.values, 0.0 if summary["outcome"] in _IRREGULAR else summary["settling_time"]
    if settled is None:
        return len(time)
    deviation = result.states.values - result.states.values.mean(axis=1, keepdims=True)
    passages = ((deviation[:, :-1] < 0) & (deviation[:, 1:] >= 0)).cumsum(axis=1)
    oscillations = passages[int(passages[:, -1].argmax())] if passages.shape[1] else np.zeros(0)
    many = int(np.searchsorted(oscillations, periods)) + 2
    return min(len(time), max(many, int(np.searchsorted(time, _SETTLED_SHARE * settled)) + 1))
