"""The figure of a run-up: speed, amplitude, phases, and motor power with the energy residual; of many, speed and amplitude."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.curves import RESIDUAL, angle_panel, draw_angles, draw_residual, draw_swings, thin_curve
from wucht.plots.scales import name_speeds, plain_decades
from wucht.results.formatting import abscissa_label, label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DECADES = 30.0  # times its last value: an amplitude that falls so far is also drawn over a logarithmic scale
_PANEL = 1.55  # inches: the height of a panel
_LOWEST = 1e-12  # of the largest amplitude: nothing below is drawn
_MOST_NAMED, _HEIGHT = 14, 2.3  # of many runs


def figure(result: xr.Dataset) -> Figure:
    """Draw panels of speed, amplitude, phases if any, power, and the energy residual; two panels for many run-ups."""
    if "case" in result.dims:
        return _figure_of_many(result)
    angles = [name for name in ("phase", "rotor_phase") if name in result]
    decays = _falls_by_decades(result)
    heights = [_PANEL] * (3 + decays + len(angles)) + [RESIDUAL]
    subtitle = f"{result.attrs['outcome']}: {result.attrs['sentence']}"
    fig, axes = sheet.new_figure(len(heights), result.attrs["title"], subtitle, heights)
    at, name = abscissa(result)
    slow = abscissa(result, "slow_")[0] if "slow_speed" in result else None
    _speed(axes[0], result, at, slow)
    _amplitude(axes[1], result, at, slow)
    if decays:
        _amplitude(axes[2], result, at, slow, decades=True)
    for axis, variable in zip(axes[2 + decays :], angles, strict=False):
        _phases(axis, result, variable, at, slow)
    draw_swings(axes[-2], at, result.motor_power.values, color=style.COLOURS[1], linewidth=1.0, label="motor power")
    axes[-2].set_ylabel(label(result, "motor_power"))
    for axis in axes[:-1]:
        sheet.legend_beside(axis)
    draw_residual(axes[-1], at, np.maximum.accumulate(np.nan_to_num(result.energy_residual.values)))
    low, high = float(at.min()), float(at.max())
    for axis in axes if high > low else ():
        axis.set_xlim(low, high)
    axes[-1].set_xlabel(name)
    return fig


def _falls_by_decades(result: xr.Dataset) -> bool:
    """True if the amplitude ends so far below its maximum that a linear scale cannot show it there."""
    amplitudes = _positive(result.amplitude.values)
    return len(amplitudes) > 1 and bool(amplitudes.max() > _DECADES * amplitudes[-len(amplitudes) // 10 :].min())


def _positive(amplitude: np.ndarray) -> np.ndarray:
    return np.asarray(amplitude[np.isfinite(amplitude) & (amplitude > 0)])


def abscissa(result: xr.Dataset, model: str = "") -> tuple[np.ndarray, str]:
    """Return the abscissa (N,) and its name: time, the rotor's angle, or the mean phase of the bodies about it.

    model: ``"slow_"`` for the run of the averaged equations.
    """
    over = _abscissa_kind(result)
    if over == "time":
        return result.time.values, abscissa_label(result, "time")
    if over == "phi":
        return rotor_angle(result, model), "angle of the rotor $\\varphi$ (rad)"
    return mean_phase(result, model), "mean phase of the bodies $\\psi$ (rad)"


def rotor_angle(result: xr.Dataset, model: str) -> np.ndarray:
    """Return the angle (N,) that the rotor has turned."""
    rotor = result[f"{model}angle"].values[0]
    return np.asarray(rotor - rotor[0])


def mean_phase(result: xr.Dataset, model: str) -> np.ndarray:
    """Return the mean angle (N,) of the bodies about the rotor, relative to the rotor."""
    angle = result[f"{model}angle"].values
    return np.asarray(angle[_has_phase(result.phase)].mean(axis=0) - angle[0])


def _has_phase(phase: xr.DataArray) -> np.ndarray:
    """True for bodies (n,) that have a phase."""
    return np.asarray(np.isfinite(phase.values).any(axis=1))


def _speed(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None) -> None:
    bodies = [str(b) for b in result.body.values]
    _limits(axis, result, "speed", 1.0)
    for i, name in enumerate(bodies):
        draw_swings(axis, time, result.speed.values[i], **_look(i, name, len(bodies)), zorder=3 - 0.01 * i)
    if slow is not None:
        axis.plot(*thin_curve(slow, result.slow_speed.values[0]), label=f"{bodies[0]}, averaged equations", **style.SLOW)
    free = float(result.free_speed)
    if np.isfinite(free):
        axis.axhline(free, label="no-load speed", **style.FREE)
    if "vibration_frequency" in result and np.isfinite(float(result.vibration_frequency)):
        frequency = float(result.vibration_frequency)
        axis.axhline(frequency, color=style.COLOURS[3], linestyle="-.", linewidth=0.9, label="frequency of the vibration")
    natural = sorted({round(f, 9) for f in result.wucht.summary["natural_frequencies"].values() if f is not None})
    signed_speeds = [-f if free < 0 else f for f in natural]
    style.mark_levels(axis, signed_speeds, "natural frequencies" if len(natural) > 1 else "natural frequency")
    name_speeds(axis, result)


def _look(i: int, name: str, count: int) -> dict[str, Any]:
    """Return the style of a body's lines in every panel; bodies beyond the available styles share one, with one name."""
    if i < style.MOST_LOOKS - 1 or count <= style.MOST_LOOKS:
        return style.line_style(i) | {"label": name}
    first = i == style.MOST_LOOKS - 1
    return {"color": style.GREY, "linewidth": 0.5, "label": f"{name} and {count - i - 1} more" if first else None}


def _amplitude(axis: Axes, result: xr.Dataset, time: np.ndarray, slow: np.ndarray | None, decades: bool = False) -> None:
    scale, unit = printed_unit(result, "amplitude")
    amplitude = scale * result.amplitude.values
    if decades:
        axis.set_yscale("log")
    else:
        _limits(axis, result, "radius", scale)
        if (np.abs(result.amplitude - result.radius) > 2e-2 * result.peak_amplitude).any():
            draw_swings(axis, time, scale * result.radius.values, color=style.COLOURS[4], linewidth=0.5, label="distance")
    draw_swings(axis, time, amplitude, color=style.COLOURS[0], linewidth=1.1, label="amplitude")
    if slow is not None:
        axis.plot(*thin_curve(slow, scale * result.slow_amplitude.values), label="averaged equations", **style.SLOW)
    axis.set_ylabel(with_unit("amplitude", unit) if decades else label(result, "amplitude", unit))
    if not decades:
        axis.set_ylim(bottom=0)
        return
    amplitudes = _positive(amplitude)
    axis.set_ylim(max(0.7 * float(amplitudes.min()), _LOWEST * float(amplitudes.max())), 1.5 * float(amplitudes.max()))
    plain_decades(axis.yaxis)


def _limits(axis: Axes, result: xr.Dataset, name: str, scale: float) -> None:
    """Draw the limits of a quantity over time, where few samples a turn are stored."""
    if "span_end" not in result or _abscissa_kind(result) != "time":
        return
    ends = np.append(result.time.values[0], result.span_end.values)
    low, high = (scale * result[f"{limit}_{name}"].values for limit in ("least", "greatest"))
    low, high = np.append(low[:1], low), np.append(high[:1], high)
    axis.fill_between(ends, low, high, step="pre", color=style.GREY, alpha=0.3, linewidth=0, label="limits within a turn")


def _abscissa_kind(result: xr.Dataset) -> str:
    return str(result.wucht.spec.get("over", "time"))


def _phases(axis: Axes, result: xr.Dataset, name: str, time: np.ndarray, slow: np.ndarray | None) -> None:
    """Draw phases of bodies relative to their rotor, or of rotors (``rotor_phase``) to the vibration or to the first."""
    reference, bodies = "the rotor", _has_phase(result[name])
    if name == "rotor_phase":
        shaken = bool(np.isfinite(float(result.vibration_frequency)))
        reference = "the vibration" if shaken else str(result.body.values[0])
    names = [str(b) for b in result.body.values[bodies]]
    shift = int(reference != "the vibration")  # a body has one style in all panels, and the first body may have no phase
    looks = [_look(i + shift, name, len(names) + shift) for i, name in enumerate(names)]
    degrees = np.degrees(result[name].values[bodies])
    begin = angle_panel(axis, degrees)
    draw_angles(axis, time, degrees, begin, looks)
    if slow is not None:
        looks = [style.SLOW | ({} if i else {"label": "averaged equations"}) for i in range(len(names))]
        draw_angles(axis, slow, np.degrees(result[f"slow_{name}"].values[bodies]), begin, looks)
    axis.set_ylabel(f"phase to {reference} (°)")


def _figure_of_many(result: xr.Dataset) -> Figure:
    """Draw two panels of many run-ups: speed and amplitude of each case, named at the ends of lines where there is room."""
    fig, (speed, amplitude) = sheet.new_figure(2, result.attrs["title"], result.attrs["sentence"], _HEIGHT)
    cases, over, (scale, unit) = result.wucht.summary["cases"], "abscissa" in result, printed_unit(result, "amplitude")
    few, tones = len(cases) <= style.MOST_LOOKS, style.shades(len(cases))
    for k, case in enumerate(cases):
        run = result.isel(case=k)
        inside = np.isfinite(run.time.values)
        at = run["abscissa" if over else "time"].values[inside]
        name = f"{case['label']}: {case['outcome']}" if few or k < _MOST_NAMED else None
        look = style.line_style(k) if few else {"color": tones[k], "linewidth": 0.7}
        speed.plot(*thin_curve(at, run.speed.values[0][inside]), **look)
        amplitude.plot(*thin_curve(at, scale * run.amplitude.values[inside]), label=name, **look)
        if "slow_speed" in result:
            slow = run["slow_abscissa" if over else "time"].values[inside]
            line_label = "averaged equations" if k == 0 else None
            speed.plot(*thin_curve(slow, run.slow_speed.values[0][inside]), label=line_label, **style.SLOW)
            amplitude.plot(*thin_curve(slow, scale * run.slow_amplitude.values[inside]), **style.SLOW)
    free = {round(case["free_speed"], 6) for case in cases if case["free_speed"] is not None}
    style.mark_levels(speed, sorted(free) if len(free) <= 2 else (), "no-load speed")
    name_speeds(speed, result)
    amplitude.set_xlabel(label(result, "abscissa") if over else abscissa_label(result, "time"))
    amplitude.set(ylabel=label(result, "amplitude", unit), ylim=(0, None))
    ends = [np.asarray(line.get_xdata())[[0, -1]] for line in amplitude.get_lines() if np.size(line.get_xdata())]
    if ends and np.ptp(ends) > 0:
        speed.set_xlim(np.min(ends), np.max(ends))
    sheet.name_at_ends(amplitude)
    sheet.legend_below(fig, sheet.labelled_handles([speed]))
    return fig
