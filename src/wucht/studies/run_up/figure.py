"""The figure of a run-up: speed, amplitude, phases and power until the machine has settled, and the whole run in a strip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.curves import thin_curve
from wucht.plots.scales import name_speeds, prefixed_unit
from wucht.plots.time_courses import (
    RANGE,
    Phases,
    TurnWindows,
    angles_in_turn,
    draw_course,
    draw_phases,
    draw_range,
    shown_until,
    without_steps,
)
from wucht.results.attributes import text_in
from wucht.results.formatting import abscissa_label, label, printed_unit, with_unit
from wucht.studies.run_up.figure_of_many import figure_of_many
from wucht.studies.run_up.system_run_figure import system_run_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SPEED, _PANEL, _STRIP, _ORBIT = 2.0, 1.55, 0.6, 1.7  # inches: heights of panels
_LOW = 0.8  # times these heights, where bearing forces are drawn too
_ROUND = 2e-2  # of the largest amplitude: an orbit whose radius varies less is a circle
_FEW_BODIES = 2  # bodies about a rotor that are named one by one
_ORBIT_POINTS = 200


def run_up_figure(result: xr.Dataset) -> Figure:
    """Draw one run-up in panels over a common abscissa, or the speeds and amplitudes of many."""
    if result.attrs.get("subject") == "system":
        return system_run_figure(result)
    if "case" in result.dims:
        return figure_of_many(result)
    view = _View(result)
    panels, apart = _panels(view), _panels_apart(view)
    heights = [h * (_LOW if len(panels) > len(_PANELS) else 1.0) for h, _ in panels]
    heights += [max(h for h, _ in apart)] if apart else []
    subtitle = f"{text_in(result, 'outcome')}: {result.attrs['sentence']}"
    fig, axes = sheet.new_figure(len(panels), result.attrs["title"], subtitle, heights, apart=len(apart))
    for axis, (_, draw) in zip(axes, [*panels, *apart], strict=True):
        draw(axis, view)
    for axis in axes:
        sheet.legend_beside(axis)
    low, high = float(view.x[view.panel_mask].min()), float(view.x[view.panel_mask].max())
    if high > low:
        axes[0].set_xlim(low, high)
    axes[len(panels) - 1].set_xlabel(view.name)
    return fig


@dataclass(frozen=True)
class _View:
    """What of a run is drawn, and over which abscissa."""

    result: xr.Dataset

    @cached_property
    def x(self) -> np.ndarray:
        """The abscissa (N,)."""
        return abscissa(self.result)[0]

    @property
    def name(self) -> str:
        """The name of the abscissa."""
        return abscissa(self.result)[1]

    @property
    def has_time_axis(self) -> bool:
        """True if the abscissa is the time."""
        return _abscissa_kind(self.result) == "time"

    @cached_property
    def until(self) -> float:
        """The time until which the run is drawn."""
        return shown_until([self.result.wucht.summary], float(self.result.time[-1]))

    @cached_property
    def panel_mask(self) -> np.ndarray:
        """True (N,) for the samples that are drawn."""
        return np.asarray(self.result.time.values <= self.until)

    @property
    def is_part(self) -> bool:
        """True if not the whole run is drawn."""
        return not bool(self.panel_mask.all())

    @property
    def has_spans(self) -> bool:
        """True if the samples are too few for the motion within a turn, whose limits are stored over spans of time."""
        return "span_end" in self.result

    @cached_property
    def slow(self) -> tuple[np.ndarray, np.ndarray] | None:
        """The abscissa of the averaged equations and the mask of what is drawn of them (N,); None without such."""
        return (abscissa(self.result, "slow_")[0], self.panel_mask) if "slow_speed" in self.result else None

    def windows(self, body: int = 0, whole: bool = False) -> TurnWindows | None:
        """TurnWindows of whole turns of a body, over what is drawn or the whole run; None over an abscissa that goes back."""
        if (body, whole) not in self._windows_by_body:
            until = float(self.x[-1] if whole else self.x[self.panel_mask][-1])
            forward = bool((np.diff(self.x) >= 0).all()) and self.x[-1] > self.x[0]
            self._windows_by_body[body, whole] = (
                TurnWindows.of(self.x, self.result.angle.values[body], until) if forward else None
            )
        return self._windows_by_body[body, whole]

    @cached_property
    def _windows_by_body(self) -> dict[tuple[int, bool], TurnWindows | None]:
        return {}

    @property
    def bodies(self) -> list[str]:
        """The names of the bodies."""
        return [str(name) for name in self.result.body.values]

    @cached_property
    def balls(self) -> list[int]:
        """Bodies about a rotor that share a style and a name, since there are more than a few."""
        about = np.flatnonzero(_has_phase(self.result.phase.values)).tolist() if "phase" in self.result else []
        return about if len(about) > _FEW_BODIES else []

    def look(self, body: int) -> dict[str, Any]:
        """The style of a body's lines in every panel, with its name; of several alike the first has the name of all."""
        if body in self.balls:
            first, last = (self.bodies[self.balls[k]] for k in (0, -1))
            name = {"label": f"{first} to {last}"} if body == self.balls[0] else {}
            return {"color": style.COLOURS[1], "linewidth": 0.7} | name
        return style.line_style(body - sum(ball < body for ball in self.balls)) | {"label": self.bodies[body]}

    def draw(self, axis: Axes, y: np.ndarray, body: int = 0, band: str | None = None, **look: Any) -> None:
        """Draw a signal (N,), by its mean over whole turns of a body where it swings."""
        windows = self.windows(body)
        if windows is None or self.has_spans:
            axis.plot(*thin_curve(self.x[self.panel_mask], y[self.panel_mask]), **look)
        else:
            draw_course(axis, windows, y, band, **look)

    def draw_slow(self, axis: Axes, y: np.ndarray, name: str = "averaged equations") -> None:
        """Draw a signal (N,) of the averaged equations, if there are such."""
        if self.slow is not None:
            at, panel_mask = self.slow
            axis.plot(*thin_curve(at[panel_mask], y[panel_mask]), label=name, **style.SLOW)


Panel = tuple[float, Callable[["Axes", _View], None]]


def abscissa(result: xr.Dataset, model: str = "") -> tuple[np.ndarray, str]:
    """Return the abscissa (N,) and its name: time, the rotor's angle, or the mean phase of the bodies about it.

    model: ``"slow_"`` for the run of the averaged equations.
    """
    over = _abscissa_kind(result)
    if over == "time":
        return result.time.values, abscissa_label(result, "time")
    angle = result[f"{model}angle"].values
    if over == "phi":
        return rotor_angle(angle), "angle of the rotor $\\varphi$ (rad)"
    return mean_phase(angle, result.phase.values), "mean phase of the bodies $\\psi$ (rad)"


def _abscissa_kind(result: xr.Dataset) -> str:
    return str(result.wucht.spec.get("over", "time"))


def rotor_angle(angle: np.ndarray) -> np.ndarray:
    """Return the angle (N,) that the rotor has turned, of the angles (n, N) of all bodies."""
    return np.asarray(angle[0] - angle[0, 0])


def mean_phase(angle: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Return the mean angle (N,) of the bodies about the rotor, relative to the rotor. phase: of all bodies (n, N)."""
    return np.asarray(angle[_has_phase(phase)].mean(axis=0) - angle[0])


def _has_phase(phase: np.ndarray) -> np.ndarray:
    """True for bodies (n,) that have a phase."""
    return np.asarray(np.isfinite(phase).any(axis=1))


def _panels(view: _View) -> list[Panel]:
    """The panels over the common abscissa."""
    result = view.result
    panels: list[Panel] = [(_SPEED, _speed), (_PANEL, _amplitude)]
    panels += [(_PANEL, _body_phases)] * ("phase" in result) + [(_PANEL, _rotor_phases)] * ("rotor_phase" in result)
    panels += [(_PANEL, _power)]
    return [*panels, (_PANEL, _bearing_forces)] if _is_planar(result) else panels


_PANELS = ("speed", "amplitude", "phases", "power")  # of a usual machine


def _panels_apart(view: _View) -> list[Panel]:
    """The panels with separate abscissae: the orbit of a planar carrier, and the whole run where not all is drawn."""
    strip: list[Panel] = [(_STRIP, _whole_run)] if view.is_part else []
    return [(_ORBIT, _orbit), *strip] if _is_planar(view.result) else strip


def _is_planar(result: xr.Dataset) -> bool:
    """True if the carrier translates and turns in its plane, as that of a screen does."""
    return {"x", "y", "r"} <= {str(d) for d in result.direction.values}


def _speed(axis: Axes, view: _View) -> None:
    """Draw the speeds of the bodies, the no-load speed and the natural frequencies."""
    result, band = view.result, RANGE
    _limits(axis, view, "speed", 1.0)
    for i in range(len(view.bodies)):
        is_rotor = "phase" not in result or not _has_phase(result.phase.values)[i]
        windows = view.windows(i if is_rotor else 0)
        look = view.look(i) | {"zorder": 3 - 0.01 * i}
        if view.has_spans and view.has_time_axis and windows is not None:
            axis.plot(windows.at, windows.rates(result.angle.values[i]), **look)  # exact, however few samples there are
            continue
        view.draw(axis, result.speed.values[i], i if is_rotor else 0, band if is_rotor else None, **look)
        band = "" if is_rotor else band
    view.draw_slow(axis, result["slow_speed"].values[0] if view.slow else view.x, f"{view.bodies[0]}, averaged equations")
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


def _amplitude(axis: Axes, view: _View) -> None:
    """Draw the amplitude of the axis, and the range of its distance from rest where the orbit is no circle."""
    scale, unit = printed_unit(view.result, "amplitude")
    amplitude, radius = scale * view.result.amplitude.values, scale * view.result.radius.values
    _limits(axis, view, "radius", scale)
    windows = None if view.has_spans else view.windows()
    differs = (np.abs(amplitude - radius)[view.panel_mask] > _ROUND * amplitude[view.panel_mask].max()).any()
    is_orbit = differs and len(view.result.direction) > 1  # along a line the distance is zero in each turn
    look: dict[str, Any] = {"color": style.COLOURS[0], "linewidth": 1.1, "label": "amplitude"}
    if windows is not None and is_orbit:
        draw_range(axis, windows, radius, "distance from rest", style.COLOURS[0])
        course = np.interp(view.x, *without_steps(view.x, amplitude)) if _is_planar(view.result) else amplitude
        view.draw(axis, course, 0, None, **look)
    else:
        view.draw(axis, amplitude, 0, None if is_orbit else "", **look)
    view.draw_slow(axis, scale * view.result["slow_amplitude"].values if view.slow else view.x)
    axis.set(ylabel=label(view.result, "amplitude", unit))
    axis.set_ylim(bottom=0)


def _limits(axis: Axes, view: _View, name: str, scale: float) -> None:
    """Draw the limits of a quantity over time, where few samples a turn are stored."""
    result = view.result
    if not view.has_spans or not view.has_time_axis:
        return
    begins = np.append(result.time.values[0], result.span_end.values[:-1])
    inside = begins <= view.until
    ends = np.append(result.time.values[0], result.span_end.values[inside])
    low, high = (scale * result[f"{limit}_{name}"].values[inside] for limit in ("least", "greatest"))
    low, high = np.append(low[:1], low), np.append(high[:1], high)
    axis.fill_between(ends, low, high, step="pre", color=style.GREY, alpha=0.3, linewidth=0, label="limits within a turn")


def _body_phases(axis: Axes, view: _View) -> None:
    """Draw phases of bodies to their rotor."""
    _phases(axis, view, "phase", "the rotor", np.flatnonzero(_has_phase(view.result.phase.values)).tolist())


def _rotor_phases(axis: Axes, view: _View) -> None:
    """Draw phases of rotors to the vibration or to the first rotor."""
    is_shaken = bool(np.isfinite(float(view.result.vibration_frequency)))
    reference = "the vibration" if is_shaken else view.bodies[0]
    _phases(axis, view, "rotor_phase", reference, np.flatnonzero(_has_phase(view.result.rotor_phase.values)).tolist())


def _phases(axis: Axes, view: _View, name: str, reference: str, bodies: Sequence[int]) -> None:
    """Draw phases, or, where all bodies turn past at the end, the speeds at which they slip."""
    windows, looks, values = view.windows(), [view.look(i) for i in bodies], view.result[name].values[bodies]
    if windows is None:
        degrees = np.degrees(values)
        phases = Phases(view.x[view.panel_mask], degrees[:, view.panel_mask], np.zeros(values[:, view.panel_mask].shape))
    else:
        phases = Phases.of(windows, values)
    if phases.all_slip and view.has_time_axis:
        for slip, look in zip(phases.slips, looks, strict=True):
            axis.plot(phases.at, slip, **look)
        axis.axhline(0.0, color=style.GREY, linewidth=0.6)
        axis.set_ylabel(with_unit(f"slip to {reference}", str(view.result.speed.attrs["units"])))
        return
    begin = draw_phases(axis, phases, looks)
    if view.slow is not None:
        at, panel_mask = view.slow
        for k, values_of_body in enumerate(np.degrees(view.result[f"slow_{name}"].values[bodies])):
            text = {} if k else {"label": "averaged equations"}
            axis.plot(at[panel_mask], angles_in_turn(values_of_body[panel_mask], begin), **style.SLOW | text)
    axis.set_ylabel(f"phase to {reference} (°)")


def _power(axis: Axes, view: _View) -> None:
    """Draw the power of each motor."""
    result, windows = view.result, view.windows()
    scale, unit = prefixed_unit(result.motor_power.values[view.panel_mask], str(result.motor_power.attrs["units"]))
    if "rotor_power" not in result:
        look: dict[str, Any] = {"color": style.COLOURS[1], "linewidth": 1.1, "label": "motor power"}
        if view.has_spans and view.has_time_axis and windows is not None:
            axis.plot(windows.at, scale * windows.rates(result.supplied_work.values), **look)
        else:
            view.draw(axis, scale * result.motor_power.values, 0, RANGE, **look)
    band = RANGE
    for rotor in result.rotor.values if "rotor_power" in result else ():
        power, body = scale * result.rotor_power.sel(rotor=rotor).values, view.bodies.index(str(rotor))
        if power.any():
            view.draw(axis, power, body, band, **view.look(body))
            band = ""
    axis.set_ylabel(label(result, "motor_power", unit))


def _bearing_forces(axis: Axes, view: _View) -> None:
    """Draw the force on the bearing of each rotor, or of the only one."""
    result, has_several = view.result, "rotor_bearing_force" in view.result
    if has_several:
        forces = np.hypot(*(result.rotor_bearing_force.sel(plane=d).values for d in "xy"))
    else:
        forces = np.hypot(*(result.bearing_force.sel(direction=d).values for d in "xy"))[None]
    scale, unit = prefixed_unit(forces[:, view.panel_mask], str(result.bearing_force.attrs["units"]))
    for k, force in enumerate(forces):
        body = view.bodies.index(str(result.rotor.values[k])) if has_several else 0
        view.draw(axis, scale * force, body, "" if k else RANGE, **view.look(body))
    axis.set_ylabel(with_unit("bearing force", unit))


def _orbit(axis: Axes, view: _View) -> None:
    """Draw the orbits of the carrier's centre of mass and of its mounts over the last turn of the run.

    Dashed lines of several turns would run together.
    """
    result = view.result
    scale, unit = printed_unit(result, "amplitude")
    x, y, turn = _last_turn(result)
    places = [("centre of mass", 0.0, 0.0)]
    if "mount_x" in result:
        at = zip(result.mount_x.values, result.mount_y.values, strict=True)
        places += [(f"at ({px:.3g}, {py:.3g}) m", px, py) for px, py in at]
    for k, (name, px, py) in enumerate(places):
        cos, sin = np.cos(turn) - 1, np.sin(turn)
        dx, dy = x + cos * px - sin * py, y + sin * px + cos * py
        axis.plot(scale * (dx - dx.mean()), scale * (dy - dy.mean()), **style.line_style(k) | {"label": name, "linewidth": 0.9})
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel=f"orbit of the deck, x ({unit})", ylabel=f"y ({unit})")


def _last_turn(result: xr.Dataset) -> np.ndarray:
    """Return x, y and the angle of the carrier (3, N) over the last turn of the main rotor, or over a shorter run."""
    from scipy.interpolate import CubicSpline

    time, first = np.unique(result.time.values, return_index=True)
    turns = np.abs(result.angle.values[0, first] - result.angle.values[0, -1]) / (2 * np.pi)
    k = int(np.flatnonzero(turns >= 1).max(initial=0))
    begin = time[k] + (turns[k] - 1) / (turns[k] - turns[k + 1]) * (time[k + 1] - time[k]) if turns[k] >= 1 else time[0]
    course = np.array([result.displacement.sel(direction=d).values[first] for d in ("x", "y", "r")])
    before = max(k - 3, 0)
    return np.asarray(CubicSpline(time[before:], course[:, before:], axis=1)(np.linspace(begin, time[-1], _ORBIT_POINTS)))


def _whole_run(axis: Axes, view: _View) -> None:
    """Draw the amplitude over the whole run, in which the part drawn above is marked."""
    scale, unit = printed_unit(view.result, "amplitude")
    amplitude, windows = scale * view.result.amplitude.values, view.windows(whole=True)
    look: dict[str, Any] = {"color": style.COLOURS[0], "linewidth": 0.9}
    if windows is None or view.has_spans:
        axis.plot(*thin_curve(view.x, amplitude), **look)
    else:
        draw_course(axis, windows, amplitude, "", **look)
    end = float(view.x[view.panel_mask][-1])
    axis.axvspan(float(view.x[0]), end, color=style.GREY, alpha=0.25, linewidth=0, label="drawn above")
    axis.set_xlim(float(view.x.min()), float(view.x.max()))
    axis.set_ylim(bottom=0)
    axis.set(xlabel=f"whole run, {view.name}", ylabel=with_unit("amplitude", unit))
