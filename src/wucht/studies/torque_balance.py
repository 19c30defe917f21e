"""Balance of the torques of drive, load and vibration: 002 (3.51), figure 3.2b."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from wucht.analysis.working_points import TorqueCurves
from wucht.dynamics.run_ups.operating_points import OperatingPoints, shaft_speed_range, speeds_in_sense
from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, is_driven, operating_speed, sense_of
from wucht.plots.sheet import new_figure
from wucht.plots.stability_lines import draw_by_stability, draw_classes, draw_configurations
from wucht.plots.style import COLOURS, GREY, mark_speeds
from wucht.results.formatting import with_unit
from wucht.results.report import answer_in_print
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.from_rest_variables import FROM_REST_WORDS, state_ends_from_rest
from wucht.studies.key_types import BalancingBodies, Interval, Start, Whole
from wucht.studies.motion_variables import state_natural_vibrations
from wucht.studies.motor_variables import state_motor_shares
from wucht.studies.next_question import NextQuestion
from wucht.studies.starting_variables import not_started_statement, state_starting_torques
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TALLEST, _BRAKING = 2.5, 0.5  # of the drive's largest torque: limits of the scale for resonances, and for the braking torque
_STARTING = 3.0  # times the opposing torques: limit of the scale for the starting torque of a motor

# The phases of the bodies; the torques on the shaft over its speed, for each branch of these or the held bodies; and the speeds
# searched for working points, in the main rotor's sense where bodies are in steady phases.
Prepared = tuple[SteadyPhases, tuple[TorqueCurves, ...], tuple[float, float]]


class TorqueBalance(Study):
    """The drive's characteristic, the load line and the vibration torque over the speed, and the working points."""

    kind = "torque-balance"
    next_questions = (
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves = (("speed", "drive_torque"), ("speed", "surplus_torque"))
    solves = "steady vibration of a linear carrier, in closed form"

    range: SI[Interval | None] = si("rad/s", "speed", default=None, help=(
        "lowest and highest speed, signed; by default from 0 to 1.2 times the speed that the drive reaches without vibration; "
        "if it reaches none, or one beyond 20 times the highest natural frequency (and 3000 rad/s), to 3 times that "
        "frequency, and to 1.2 times the fastest working point up to there"
    ))  # fmt: skip
    on: str | None = Field(default=None, title="rotor", description=(
        "name of the rotor whose shaft is balanced, by default the main one; other rotors turn with it at the same speed"
    ))  # fmt: skip
    points: Whole = Field(default=1200, ge=2, le=100_000, description=(
        "number of speeds, evenly spaced over the range; more are added to resolve resonances and breakdown"
    ))  # fmt: skip
    bodies: BalancingBodies = None
    start: Composite[Start] = composite(default_factory=dict, description=(
        "phases of bodies that are held; of several rotors in steady phases, those that select the nearest stable configuration"
    ))  # fmt: skip

    def turning(self) -> str:
        """See ``Study``."""
        return "all bodies turn at one speed; the drive as its characteristic says"

    def prepare(self, machine: Machine, watch: Callable[[], None] | None = None) -> Prepared:
        """Return phases, curves and speeds. Raises ``InputError`` where the start does not fit, or nothing drives the shaft."""
        by_name = {r.name: r for r in machine.rotors}
        if self.on is not None and self.on not in by_name:
            raise InputError("study.on", self.on, f"must be a rotor: {', '.join(by_name)}")
        rotor = machine.rotor if self.on is None else by_name[self.on]
        steady = SteadyPhases.of(machine, self.start, self.bodies, watch)
        if rotor.coordinate.prescribed_velocity is not None:
            reason = f"the drive gives {rotor.name!r} its speed, whatever torque that takes: there is no torque balance"
            advice = "study.kind = 'response' computes the required torque"
            raise InputError("machine.drive", None, f"{reason}; {advice}", code="prescribed")
        driven_bodies = {b.name for b in machine.group(rotor)}
        if not machine.dimensionless and not any(d.on in driven_bodies for d in machine.drives):
            raise InputError(
                "machine.drive", None, f"nothing drives {rotor.name!r}: there is no torque to balance", code="no-drive"
            )
        fastest = max(operating_speed(steady.machine), *map(abs, self.range or (0.0, 0.0)))
        if not is_driven(steady.machine, rotor, fastest):
            reason = f"nothing drives {rotor.name!r}: its drives give no torque at standstill and no power at any speed"
            raise InputError("machine.drive", None, f"{reason}, so that there is no torque to balance", code="no-drive")
        speeds = self.range or shaft_speed_range(steady, rotor)
        curves = tuple(TorqueCurves(steady.machine, rotor, vibration, speeds, self.points) for vibration in steady.curves)
        return steady, curves, speeds_in_sense(steady, rotor, speeds) if steady.torques is not None else speeds

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Search the working points; then run the machine up to find the one that is reached from rest."""
        steady, curves, speeds = prepared
        watch = partial(work.report, 0.0, "working points")
        watch()
        operating = work.unit("search", partial(OperatingPoints.of, steady, curves, speeds, watch))
        fill = partial(_state_balance, machine=machine, steady=steady, curves=curves, operating=operating)
        yield Answer(machine.units, fill)
        if (states := operating.stable_states(machine)) and steady.is_free:
            from_rest = FromRest.of(machine, curves[0].rotor.name, states, work)
            yield Answer(machine.units, partial(fill, from_rest=from_rest))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the torques over the speed, and the working points."""
        speed, drive, load, vibration = (result[n].values for n in ("speed", "drive_torque", "load_torque", "vibration_torque"))
        fig, [axis] = new_figure(1, result.attrs["title"], answer_in_print(result), 3.4)
        axis.plot(speed, drive, color=COLOURS[1], linewidth=1.2, label="drive")
        if has_load := bool(np.abs(load).any()):
            axis.plot(speed, load, color=COLOURS[2], linewidth=1.0, linestyle="-.", label="load and bearings")
        _resistance(axis, result, load + vibration, "load and vibration" if has_load else "vibration")
        _ordinate(axis, result)
        free = (float(result.free_speed), "speed without vibration")
        mark_speeds([axis], result, ("natural frequency", "natural frequencies"), free, 0)
        at = result.point_speed.values
        axis.set_xlim(min(speed[0], at.min(initial=speed[0])), max(speed[-1], at.max(initial=speed[-1])))
        return fig


def _state_balance(
    a: Answer,
    machine: Machine,
    steady: SteadyPhases,
    curves: Sequence[TorqueCurves],
    operating: OperatingPoints,
    from_rest: FromRest | None = None,
) -> None:
    """machine: with its schedules, as it starts. from_rest: ends of run-ups from rest, where a state can be reached."""
    rotor = curves[0].rotor.name
    is_reached: list[bool | None] = [None] * len(operating.points)
    in_words, not_started = "", not_started_statement(machine)
    if from_rest is not None:
        of_stable = from_rest.is_reached(rotor, operating.stable_states(machine))
        remaining = iter(of_stable)
        is_reached = [next(remaining) if possible else False for possible in operating.possible]
        labels = operating.labels or [a.number_in_words(p.speed, "speed") for p in operating.points]
        labels_of_stable = [label for label, possible in zip(labels, operating.possible, strict=True) if possible]
        in_words = from_rest.sentence(of_stable, labels_of_stable, with_reason=not not_started)
    a.sentence = "; ".join(filter(None, [_count_in_words(steady, curves, operating), in_words, not_started]))
    if any(p.tangential for p in operating.points):
        a.warn("at a working point the curves only touch: a small change splits it into two or removes it")
    is_one_of_several = len(machine.rotors) > 1
    if is_one_of_several and steady.configurations is None:
        a.warn(f"all rotors are assumed to turn as fast as {rotor!r}, in the phases of the start")
    a.warn(*steady.warnings)
    a.assume(*steady.assumptions, *([f"torques on the shaft of {rotor}"] if is_one_of_several else []))
    _state_curves(a, steady, curves)
    stable_speeds = [p.speed for p, possible in zip(operating.points, operating.possible, strict=True) if possible]
    a.number(
        "operating_speed", max(stable_speeds, key=abs, default=None), "fastest stable working point", "speed", headline=True
    )
    state_ends_from_rest(a, from_rest)
    _state_points(a, operating, is_reached, in_steady_phases=steady.torques is not None)
    state_motor_shares(a, steady.machine, rotor, max(stable_speeds, key=abs, default=None))
    _state_machine(a, steady, curves[0])


def _count_in_words(steady: SteadyPhases, curves: Sequence[TorqueCurves], operating: OperatingPoints) -> str:
    overlapping = operating.overlapping
    points = [p for p, over in zip(operating.points, overlapping, strict=True) if not over]
    labelled_points = zip(operating.labels, operating.points, overlapping, strict=False)
    stable_names = [name for name, p, over in labelled_points if p.stable and not over]
    stable = sum(p.stable for p in points)
    if steady.configurations is not None and not stable:
        unstable = f" ({len(points)} not stable)" if points else ""
        return f"the rotors do not run synchronously: no synchronous configuration in the range is stable{unstable}"
    one, several = f"one working point, {'stable' if stable else 'not stable'}", f"{len(points)} working points"
    count = one if len(points) == 1 else f"{several}, {stable} of them stable"
    count += f": {steady.list_labels(stable_names)}" if stable_names else ""
    if impossible := sum(overlapping):
        count += f"; {impossible} more with overlapping bodies of a track" if points else ""
    if curves[0].runaway:
        away = "without vibration the drive's torque never meets the load: the rotor would run away"
        return f"{away}; with it {'are' if len(points) > 1 else 'is'} {count}" if points else away
    if points:
        return count
    place = " in any steady phases of the balancing bodies" if steady.torques is not None else ""
    return f"drive, load and vibration do not balance anywhere in the range{place}"


def _state_curves(a: Answer, steady: SteadyPhases, curves: Sequence[TorqueCurves]) -> None:
    """State the torques over the speed, and the stability of a working point there; separately for each configuration."""
    base = curves[0]
    grid = steady.grid(np.unique(np.concatenate([c.grid for c in curves])))
    drive, load, _ = base.torques(grid)[0]
    vibration = np.array([c.torques(grid)[0][2] for c in curves])
    surplus, slope = np.moveaxis(np.array([c.surplus(grid) for c in curves]), 1, 0)
    stable, along, pieces = slope < 0, "configuration speed", []
    if not steady.branches:
        vibration, surplus, stable, along = vibration[0], surplus[0], stable[0], "speed"
    else:
        pieces = steady.pieces(sense_of(steady.machine, base.rotor) * grid)
        at, inside = [p.branch for p in pieces], np.array([p.inside for p in pieces])
        vibration, surplus = (np.where(inside, torque[at], np.nan) for torque in (vibration, surplus))
        stable = stable[at] & np.array([p.stable for p in pieces])
    a.curve("speed", grid, "speed", "speed")
    a.curve("drive_torque", drive, "torque of the drive", "torque", "speed")
    a.curve("load_torque", load, "torque of loads and bearings", "torque", "speed")
    a.curve("vibration_torque", vibration, "torque of the vibration", "torque", along)
    a.curve("surplus_torque", surplus, "drive less load and vibration", "torque", along)
    a.curve("stable", stable.astype(np.int8), "stable, if it is a working point", "", along)
    if steady.branches:
        names, overlapping = np.array([p.label for p in pieces], str), np.array([p.overlapping for p in pieces], np.int8)
        a.curve("configuration_name", names, "steady phase configuration", "", "configuration", coordinate=True)
        a.curve("overlapping", overlapping, "bodies of a track overlap", "", "configuration")


def _state_points(a: Answer, operating: OperatingPoints, is_reached: Sequence[bool | None], in_steady_phases: bool) -> None:
    """State the working points; with bodies in steady phases including their configuration."""
    points, configurations = operating.points, operating.configurations
    columns: dict[str, type] = {"speed": float, "torque": float, "stable": np.int8}
    columns |= {"configuration": str, "overlapping": np.int8} if in_steady_phases else {}
    slope_unit = f"{a.unit('torque')} {a.unit('time')}".strip()
    a.table(
        "working_points", "steady speeds at which the torques balance", over="point", kinds=columns,
        speed=([p.speed for p in points], "speed of a working point", "speed"),
        torque=([p.torque for p in points], "torque of the drive there", "torque"),
        stable=([p.stable for p in points], "whether it is stable"),
        tangential=([p.tangential for p in points], "whether the curves only touch there"),
        slope=([p.slope for p in points], "slope of the drive's characteristic there", slope_unit),
        no_load_speed=([p.no_load_speed for p in points], "no-load speed of the straight line that replaces it", "speed"),
        slip=([p.slip for p in points], "slip of an induction motor"),
        reached_from_rest=(is_reached, *FROM_REST_WORDS),
        configuration=(operating.labels, "steady phase configuration there"),
        name=([c.name for c in configurations], "kind of configuration"),
        phases=([c.phases for c in configurations], "phases of the bodies to the rotor", "rad"),
        residual_share=([c.share for c in configurations], "residual unbalance, as a share of the rotor's"),
        overlapping=([c.overlapping for c in configurations], "whether bodies of a track overlap"),
        indifferent=([c.state.is_indifferent for c in configurations], "whether there is a continuous family of phases"),
        family_dimension=([c.state.dimension for c in configurations], "dimension of the family of phases"),
    )  # fmt: skip
    is_any_possible = not all(operating.overlapping)
    for k, (p, over) in enumerate(zip(points, operating.overlapping, strict=True)):
        if over and is_any_possible:  # impossible ones are counted in the sentence
            continue
        stability = "stable" if p.stable else "touching" if p.tangential else "unstable"
        place = f", {operating.labels[k]}" if configurations else ""
        place += ", but with overlapping bodies of a track" if over else ""
        slip = "" if p.slip is None else ", slip {slip:%}"
        drive = "as a straight line {slope}, zero at {no_load_speed}"
        if not math.isfinite(p.slope):
            drive = "held by the controller"
        elif not math.isfinite(p.no_load_speed):
            drive = "constant torque"
        mark = "; reached from rest" if is_reached[k] else ""
        a.line(stability, f"{{speed}}{place}: {{torque}}{slip}; {drive}{mark}", at=f"working_points[{k}]")


def _state_machine(a: Answer, steady: SteadyPhases, base: TorqueCurves) -> None:
    """State the question, and properties of the machine without vibration."""
    machine = steady.machine
    a.number("on", base.rotor.name, "rotor on whose shaft the torques act")
    a.number("range", list(base.range), "lowest and highest speed", "speed")
    a.number("bodies", "steady" if steady.branches else "held", "phases of bodies: steady, or held")
    a.curve(
        "free_speed", free_speed(machine, base.rotor), "speed reached without vibration", "speed", "",
        in_summary=True, headline=True,
    )  # fmt: skip
    a.line("free", "{free_speed} without vibration")
    state_starting_torques(a, machine)
    breakdown = None if base.breakdown is None else dict(zip(("slip", "speed", "torque"), base.breakdown, strict=True))
    parts = {"slip": ("slip", ""), "speed": ("speed", a.unit("speed")), "torque": ("torque of the drive", a.unit("torque"))}
    a.number("breakdown", breakdown, "largest torque of an induction motor", parts=parts)
    a.line("breakdown", "{breakdown.torque} at {breakdown.speed}, slip {breakdown.slip:%}")
    a.number("runaway", base.runaway, "whether the drive's torque, without vibration, never meets the load")
    state_natural_vibrations(a, machine)
    a.line("resonance", "{natural_frequencies}")


def _resistance(axis: Axes, result: xr.Dataset, torque: np.ndarray, name: str) -> None:
    """Draw a line, dashed where a working point on it would not be stable; one for each configuration of balancing bodies.

    Working points are filled where stable, open where not; crosses where bodies would overlap.
    """
    if torque.ndim > 1:
        draw_configurations(axis, result, torque)
    else:
        stable = result.stable.values.astype(bool)
        draw_by_stability(axis, result.speed.values, torque, stable, name, color=COLOURS[0], linewidth=1.2)
    points, stable = result.point_torque.values, result.point_stable.values.astype(bool)
    over = np.zeros(len(points), bool)
    if "point_overlapping" in result:
        over = result.point_overlapping.values.astype(bool)
        axis.plot(result.point_speed.values[over], points[over], "x", color=GREY, markersize=4, zorder=5)
    classes = (
        (stable & ~over, "o", COLOURS[6], "stable working point"), (~stable & ~over, "o", "white", "unstable working point")
    )  # fmt: skip
    draw_classes(axis, result.point_speed.values, points, classes, color=COLOURS[6], markersize=6, zorder=5)


def _ordinate(axis: Axes, result: xr.Dataset) -> None:
    """Set the zero line, the label and the limits of the axis so that the drive is visible, however high the resonance."""
    drive, vibration = result.drive_torque.values, result.vibration_torque.values + result.load_torque.values
    driving = drive[drive * result.speed.values >= 0]
    largest = float(np.abs(driving).max(initial=0.0))
    torques = np.concatenate([[0.0], drive, vibration[np.isfinite(vibration)]])
    low, high = float(torques.min()), float(torques.max())
    if largest > 0:
        above, below = (_TALLEST if driving[np.abs(driving).argmax()] * s > 0 else _BRAKING for s in (1, -1))
        low, high = max(low, -below * largest), min(high, above * largest)
        opposing_torques = np.concatenate([np.abs(vibration[np.isfinite(vibration)]), np.abs(result.point_torque.values)])
        most = _STARTING * float(opposing_torques.max(initial=0.0)) or largest
        low, high = max(low, -most), min(high, most)
    points = result.point_torque.values
    points = points[np.isfinite(points)]
    low, high = min(low, points.min(initial=low)), max(high, points.max(initial=high))  # all working points are inside
    if high > low:
        axis.set_ylim(low - 0.05 * (high - low), high + 0.08 * (high - low))
    axis.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axis.set_ylabel(with_unit("torque", result.drive_torque.attrs["units"]))
