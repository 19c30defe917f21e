"""The figure of a sweep: speed and amplitude over the parameter, with the jumps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots.scales import name_speeds
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS, FREE, line_style
from wucht.results.attributes import text_in
from wucht.results.formatting import label, parameter_in_words, printed_unit, with_unit
from wucht.studies.sweep.computation import SENSE
from wucht.studies.sweep.system_sweep_figure import system_sweep_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def figure(result: xr.Dataset) -> Figure:
    """Draw two panels from a sweep's Dataset alone."""
    if "maxima" in result:
        return system_sweep_figure(result)
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
