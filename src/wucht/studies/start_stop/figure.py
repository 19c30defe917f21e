"""The figure of a cycle up and down: speeds, amplitude, energy from the supply, and the damage so far."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.sheet import leading_clauses, legend_beside, new_figure
from wucht.plots.style import COLOURS, line_style, mark_levels
from wucht.results.formatting import abscissa_label, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OFF: dict[str, Any] = {"color": "black", "linestyle": "--", "linewidth": 0.9}
_SLOW = 0.05  # of the highest speed: slower than that nothing is drawn
_KILO = 1e4  # J: from there on in kJ


def figure(result: xr.Dataset) -> Figure:
    """Draw panels over the time of the cycle, from the Dataset alone."""
    panels = [_speeds, _amplitude, _energy, *([_damage] if "damage_course" in result else [])]
    fig, axes = new_figure(len(panels), result.attrs["title"], leading_clauses(result.attrs["sentence"]), 1.6)
    summary = result.wucht.summary
    for draw, axis in zip(panels, axes, strict=True):
        axis.axvline(summary["switch_off_time"], label="switched off" if axis is axes[0] else None, **_OFF)
        draw(axis, result)
        legend_beside(axis)
    fast = np.abs(result.rotor_speed.values).max(axis=0)
    end = float(result.time.values[fast >= _SLOW * fast.max()][-1])
    if end > 0:
        axes[-1].set_xlim(0.0, end)
    axes[-1].set_xlabel(abscissa_label(result, "time"))
    return fig


def _speeds(axis: Axes, result: xr.Dataset) -> None:
    """Draw the speeds, forwards, and the natural frequencies."""
    for k, name in enumerate(map(str, result.rotor.values)):
        axis.plot(result.time, np.abs(result.rotor_speed[k]), label=name, **line_style(k))
    highest = float(np.abs(result.rotor_speed).max())
    natural = np.unique(np.round(result.natural_frequency.values, 9))
    visible = natural[natural <= 1.05 * highest]
    mark_levels(axis, visible, "natural frequency" if len(visible) == 1 else "natural frequencies")
    axis.set_ylim(bottom=0)
    name_speeds(axis, result, "rotor_speed")


def _amplitude(axis: Axes, result: xr.Dataset) -> None:
    values, name = printed_values(result, "amplitude")
    axis.plot(result.time, values, color=COLOURS[0], linewidth=1.1, label="amplitude")
    off, time = result.wucht.summary["switch_off_time"], result.time.values
    for marker, phase, inside in (("o", "up", time <= off), ("s", "down", time > off)):
        if inside.any() and values[inside].max() > 0:
            at = int(np.flatnonzero(inside)[values[inside].argmax()])
            axis.plot([time[at]], [values[at]], marker, color=COLOURS[1], markersize=4.5, label=f"largest on the way {phase}")
    axis.set(ylabel=name, ylim=(0, None))


def _energy(axis: Axes, result: xr.Dataset) -> None:
    largest, unit = float(np.abs(result.supplied_energy).max()), str(result.supplied_energy.attrs["units"])
    factor, unit = (1e-3, "kJ") if unit == "J" and largest >= _KILO else (1.0, unit)
    curves = {"supplied_energy": "from the supply", "shaft_work_course": "work on the shafts"}
    for k, (name, words) in enumerate(curves.items()):
        axis.plot(result.energy_time, factor * result[name], label=words, **line_style(k))
    axis.set_ylabel(with_unit("energy", unit))


def _damage(axis: Axes, result: xr.Dataset) -> None:
    axis.plot(result.damage_time, result.damage_course, color=COLOURS[1], linewidth=1.1, label="damage so far")
    axis.set(ylabel="damage so far", ylim=(0, None))
