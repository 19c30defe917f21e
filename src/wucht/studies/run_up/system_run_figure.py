"""The figure of a run of equations of a table ``[system]``: each state over time, and what it tends to in two states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.curves import draw_swings, thin_curve
from wucht.plots.sheet import new_figure
from wucht.plots.style import COLOURS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PANELS = 6
_PANEL, _PLANE = 1.1, 2.6  # inches
_MOST_TURNING_POINTS = 250  # of a curve that is drawn as a line
_FEW_PERIODS = 40  # of a motion that has settled
_SETTLED_SHARE = 1.5  # times the settling time: until then a run is drawn


def system_run_figure(result: xr.Dataset) -> Figure:
    """Draw the states over time, and below two of them over each other."""
    names = [str(n) for n in result.state.values]
    panels, plane = min(len(names), _MOST_PANELS), _plane(result)
    subtitle = f"{result.attrs['outcome']}: {result.attrs['sentence']}"
    heights = [_PANEL] * panels + [_PLANE] * len(plane)
    fig, axes = new_figure(panels, result.attrs["title"], subtitle, heights, apart=len(plane))
    count = _sample_count(result)
    time = result.time.values[:count]
    for k, axis in enumerate(axes[:panels]):
        _draw_course(axis, time, result.states.values[k, :count])
        axis.set_ylabel(names[k])
    axes[panels - 1].set_xlabel("time t")
    axes[0].set_xlim(time[0], time[-1] if len(time) > 1 else time[0] + 1.0)
    for axis, pair in zip(axes[panels:], plane, strict=True):
        _draw_plane(axis, result, pair)
    return fig


def _draw_course(axis: Axes, time: np.ndarray, values: np.ndarray) -> None:
    """Draw a state over time: a line as long as its oscillations can be told apart."""
    if np.count_nonzero(np.diff(np.sign(np.diff(values)))) > _MOST_TURNING_POINTS:
        draw_swings(axis, time, values, color=COLOURS[0], linewidth=0.9)
    else:
        axis.plot(*thin_curve(time, values), color=COLOURS[0], linewidth=0.9)


def _sample_count(result: xr.Dataset) -> int:
    """Return the number of samples that are drawn over time: until 1.5 times the settling time, and forty oscillations."""
    time, settled = result.time.values, result.wucht.summary["settling_time"]
    if settled is None:
        return len(time)
    deviation = result.states.values - result.states.values.mean(axis=1, keepdims=True)
    passages = ((deviation[:, :-1] < 0) & (deviation[:, 1:] >= 0)).cumsum(axis=1)
    oscillations = passages[int(passages[:, -1].argmax())] if passages.shape[1] else np.zeros(0)
    many = int(np.searchsorted(oscillations, _FEW_PERIODS)) + 2
    return int(min(len(time), max(many, np.searchsorted(time, _SETTLED_SHARE * settled) + 1)))


def _plane(result: xr.Dataset) -> list[tuple[int, int]]:
    """Return the pairs of states that are drawn over each other: the first two, and of more the first and the last one."""
    count = result.sizes["state"]
    return [] if count < 2 else [(0, 1)] if count == 2 else [(0, 1), (0, count - 1)]


def _draw_plane(axis: Axes, result: xr.Dataset, pair: tuple[int, int]) -> None:
    turning, names = result.is_angle.values, result.state.values
    run, limit = result.states.values[list(pair)], result.limit_states.values[list(pair)]
    is_point = limit.shape[1] == 1
    if is_point or not limit.shape[1]:
        _curve(axis, run, turning[list(pair)], color="#9A9A9A", linewidth=0.6)
    if is_point:
        axis.plot(*_wrap(limit, turning[list(pair)]), "o", color=COLOURS[1], markersize=5)
    elif result.attrs["outcome"] == "periodic":
        _curve(axis, limit, turning[list(pair)], color=COLOURS[1], linewidth=1.4)
    else:
        axis.plot(*_wrap(limit, turning[list(pair)]), ".", color=COLOURS[1], markersize=0.8, markeredgewidth=0)
    axis.set(xlabel=str(names[pair[0]]), ylabel=str(names[pair[1]]))


def _wrap(states: np.ndarray, turning: np.ndarray) -> np.ndarray:
    """Return states (2, N) with angles in [-pi, pi)."""
    return np.where(turning[:, None] > 0, np.remainder(states + np.pi, 2 * np.pi) - np.pi, states)


def _curve(axis: Axes, states: np.ndarray, turning: np.ndarray, **look: Any) -> None:
    """Draw a curve (2, N), interrupted where an angle is curve."""
    curve = _wrap(states, turning)
    jumps = (np.abs(np.diff(curve, axis=1)) > np.pi) & (turning[:, None] > 0)
    gaps = np.flatnonzero(jumps.any(axis=0)) + 1
    axis.plot(*np.insert(curve, gaps, np.nan, axis=1), **look)
