"""The figure of runs of equations of a table ``[system]``: each state over time, and what they tend to in two states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.curves import draw_swings, thin_curve
from wucht.plots.limit_set_curves import TRANSIENT, draw_limit_set, wrapped_curve
from wucht.plots.sheet import labelled_handles, legend_below, new_figure
from wucht.plots.style import COLOURS, MOST_LOOKS, line_style, shades
from wucht.results.attributes import text_in

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PANELS = 6
_PANEL, _PLANE = 1.1, 2.6  # inches
_MOST_TURNING_POINTS = 250  # of a curve that is drawn as a line
_FEW_PERIODS, _FEWER_PERIODS = 40, 12  # drawn of a motion that has settled: of one run, and of each of many
_SETTLED_SHARE = 1.5  # times the settling time: until then a run is drawn
_IRREGULAR = ("chaotic", "quasi-periodic")
_MOST_NAMED = 14  # of many runs


def system_run_figure(result: xr.Dataset) -> Figure:
    """Draw the states over time, and below two of them over each other; of many runs all in the same panels."""
    names = [str(n) for n in result.state.values]
    panels, plane = min(len(names), _MOST_PANELS), _plane(result)
    many = "case" in result.dims
    subtitle = str(result.attrs["sentence"]) if many else f"{text_in(result, 'outcome')}: {result.attrs['sentence']}"
    heights = [_PANEL] * panels + [_PLANE] * len(plane)
    fig, axes = new_figure(panels, result.attrs["title"], subtitle, heights, apart=len(plane))
    draw = _draw_many if many else _draw_one
    draw(axes[:panels], axes[panels:], plane, result)
    for axis, name in zip(axes[:panels], names, strict=False):
        axis.set_ylabel(name)
    axes[panels - 1].set_xlabel("time t")
    for axis, (across, upwards) in zip(axes[panels:], plane, strict=True):
        axis.set(xlabel=names[across], ylabel=names[upwards])
    if many:
        legend_below(fig, labelled_handles(axes[:1]))
    return fig


def _draw_one(courses: list[Axes], planes: list[Axes], pairs: list[tuple[int, int]], result: xr.Dataset) -> None:
    count = _sample_count(result, _settling_time(result.wucht.summary))
    time = result.time.values[:count]
    for k, axis in enumerate(courses):
        _draw_course(axis, time, result.states.values[k, :count])
    courses[0].set_xlim(time[0], time[-1] if len(time) > 1 else time[0] + 1.0)
    for axis, pair in zip(planes, pairs, strict=True):
        rows, limit = list(pair), result.limit_states.values[list(pair)]
        turning, outcome = result.is_angle.values[rows] > 0, text_in(result, "outcome")
        if outcome == "equilibrium" or not limit.shape[1]:
            axis.plot(*wrapped_curve(result.states.values[rows], turning), **TRANSIENT)
        if limit.shape[1]:
            draw_limit_set(axis, limit, turning, outcome)


def _draw_many(courses: list[Axes], planes: list[Axes], pairs: list[tuple[int, int]], result: xr.Dataset) -> None:
    cases = result.wucht.summary["cases"]
    few, tones = len(cases) <= MOST_LOOKS, shades(len(cases))
    runs = [result.isel(case=k, sample=np.isfinite(result.time.values[k])) for k in range(len(cases))]
    counts = [_sample_count(run, _settling_time(case), _FEWER_PERIODS) for run, case in zip(runs, cases, strict=True)]
    end = max(float(run.time.values[count - 1]) for run, count in zip(runs, counts, strict=True))
    for k, (case, run) in enumerate(zip(cases, runs, strict=True)):
        look: dict[str, Any] = line_style(k) | {"linewidth": 0.9} if few else {"color": tones[k], "linewidth": 0.6}
        inside = run.time.values <= end
        time, states = run.time.values[inside], run.states.values[:, inside]
        for i, axis in enumerate(courses):
            text = f"{case['label']}: {case['outcome']}" if few or k < _MOST_NAMED else None
            axis.plot(*thin_curve(time, states[i]), label=text, **look)
        for axis, pair in zip(planes, pairs, strict=True):
            rows = list(pair)
            turning, limit = result.is_angle.values[rows] > 0, run.limit_states.values[rows]
            axis.plot(
                *wrapped_curve(states[rows][:, : counts[k]], turning), **TRANSIENT | {"color": look["color"], "linewidth": 0.5}
            )
            if np.isfinite(limit).any():
                draw_limit_set(axis, limit, turning, case["outcome"], color=look["color"])
    courses[0].set_xlim(0.0, end or 1.0)


def _draw_course(axis: Axes, time: np.ndarray, values: np.ndarray) -> None:
    """Draw a state over time: a line as long as its oscillations can be told apart."""
    if np.count_nonzero(np.diff(np.sign(np.diff(values)))) > _MOST_TURNING_POINTS:
        draw_swings(axis, time, values, color=COLOURS[0], linewidth=0.9)
    else:
        axis.plot(*thin_curve(time, values), color=COLOURS[0], linewidth=0.9)


def _settling_time(summary: Mapping[str, Any]) -> float | None:
    """Return the time after which a motion is drawn no further: that of an irregular one says nothing of its course."""
    return 0.0 if summary["outcome"] in _IRREGULAR else summary["settling_time"]


def _sample_count(result: xr.Dataset, settled: float | None, periods: int = _FEW_PERIODS) -> int:
    """Return the number of samples that are drawn over time: until 1.5 times the settling time, and some oscillations."""
    time = result.time.values
    if settled is None:
        return len(time)
    deviation = result.states.values - result.states.values.mean(axis=1, keepdims=True)
    passages = ((deviation[:, :-1] < 0) & (deviation[:, 1:] >= 0)).cumsum(axis=1)
    oscillations = passages[int(passages[:, -1].argmax())] if passages.shape[1] else np.zeros(0)
    many = int(np.searchsorted(oscillations, periods)) + 2
    return min(len(time), max(many, int(np.searchsorted(time, _SETTLED_SHARE * settled)) + 1))


def _plane(result: xr.Dataset) -> list[tuple[int, int]]:
    """Return the pairs of states that are drawn over each other: the first two, and of more the first and the last one."""
    count = result.sizes["state"]
    return [] if count < 2 else [(0, 1)] if count == 2 else [(0, 1), (0, count - 1)]
