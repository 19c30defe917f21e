"""The figure of a run-up: speed, amplitude, phases, and motor power with the energy residual."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from wucht.results.conventions import summary_of
from wucht.results.style import (
    COLOURS,
    GREY,
    SLOW,
    angle_panel,
    draw_angles,
    label,
    line_style,
    new_figure,
    plain_decades,
    thinned,
)
from wucht.studies.run_up.figure_of_many import figure_of_many

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Course: TypeAlias = tuple[np.ndarray, np.ndarray]  # abscissa (N,) and angles (n, N)

_MOST_NAMES = 7  # bodies named one by one in a legend


def figure(result: xr.Dataset) -> Figure:
    """Four panels (three without balancing bodies) from a run-up's Dataset alone; two for many run-ups."""
    if "case" in result.dims:
        return figure_of_many(result)
    with_phases, with_rotors = "phase" in result, "rotor_phase" in result
    rows = 3 + with_phases + with_rotors
    drawn, axes = new_figure(
        rows,
        1.8 * rows + 1.0,
        result.attrs["title"],
        f"{result.attrs['outcome']}: {result.attrs['sentence']}",
    )
    at, name = abscissa(result)
    slow = abscissa(result, "slow_")[0] if "slow_speed" in result else None
    panels = iter(axes)
    _speed(next(panels), result, at, slow)
    _amplitude(next(panels), result, at, slow)
    if with_phases:
        _phases(next(panels), result, at, slow)
    if with_rotors:
        _rotor_phases(next(panels), result, at, slow)
    _power(next(panels), result, at)
    low, high = float(at.min()), float(at.max())
    for axis in axes if high > low else ():
        axis.set_xlim(low, high)
    axes[-1].set_xlabel(name)
    return drawn


def abscissa(result: xr.Dataset, model: str = "") -> tuple[np.ndarray, str]:
    """What the figure is drawn over (N,), and its name: time, the rotor's angle, or the mean phase of the bodies about it.

    model: ``"slow_"`` for the run of the slow equations.
    """
    over = json.loads(result.attrs["input"])["study"].get("over", "time")
    if over == "time":
        return result.time.values, label(result, "time") if result.time.attrs["units"] else "time $\\tau$"
    angle = result[f"{model}angle"].values
    rotor = angle[0]
    if over == "phi":
        return rotor - rotor[0], "angle of the rotor $\\varphi$ (rad)"
    return angle[_with_a_phase(result.phase)].mean(axis=0) - rotor, "mean phase of the bodies $\\psi$ (rad)"


def _with_a_phase(phase: xr.DataArray) -> np.ndarray:
    """Which bodies (n,) have a phase."""
    bodies: np.ndarray = np.isfinite(phase.values).any(axis=1)
    return bodies


def _legend(axis: Axes) -> None:
    axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8)


def _speed(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None) -> None:
    bodies = [str(b) for b in result.body.values]
    for i in range(min(len(bodies), _MOST_NAMES)):
        axis.plot(*thinned(time, result.speed.values[i]), label=bodies[i], **line_style(i), zorder=3 - 0.1 * i)
    if slow is not None:
        axis.plot(*thinned(slow, result.slow_speed.values[0]), label=f"{bodies[0]}, slow equations", **SLOW)
    free = float(result.free_speed)
    if np.isfinite(free):
        axis.axhline(free, color=GREY, linestyle="--", linewidth=0.9, label="no-load speed")
    if "vibration_frequency" in result and np.isfinite(float(result.vibration_frequency)):
        driven = float(result.vibration_frequency)
        axis.axhline(driven, color=COLOURS[3], linestyle="-.", linewidth=0.9, label="frequency of the vibration")
    natural = sorted({round(f, 9) for f in summary_of(result)["natural_frequencies"].values() if f is not None})
    sense = -1.0 if free < 0 else 1.0
    for k, frequency in enumerate(natural):
        name = ("natural frequencies" if len(natural) > 1 else "natural frequency") if k == 0 else None
        axis.axhline(sense * frequency, color=GREY, linestyle=":", linewidth=0.9, label=name)
    axis.set_ylabel(label(result, "speed"))
    _legend(axis)


def _amplitude(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None) -> None:
    dimensional = result.amplitude.attrs["units"] == "m"
    scale, unit = (1e3, "mm") if dimensional else (1.0, result.amplitude.attrs["units"])
    between = np.abs(result.amplitude.values - result.radius.values)
    if (between > 2e-2 * float(result.peak_amplitude)).any():
        axis.plot(*thinned(time, scale * result.radius.values), color=COLOURS[4], linewidth=0.4, label="distance")
    axis.plot(*thinned(time, scale * result.amplitude.values), color=COLOURS[0], linewidth=1.1, label="amplitude")
    if slow is not None:
        axis.plot(*thinned(slow, scale * result.slow_amplitude.values), label="slow equations", **SLOW)
    axis.set_ylabel(label(result, "amplitude", unit))
    axis.set_ylim(bottom=0)
    _legend(axis)


def _phases(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None) -> None:
    names, full, other = _of_bodies(result, "phase", slow)
    _angles(axis, (time, full), other, names, 1)
    axis.set_ylabel("phase to the rotor (°)")


def _rotor_phases(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None) -> None:
    shaken = bool(np.isfinite(float(result.vibration_frequency)))
    names, full, other = _of_bodies(result, "rotor_phase", slow)
    _angles(axis, (time, full), other, names, 0 if shaken else 1)
    axis.set_ylabel("phase to the vibration (°)" if shaken else f"phase to {result.body.values[0]} (°)")


def _of_bodies(result: xr.Dataset, name: str, slow: np.ndarray | None) -> tuple[list[str], np.ndarray, Course | None]:
    """The names of the bodies that have such a phase, their phases (n, N), and those of the averaged equations."""
    bodies = _with_a_phase(result[name])
    other = None if slow is None else (slow, result[f"slow_{name}"].values[bodies])
    return [str(b) for b in result.body.values[bodies]], result[name].values[bodies], other


def _angles(axis: Axes, full: Course, slow: Course | None, names: Sequence[str], first: int) -> None:
    """Phases of both models. first: the style of the first line."""
    begin = angle_panel(axis, np.degrees(full[1]))
    named = [{"label": name} if i < _MOST_NAMES else {} for i, name in enumerate(names)]
    draw_angles(axis, full[0], np.degrees(full[1]), begin, [n | line_style(i + first) for i, n in enumerate(named)])
    if slow is not None:
        styles = [SLOW | ({"label": "slow equations"} if i == 0 else {}) for i in range(len(names))]
        draw_angles(axis, slow[0], np.degrees(slow[1]), begin, styles)
    _legend(axis)


def _power(axis: Axes, result: xr.Dataset, time: np.ndarray) -> None:
    axis.plot(*thinned(time, result.motor_power.values), color=COLOURS[1], linewidth=1.0, label="motor power")
    axis.set_ylabel(label(result, "motor_power"))
    other = axis.twinx()
    other.spines["right"].set_visible(True)
    residual = np.maximum(result.energy_residual.values, 1e-18)
    other.semilogy(*thinned(time, residual), color=GREY, linewidth=0.6, linestyle="-", label="energy residual")
    other.set_ylim(1e-18, max(1e-8, 10 * float(residual.max(initial=0.0))))
    plain_decades(other.yaxis)
    other.set_ylabel("energy residual (1)")
    lines = [*axis.get_lines(), *other.get_lines()]
    axis.legend(
        lines,
        [str(line.get_label()) for line in lines],
        loc="center left",
        bbox_to_anchor=(1.14, 0.5),
        frameon=False,
        fontsize=8,
    )
