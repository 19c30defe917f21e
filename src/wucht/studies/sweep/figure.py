"""The figure of a sweep: a panel for each observable over the parameter, with the jumps; of equations maxima and ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import name_speeds
from wucht.plots.sheet import legend_below, legend_beside, new_figure
from wucht.plots.stability_lines import entry
from wucht.plots.style import COLOURS, FREE, GUIDE, line_style
from wucht.results.attributes import text_in
from wucht.results.formatting import label, parameter_in_words, printed_unit, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SENSE = {"up": "rising", "down": "falling"}  # of the swept parameter
_MOST_PANELS = 4
_PANEL, _PANEL_OF_STATES = 2.4, 1.9  # inches
_SIZES, _SIZE_OF_ALL = (1.5, 5.0), 240.0  # points: of a marker, and of the markers of all values together
_INNER = 0.6  # size of the markers of the falling sweep over that of the rising one, upon which they lie


def sweep_figure(result: xr.Dataset) -> Figure:
    """Draw a sweep of a machine, or of equations, from the Dataset alone."""
    is_machine = "speed" in result
    states = [] if is_machine else np.flatnonzero(result.is_angle.values == 0)[:_MOST_PANELS].tolist()
    panels, height = (2, _PANEL) if is_machine else (max(len(states), 1), _PANEL_OF_STATES)
    fig, axes = new_figure(panels, result.attrs["title"], answer_in_print(result), height)
    if is_machine:
        _draw_speed(axes[0], result)
        _draw_amplitude(axes[1], result)
        for axis in axes:
            legend_beside(axis)
    else:
        for axis, row in zip(axes, states, strict=False):
            _draw_state(axis, result, row)
        legend_below(fig, _entries(result))
    axes[-1].set_xlabel(with_unit(_parameter_words(result), result.attrs.get("along_unit", "")))
    return fig


def _parameter_words(result: xr.Dataset) -> str:
    return parameter_in_words(text_in(result, "along"), str(result.value.attrs["long_name"]))


def _draw_speed(axis: Axes, result: xr.Dataset) -> None:
    """Draw the speed on each way, the band of its modulation, its jumps, and the speed of the drive without vibration."""
    _draw_ways(axis, result, "speed")
    for i, way in enumerate(result.direction.values):
        ramp = result.sel(direction=way)
        colour = line_style(i)["color"]
        axis.fill_between(ramp.value, ramp.min_speed, ramp.max_speed, color=colour, alpha=0.25, linewidth=0)
    _draw_jumps(axis, result, result.jump_from.values, result.jump_to.values)
    low, high = axis.get_ylim()
    if np.isfinite(result.free_speed).any():
        axis.plot(result.grid, result.free_speed, label="no-load speed", zorder=1, **FREE)
        axis.set_ylim(low, max(high, min(high * 1.1, float(np.nanmax(result.free_speed)))))
    name_speeds(axis, result)


def _draw_amplitude(axis: Axes, result: xr.Dataset) -> None:
    scale, unit = printed_unit(result, "amplitude")
    _draw_ways(axis, result, "amplitude", scale)
    _draw_jumps(axis, result, scale * result.jump_from_amplitude.values, scale * result.jump_to_amplitude.values)
    axis.set(ylabel=label(result, "amplitude", unit), ylim=(0, None))
    axis.set_xlim(float(result.grid[0]), float(result.grid[-1]))


def _draw_ways(axis: Axes, result: xr.Dataset, name: str, scale: float = 1.0) -> None:
    for i, way in enumerate(str(d) for d in result.direction.values):
        ramp = result.sel(direction=way)
        style = line_style(i) | {"linewidth": 1.4, "label": SENSE[way], "zorder": 3 - 0.1 * i}
        axis.plot(ramp.value, scale * ramp[name], **style)


def _draw_jumps(axis: Axes, result: xr.Dataset, before: np.ndarray, after: np.ndarray) -> None:
    """Draw an arrow from the end of each branch to the state after the jump."""
    for k, at in enumerate(result.jump_value.values):
        colour = COLOURS[0] if result.jump_upward.values[k] else COLOURS[1]
        axis.plot([at], [before[k]], "o", color=colour, markersize=5, zorder=5, label="end of a branch" if k == 0 else None)
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.0, "shrinkA": 3, "shrinkB": 0}
        axis.annotate("", xy=(at, after[k]), xytext=(at, before[k]), zorder=5, arrowprops=arrow)


def _draw_state(axis: Axes, result: xr.Dataset, row: int) -> None:
    """Draw the range of a state and its maxima on each way, and where the motion jumps."""
    size = float(np.clip(_SIZE_OF_ALL / result.sizes["step"], *_SIZES))
    for k, value in enumerate(result.value.values):
        peaks, low, high = (result[name].values[k, row] for name in ("maxima", "low", "high"))
        axis.fill_between(value, low, high, color=COLOURS[k], alpha=0.15, linewidth=0)
        axis.plot(np.repeat(value, peaks.shape[1]), peaks.ravel(), **_marker(k, size * (_INNER if k else 1.0)))
    for jump in result.wucht.summary["jumps"]:
        axis.axvline(jump["value"], zorder=1, **GUIDE)
    axis.set_ylabel(str(result.state.values[row]))


def _entries(result: xr.Dataset) -> list[Any]:
    ways = [entry(f"maxima, {SENSE[str(way)]}", **_marker(k, _SIZES[1])) for k, way in enumerate(result.direction.values)]
    return ways + ([entry("jump", **GUIDE)] if result.wucht.summary["jumps"] else [])


def _marker(way: int, size: float) -> dict[str, Any]:
    return {"linestyle": "", "marker": "o", "color": COLOURS[way], "markeredgewidth": 0, "markersize": size}
