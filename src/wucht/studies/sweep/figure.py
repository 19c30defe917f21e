"""The figures of a sweep: speed and amplitude over the parameter, with the jumps; of equations maxima and ranges of states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import name_speeds
from wucht.plots.sheet import legend_below, legend_beside, new_figure
from wucht.plots.stability_lines import entry
from wucht.plots.style import COLOURS, FREE, GUIDE, line_style
from wucht.results.attributes import text_in
from wucht.results.formatting import label, parameter_in_words, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SENSE = {"up": "rising", "down": "falling"}  # of the swept parameter
_MOST_PANELS = 4
_PANEL = 1.9  # inches
_SIZES, _SIZE_OF_ALL = (1.5, 5.0), 240.0  # points: of a marker, and of the markers of all values together
_INNER = 0.6  # size of the markers of the falling sweep over that of the rising one, upon which they lie


def sweep_figure(result: xr.Dataset) -> Figure:
    """Draw a sweep of a machine, or of equations."""
    return _draw_states(result) if "maxima" in result else _draw_machine(result)


def _draw_machine(result: xr.Dataset) -> Figure:
    fig, (speed, amplitude) = new_figure(2, result.attrs["title"], _subtitle(result), 2.4)
    scale, unit = printed_unit(result, "amplitude")
    for i, way in enumerate(str(d) for d in result.direction.values):
        ramp = result.sel(direction=way)
        style = line_style(i) | {"linewidth": 1.4, "label": SENSE[way], "zorder": 3 - 0.1 * i}
        speed.plot(ramp.value, ramp.speed, **style)
        amplitude.plot(ramp.value, scale * ramp.amplitude, **style)
        speed.fill_between(ramp.value, ramp.min_speed, ramp.max_speed, color=style["color"], alpha=0.25, linewidth=0)
    _draw_jumps(speed, result, result.jump_from.values, result.jump_to.values)
    _draw_jumps(amplitude, result, scale * result.jump_from_amplitude.values, scale * result.jump_to_amplitude.values)
    low, high = speed.get_ylim()
    if np.isfinite(result.free_speed).any():
        speed.plot(result.grid, result.free_speed, label="no-load speed", zorder=1, **FREE)
        speed.set_ylim(low, max(high, min(high * 1.1, float(np.nanmax(result.free_speed)))))
    name_speeds(speed, result)
    amplitude.set(ylabel=label(result, "amplitude", unit), ylim=(0, None))
    amplitude.set_xlim(float(result.grid[0]), float(result.grid[-1]))
    amplitude.set_xlabel(with_unit(_parameter_words(result), text_in(result, "along_unit")))
    for axis in (speed, amplitude):
        legend_beside(axis)
    return fig


def _subtitle(result: xr.Dataset) -> str:
    """Values of the jumps; without jumps the answer in words."""
    jumps, along, unit = result.wucht.summary["jumps"], text_in(result, "along"), text_in(result, "along_unit")
    if not jumps or not result.attrs["finished"]:
        return str(result.attrs["sentence"])
    values = [f"{f'{j[along]:.6g} {unit}'.rstrip()} ({SENSE[j['direction']]})" for j in jumps]
    return f"it jumps at {_parameter_words(result)} = {' and '.join(values[:2])}" + (", ..." if len(values) > 2 else "")


def _parameter_words(result: xr.Dataset) -> str:
    return parameter_in_words(text_in(result, "along"), str(result.grid.attrs["long_name"]))


def _draw_jumps(axis: Axes, result: xr.Dataset, before: np.ndarray, after: np.ndarray) -> None:
    """Draw an arrow from the end of each branch to the state after the jump."""
    for k, at in enumerate(result.jump_value.values):
        colour = COLOURS[0] if result.jump_upward.values[k] else COLOURS[1]
        axis.plot([at], [before[k]], "o", color=colour, markersize=5, zorder=5, label="end of a branch" if k == 0 else None)
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.0, "shrinkA": 3, "shrinkB": 0}
        axis.annotate("", xy=(at, after[k]), xytext=(at, before[k]), zorder=5, arrowprops=arrow)


def _draw_states(result: xr.Dataset) -> Figure:
    """Draw a panel for each state that is no angle."""
    rows = np.flatnonzero(result.is_angle.values == 0)[:_MOST_PANELS]
    fig, axes = new_figure(max(len(rows), 1), result.attrs["title"], result.attrs["sentence"], _PANEL)
    size = float(np.clip(_SIZE_OF_ALL / result.sizes["step"], *_SIZES))
    ways = [str(d) for d in result.direction.values]
    jumps = result.wucht.summary["jumps"]
    for i, axis in zip(rows.tolist(), axes, strict=False):
        for k in range(len(ways)):
            value, peaks = result.value.values[k], result.maxima.values[k, i]
            low, high = result.low.values[k, i], result.high.values[k, i]
            axis.fill_between(value, low, high, color=COLOURS[k], alpha=0.15, linewidth=0)
            look = _marker(k) | {"markersize": size * (_INNER if k else 1.0)}
            axis.plot(np.repeat(value, peaks.shape[1]), peaks.ravel(), **look)
        for jump in jumps:
            axis.axvline(jump["value"], zorder=1, **GUIDE)
        axis.set_ylabel(str(result.state.values[i]))
    axes[-1].set_xlabel(text_in(result, "along"))
    handles = [entry(f"maxima, {SENSE[way]}", **_marker(k), markersize=_SIZES[1]) for k, way in enumerate(ways)]
    legend_below(fig, handles + ([entry("jump", **GUIDE)] if jumps else []))
    return fig


def _marker(way: int) -> dict[str, Any]:
    return {"linestyle": "", "marker": "o", "color": COLOURS[way], "markeredgewidth": 0}
