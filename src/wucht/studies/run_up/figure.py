"""The figure of a run-up: speed, amplitude, phases, and motor power with the energy residual; of many, speed and amplitude."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from wucht.results import style
from wucht.results.conventions import summary_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_NAMES = 7  # bodies with a name each in a legend
_MOST_NAMED, _LONG, _HEIGHT = 14, 40, 6.4  # of many runs


def figure(result: xr.Dataset) -> Figure:
    """Four panels (three without balancing bodies) from a run-up's Dataset alone; two for many run-ups."""
    if "case" in result.dims:
        return _figure_of_many(result)
    angles = [name for name in ("phase", "rotor_phase") if name in result]
    rows, subtitle = 3 + len(angles), f"{result.attrs['outcome']}: {result.attrs['sentence']}"
    drawn, axes = style.new_figure(rows, 1.8 * rows + 1.0, result.attrs["title"], subtitle)
    at, name = abscissa(result)
    slow = abscissa(result, "slow_")[0] if "slow_speed" in result else None
    _speed(axes[0], result, at, slow)
    _amplitude(axes[1], result, at, slow)
    for axis, of in zip(axes[2:], angles, strict=False):
        _phases(axis, result, of, at, slow)
    for axis in axes[:-1]:
        style.legend_beside(axis)
    _power(axes[-1], result, at)
    low, high = float(at.min()), float(at.max())
    for axis in axes if high > low else ():
        axis.set_xlim(low, high)
    axes[-1].set_xlabel(name)
    return drawn


def abscissa(result: xr.Dataset, model: str = "") -> tuple[np.ndarray, str]:
    """What the figure is drawn over (N,), and its name: time, the rotor's angle, or the mean phase of the bodies about it.

    model: ``"slow_"`` for the run of the averaged equations.
    """
    over = json.loads(result.attrs["input"])["study"].get("over", "time")
    if over == "time":
        return result.time.values, style.abscissa_label(result, "time")
    if over == "phi":
        return rotor_angle(result, model), "angle of the rotor $\\varphi$ (rad)"
    return mean_phase(result, model), "mean phase of the bodies $\\psi$ (rad)"


def rotor_angle(result: xr.Dataset, model: str) -> np.ndarray:
    """By how much (N,) the rotor has turned."""
    rotor = result[f"{model}angle"].values[0]
    return np.asarray(rotor - rotor[0])


def mean_phase(result: xr.Dataset, model: str) -> np.ndarray:
    """The mean angle (N,) of the bodies about the rotor, to the rotor."""
    angle = result[f"{model}angle"].values
    return np.asarray(angle[_with_a_phase(result.phase)].mean(axis=0) - angle[0])


def _with_a_phase(phase: xr.DataArray) -> np.ndarray:
    """Which bodies (n,) have a phase."""
    return np.asarray(np.isfinite(phase.values).any(axis=1))


def _speed(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None) -> None:
    bodies = [str(b) for b in result.body.values]
    for i in range(min(len(bodies), _MOST_NAMES)):
        axis.plot(*style.thinned(time, result.speed.values[i]), label=bodies[i], **style.line_style(i), zorder=3 - 0.1 * i)
    if slow is not None:
        axis.plot(*style.thinned(slow, result.slow_speed.values[0]), label=f"{bodies[0]}, averaged equations", **style.SLOW)
    free = float(result.free_speed)
    if np.isfinite(free):
        axis.axhline(free, color=style.GREY, linestyle="--", linewidth=0.9, label="no-load speed")
    if "vibration_frequency" in result and np.isfinite(float(result.vibration_frequency)):
        driven = float(result.vibration_frequency)
        axis.axhline(driven, color=style.COLOURS[3], linestyle="-.", linewidth=0.9, label="frequency of the vibration")
    natural = sorted({round(f, 9) for f in summary_of(result)["natural_frequencies"].values() if f is not None})
    signed = [-f if free < 0 else f for f in natural]
    style.mark_levels(axis, signed, "natural frequencies" if len(natural) > 1 else "natural frequency")
    axis.set_ylabel(style.label(result, "speed"))


def _amplitude(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None) -> None:
    scale, unit = style.printed_unit(result, "amplitude")
    if (np.abs(result.amplitude - result.radius) > 2e-2 * result.peak_amplitude).any():
        axis.plot(*style.thinned(time, scale * result.radius.values), color=style.COLOURS[4], linewidth=0.4, label="distance")
    axis.plot(*style.thinned(time, scale * result.amplitude.values), color=style.COLOURS[0], linewidth=1.1, label="amplitude")
    if slow is not None:
        axis.plot(*style.thinned(slow, scale * result.slow_amplitude.values), label="averaged equations", **style.SLOW)
    axis.set_ylabel(style.label(result, "amplitude", unit))
    axis.set_ylim(bottom=0)


def _phases(axis: Axes, result: xr.Dataset, name: str, time: np.ndarray, slow: np.ndarray | None) -> None:
    """Phases of bodies to their rotor, or of rotors (``rotor_phase``) to the vibration or to the first."""
    reference, bodies = "the rotor", _with_a_phase(result[name])
    if name == "rotor_phase":
        shaken = bool(np.isfinite(float(result.vibration_frequency)))
        reference = "the vibration" if shaken else str(result.body.values[0])
    styles = [style.line_style(i + (reference != "the vibration")) for i in range(np.count_nonzero(bodies))]
    named = [{"label": str(b)} if i < _MOST_NAMES else {} for i, b in enumerate(result.body.values[bodies])]
    degrees = np.degrees(result[name].values[bodies])
    begin = style.angle_panel(axis, degrees)
    style.draw_angles(axis, time, degrees, begin, [n | line for n, line in zip(named, styles, strict=True)])
    if slow is not None:
        styles = [style.SLOW | ({} if i else {"label": "averaged equations"}) for i in range(len(styles))]
        style.draw_angles(axis, slow, np.degrees(result[f"slow_{name}"].values[bodies]), begin, styles)
    axis.set_ylabel(f"phase to {reference} (°)")


def _power(axis: Axes, result: xr.Dataset, time: np.ndarray) -> None:
    axis.plot(*style.thinned(time, result.motor_power.values), color=style.COLOURS[1], linewidth=1.0, label="motor power")
    axis.set_ylabel(style.label(result, "motor_power"))
    other = axis.twinx()
    other.spines["right"].set_visible(True)
    residual = np.maximum(result.energy_residual.values, 1e-18)
    other.semilogy(*style.thinned(time, residual), color=style.GREY, linewidth=0.6, linestyle="-", label="energy residual")
    other.set_ylim(1e-18, max(1e-8, 10 * float(residual.max(initial=0.0))))
    style.plain_decades(other.yaxis)
    other.set_ylabel("energy residual (1)")
    style.legend_beside(axis, [*axis.get_lines(), *other.get_lines()], right=1.14)


def _figure_of_many(result: xr.Dataset) -> Figure:
    """Two panels of many run-ups: speed and amplitude of each case."""
    drawn, (speed, amplitude) = style.new_figure(2, _HEIGHT, result.attrs["title"], result.attrs["sentence"])
    cases, over, (scale, unit) = summary_of(result)["cases"], "abscissa" in result, style.printed_unit(result, "amplitude")
    for k, case in enumerate(cases):
        run = result.isel(case=k)
        inside = np.isfinite(run.time.values)
        at = run["abscissa" if over else "time"].values[inside]
        name = f"{case['label']}: {case['outcome']}" if k < _MOST_NAMED else None
        # Runs that end alike lie upon each other: later ones are dashed, so that the earlier stay visible.
        line = style.line_style(k) | {"linestyle": style.DASHES[k] if len(cases) <= len(style.DASHES) else "-"}
        speed.plot(*style.thinned(at, run.speed.values[0][inside]), label=name, **line)
        amplitude.plot(*style.thinned(at, scale * run.amplitude.values[inside]), **line)
        if "slow_speed" in result:
            slow = run["slow_abscissa" if over else "time"].values[inside]
            named = "averaged equations" if k == 0 else None
            speed.plot(*style.thinned(slow, run.slow_speed.values[0][inside]), label=named, **style.SLOW)
            amplitude.plot(*style.thinned(slow, scale * run.slow_amplitude.values[inside]), **style.SLOW)
    free = {round(case["free_speed"], 6) for case in cases if case["free_speed"] is not None}
    style.mark_levels(speed, sorted(free) if len(free) <= 2 else (), "no-load speed")
    speed.set_ylabel(style.label(result, "speed"))
    amplitude.set_ylabel(style.label(result, "amplitude", unit))
    amplitude.set_ylim(bottom=0)
    amplitude.set_xlabel(style.label(result, "abscissa") if over else style.abscissa_label(result, "time"))
    columns = 1 if max(len(c["label"]) for c in cases) > _LONG else 2
    rows = -(-min(len(cases) + 1, _MOST_NAMED) // columns)
    drawn.subplots_adjust(right=0.97, bottom=(0.55 + 0.17 * rows) / _HEIGHT)
    drawn.legend(loc="lower center", ncol=columns, frameon=False, fontsize=7.5)
    return drawn
