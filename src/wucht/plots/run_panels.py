"""The panels of a machine's run: what each shows of a result, over time, the rotor's angle or the mean phase of its bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots import style
from wucht.plots.curves import thin_curve
from wucht.plots.scales import name_speeds, prefixed_unit
from wucht.plots.sheet import legend_beside, new_figure
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
from wucht.results.formatting import abscissa_label, label, printed_unit, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ANGLES = {"phi": ("angle of the rotor", "$\\varphi$"), "psi": ("mean phase of the bodies", "$\\psi$")}  # instead of the time
_SPEED, _PANEL, _STRIP, _ORBIT = 2.0, 1.55, 0.6, 1.7  # inches: heights of panels
_USUAL, _LOW = 4, 0.8  # panels of a usual machine; times these heights, where there are more
_ROUND = 2e-2  # of the largest amplitude: an orbit whose radius varies less is a circle
_FEW_BODIES = 2  # bodies about a rotor that are named one by one
_ORBIT_POINTS = 200


def turned_angle(over: str, row: Mapping[Any, Any], model: str = "") -> np.ndarray:
    """Return the abscissa (N,) ``"phi"``, the angle that the rotor has turned, or ``"psi"``, the mean angle of bodies to it.

    row: the variables of a run by name. model: ``"slow_"`` for the averaged equations.
    """
    angle = np.asarray(row[f"{model}angle"])
    return np.asarray(angle[0] - angle[0, 0] if over == "phi" else angle[_with_phase(row["phase"])].mean(axis=0) - angle[0])


def _with_phase(phase: Any) -> list[int]:
    """The bodies that have a phase, of the phases (n, N) of all."""
    return np.flatnonzero(np.isfinite(np.asarray(phase)).any(axis=1)).tolist()


class RunView:
    """A machine's run as it is drawn.

    Attributes
    ----------
    x, slow_x : numpy.ndarray
        The abscissa (N,); that of the averaged equations, None without such.
    name : str
        The name of the abscissa.
    until, inside : float, numpy.ndarray
        The end of what is drawn, when the machine has settled; True (N,) for the samples until then.
    has_spans : bool
        True if the samples are too few for the motion within a turn, whose limits are stored over spans of time.
    about : list of int
        The bodies that turn about a rotor. Of more than a few all share a style and a name.
    windows : callable
        Windows of whole turns of a body, over the panels or (``whole``) the whole run; None over an abscissa that goes back.
    """

    def __init__(self, result: xr.Dataset) -> None:
        over = str(result.wucht.spec.get("over", "time"))
        self.result, self.has_time_axis, self.has_spans = result, over == "time", "span_end" in result
        self.name = abscissa_label(result, "time") if over == "time" else " ".join((*ANGLES[over], "(rad)"))
        self.x = result.time.values if over == "time" else turned_angle(over, result)
        self.slow_x: np.ndarray | None = None
        if "slow_speed" in result:
            self.slow_x = self.x if over == "time" else turned_angle(over, result, "slow_")
        self.until = shown_until([result.wucht.summary], float(result.time[-1]))
        self.inside = result.time.values <= self.until
        self.bodies = [str(name) for name in result.body.values]
        self.about = _with_phase(result.phase) if "phase" in result else []
        self.windows = cache(self._windows)

    def _windows(self, body: int = 0, whole: bool = False) -> TurnWindows | None:
        until = float(self.x[-1] if whole else self.x[self.inside][-1])
        forward = bool((np.diff(self.x) >= 0).all()) and self.x[-1] > self.x[0]
        return TurnWindows.of(self.x, self.result.angle.values[body], until) if forward else None

    def look(self, body: int) -> dict[str, Any]:
        """Return the style of a body's lines in every panel, with its name; of several alike the first has the name of all."""
        alike = self.about if len(self.about) > _FEW_BODIES else []
        if body in alike:
            name = {"label": f"{self.bodies[alike[0]]} to {self.bodies[alike[-1]]}"} if body == alike[0] else {}
            return {"color": style.COLOURS[1], "linewidth": 0.7} | name
        return style.line_style(body - sum(ball < body for ball in alike)) | {"label": self.bodies[body]}

    def draw(
        self,
        axis: Axes,
        y: np.ndarray,
        body: int = 0,
        band: str | None = RANGE,
        scale: float = 1.0,
        slope_of: np.ndarray | None = None,
        **look: Any,
    ) -> None:
        """Draw a signal, by its mean over whole turns of a body where it swings.

        y: (N,). band: name of its range, empty for one without a name; None: no range. slope_of: (N,) whose rate it is, exact
        over the time however few samples there are.
        """
        windows = self.windows(body)
        if windows is not None and not self.has_spans:
            draw_course(axis, windows, scale * y, "" if band in axis.get_legend_handles_labels()[1] else band, **look)
        elif windows is not None and slope_of is not None and self.has_time_axis:
            axis.plot(windows.at, scale * windows.rates(slope_of), **look)
        else:
            axis.plot(*thin_curve(self.x[self.inside], scale * y[self.inside]), **look)

    def draw_slow(self, axis: Axes, name: str, scale: float = 1.0, words: str = "averaged equations") -> None:
        """Draw a signal of the averaged equations, that of the main rotor, if there are such."""
        if self.slow_x is not None:
            y = np.atleast_2d(self.result[f"slow_{name}"].values)[0]
            axis.plot(*thin_curve(self.slow_x[self.inside], scale * y[self.inside]), label=words, **style.SLOW)

    def draw_limits(self, axis: Axes, name: str, scale: float = 1.0) -> None:
        """Draw the limits of a quantity over time, where few samples a turn are stored."""
        if not self.has_spans or not self.has_time_axis:
            return
        result, time = self.result, self.result.time.values
        inside = np.append(time[0], result.span_end.values[:-1]) <= self.until
        ends = np.append(time[0], result.span_end.values[inside])
        low, high = (scale * result[f"{limit}_{name}"].values[inside] for limit in ("least", "greatest"))
        low, high = np.append(low[:1], low), np.append(high[:1], high)
        axis.fill_between(ends, low, high, step="pre", color=style.GREY, alpha=0.3, linewidth=0, label="limits within a turn")


Panel = tuple[float, Callable[["Axes", RunView], None]]  # its height, in inches, and what draws it


def figure_of_run(result: xr.Dataset) -> Figure:
    """Draw a run in panels over a common abscissa, with its orbit and the whole run in a strip below, where these say more."""
    view, draw = RunView(result), [_speed, _amplitude]
    draw += [panel for name, panel in (("phase", _body_phases), ("rotor_phase", _rotor_phases)) if name in result]
    draw.append(_power)
    apart: list[Panel] = [] if view.inside.all() else [(_STRIP, _whole_run)]
    if _is_planar(result):
        draw.append(_bearing_forces)
        apart.insert(0, (_ORBIT, _orbit))
    low = _LOW if len(draw) > _USUAL else 1.0
    panels = [*((low * (_SPEED if panel is _speed else _PANEL), panel) for panel in draw), *apart]
    heights = [height for height, _ in panels[: len(draw) + 1]]  # those apart are in one row, an orbit first
    fig, axes = new_figure(len(draw), result.attrs["title"], answer_in_print(result), heights, apart=len(apart))
    for axis, (_, draw_panel) in zip(axes, panels, strict=True):
        draw_panel(axis, view)
        legend_beside(axis)
    low_end, high_end = float(view.x[view.inside].min()), float(view.x[view.inside].max())
    if high_end > low_end:
        axes[0].set_xlim(low_end, high_end)
    axes[len(draw) - 1].set_xlabel(view.name)
    return fig


def _is_planar(result: xr.Dataset) -> bool:
    """True if the carrier translates and turns in its plane, as that of a screen does."""
    return {"x", "y", "r"} <= {str(d) for d in result.direction.values}


def _speed(axis: Axes, view: RunView) -> None:
    """Draw the speeds of the bodies, the no-load speed and the natural frequencies."""
    result = view.result
    view.draw_limits(axis, "speed")
    for i in range(len(view.bodies)):
        of_rotor: dict[str, Any] = {"body": 0, "band": None} if i in view.about else {"body": i}
        look = view.look(i) | {"zorder": 3 - 0.01 * i}
        view.draw(axis, result.speed.values[i], slope_of=result.angle.values[i], **of_rotor, **look)
    view.draw_slow(axis, "speed", words=f"{view.bodies[0]}, averaged equations")
    free = float(result.free_speed)
    if np.isfinite(free):
        axis.axhline(free, label="no-load speed", **style.FREE)
    if "vibration_frequency" in result and np.isfinite(float(result.vibration_frequency)):
        frequency = float(result.vibration_frequency)
        axis.axhline(frequency, color=style.COLOURS[3], linestyle="-.", linewidth=0.9, label="frequency of the vibration")
    natural = sorted({round(f, 9) for f in result.wucht.summary["natural_frequencies"].values() if f is not None})
    style.mark_natural_frequencies(axis, [-f if free < 0 else f for f in natural])
    name_speeds(axis, result)


def _amplitude(axis: Axes, view: RunView) -> None:
    """Draw the amplitude of the axis, and the range of its distance from rest where the orbit is no circle."""
    scale, unit = printed_unit(view.result, "amplitude")
    amplitude, radius = (scale * view.result[name].values for name in ("amplitude", "radius"))
    view.draw_limits(axis, "radius", scale)
    windows = None if view.has_spans else view.windows()
    differs = (np.abs(amplitude - radius)[view.inside] > _ROUND * amplitude[view.inside].max()).any()
    is_orbit = differs and len(view.result.direction) > 1  # along a line the distance is zero in each turn
    if windows is not None and is_orbit:
        draw_range(axis, windows, radius, "distance from rest", style.COLOURS[0])
        amplitude = np.interp(view.x, *without_steps(view.x, amplitude)) if _is_planar(view.result) else amplitude
    view.draw(axis, amplitude, band=None if is_orbit else "", color=style.COLOURS[0], linewidth=1.1, label="amplitude")
    view.draw_slow(axis, "amplitude", scale)
    axis.set(ylabel=label(view.result, "amplitude", unit))
    axis.set_ylim(bottom=0)


def _body_phases(axis: Axes, view: RunView) -> None:
    """Draw phases of bodies to their rotor."""
    _phases(axis, view, "phase", "the rotor", view.about)


def _rotor_phases(axis: Axes, view: RunView) -> None:
    """Draw phases of rotors to the vibration or to the first rotor."""
    is_shaken = bool(np.isfinite(float(view.result.vibration_frequency)))
    _phases(axis, view, "rotor_phase", "the vibration" if is_shaken else view.bodies[0], _with_phase(view.result.rotor_phase))


def _phases(axis: Axes, view: RunView, name: str, reference: str, bodies: Sequence[int]) -> None:
    """Draw phases, or, where all bodies turn past at the end, the speeds at which they slip."""
    windows, looks, values = view.windows(), [view.look(i) for i in bodies], view.result[name].values[bodies]
    if windows is None:
        values = np.degrees(values)[:, view.inside]
        phases = Phases(view.x[view.inside], values, np.zeros(values.shape))
    else:
        phases = Phases.of(windows, values)
    if phases.all_slip and view.has_time_axis:
        for slip, look in zip(phases.slips, looks, strict=True):
            axis.plot(phases.at, slip, **look)
        axis.axhline(0.0, color=style.GREY, linewidth=0.6)
        axis.set_ylabel(with_unit(f"slip to {reference}", str(view.result.speed.attrs["units"])))
        return
    begin = draw_phases(axis, phases, looks)
    if view.slow_x is not None:
        for k, degrees in enumerate(np.degrees(view.result[f"slow_{name}"].values[bodies])):
            text = {} if k else {"label": "averaged equations"}
            axis.plot(view.slow_x[view.inside], angles_in_turn(degrees[view.inside], begin), **style.SLOW | text)
    axis.set_ylabel(f"phase to {reference} (°)")


def _power(axis: Axes, view: RunView) -> None:
    """Draw the power of each motor."""
    result = view.result
    scale, unit = prefixed_unit(result.motor_power.values[view.inside], str(result.motor_power.attrs["units"]))
    axis.set_ylabel(label(result, "motor_power", unit))
    if "rotor_power" not in result:
        look: dict[str, Any] = {"color": style.COLOURS[1], "linewidth": 1.1, "label": "motor power"}
        view.draw(axis, result.motor_power.values, scale=scale, slope_of=result.supplied_work.values, **look)
        return
    for rotor, power in zip(map(str, result.rotor.values), result.rotor_power.values, strict=True):
        if power.any():
            body = view.bodies.index(rotor)
            view.draw(axis, power, body, scale=scale, **view.look(body))


def _bearing_forces(axis: Axes, view: RunView) -> None:
    """Draw the force on the bearing of each rotor, or of the only one."""
    result, rotors, forces = view.result, view.bodies[:1], view.result.bearing_force.sel(direction=["x", "y"]).values[None]
    if "rotor_bearing_force" in result:
        rotors, forces = list(map(str, result.rotor.values)), result.rotor_bearing_force.sel(plane=["x", "y"]).values
    magnitudes = np.hypot(forces[:, 0], forces[:, 1])
    scale, unit = prefixed_unit(magnitudes[:, view.inside], str(result.bearing_force.attrs["units"]))
    for body, magnitude in zip(map(view.bodies.index, rotors), magnitudes, strict=True):
        view.draw(axis, magnitude, body, scale=scale, **view.look(body))
    axis.set_ylabel(with_unit("bearing force", unit))


def _orbit(axis: Axes, view: RunView) -> None:
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
    course, before = result.displacement.sel(direction=["x", "y", "r"]).values[:, first], max(k - 3, 0)
    return np.asarray(CubicSpline(time[before:], course[:, before:], axis=1)(np.linspace(begin, time[-1], _ORBIT_POINTS)))


def _whole_run(axis: Axes, view: RunView) -> None:
    """Draw the amplitude over the whole run, in which the part drawn above is marked."""
    scale, unit = printed_unit(view.result, "amplitude")
    amplitude, windows = scale * view.result.amplitude.values, view.windows(whole=True)
    look: dict[str, Any] = {"color": style.COLOURS[0], "linewidth": 0.9}
    if windows is None or view.has_spans:
        axis.plot(*thin_curve(view.x, amplitude), **look)
    else:
        draw_course(axis, windows, amplitude, "", **look)
    end = float(view.x[view.inside][-1])
    axis.axvspan(float(view.x[0]), end, color=style.GREY, alpha=0.25, linewidth=0, label="drawn above")
    axis.set_xlim(float(view.x.min()), float(view.x.max()))
    axis.set_ylim(bottom=0)
    axis.set(xlabel=f"whole run, {view.name}", ylabel=with_unit("amplitude", unit))
