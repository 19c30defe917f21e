"""A cycle up and down: run up, switched off when it has settled, run down; its vibration, loads, energy and damage."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.observed_loads import LoadedRun, loaded_runs
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.run_ups.start_stop_cases import SLOW_EVENT, drives_without_circuit, start_case, stop_case, supplied_energy
from wucht.dynamics.verdicts.observation import speed_at_largest
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.fatigue.counting import rainflow
from wucht.fatigue.damage import AccumulatedDamage, WoehlerLine
from wucht.machines.machine import SUPPLIED_WORK, Machine
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS, line_style, mark_natural_frequencies
from wucht.results.formatting import abscissa_label, with_unit
from wucht.results.report import answer_in_print
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.foundation_variables import state_largest_forces, state_static_loads
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Start, Tolerance
from wucht.studies.motion_variables import state_natural_vibrations
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import MachineSignalName, Woehler, woehler_line, woehler_validator
from wucht.studies.study import FULL_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_UP_SHARE = 0.5  # of the time that both runs take
_STEPS = 300  # of the damage over time
_SLOW = 0.05  # of the highest speed: slower than that nothing is drawn
_KILO = 1e4  # J: from there on in kJ

Prepared = tuple[RunUpCase, MachineSignal | None, WoehlerLine | None]


class StartStop(Study):
    """Run the machine up, switch its drives off, and let it run down: vibration, loads, energy and damage of a cycle."""

    kind = "start-stop"
    next_questions = (
        NextQuestion("what happens when it is switched off", {"study.kind": "coast-down"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    horizon = ("until",)
    meaning = (*Study.meaning, "signal")
    curves = (("time", "amplitude"), ("energy_time", "supplied_energy"))
    solves = FULL_EQUATIONS
    from_start = True

    until: SI[float | None] = si("s", "time", default=None, gt=0, help=(
        "time at which the drives are switched off; by default when the machine has settled"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict)
    signal: MachineSignalName = Field(default="displacement", title="signal", description=(
        'load of the part, for `woehler`: `"displacement"` of the carrier, `"spring-force"`, `"bearing-force"` (of the bodies '
        'on it) or `"acceleration"`'
    ))  # fmt: skip
    direction: Literal["x", "y", "r"] | None = Field(
        default=None, description="direction of the signal, by default the first that the machine has"
    )
    woehler: Composite[Annotated[Woehler | None, woehler_validator("study.woehler")]] = composite(
        default=None, description="Woehler line for the damage, a table"
    )
    target_life: SI[float | None] = si("s", "target life", default=None, gt=0, help=(
        "time of operation that the part has to endure, between whose starts and stops the machine runs steadily"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """Check that keys of the damage are given with a Woehler line only."""
        if self.woehler is not None:
            self.woehler.check("study.woehler")
        for key in ("target_life", "direction", "signal") if self.woehler is None else ():
            if key in self.model_fields_set and getattr(self, key) is not None:
                raise InputError(f"study.{key}", getattr(self, key), "allowed only with study.woehler", code="not-allowed")

    def turning(self) -> str:
        """See ``Study``."""
        return "driven by its motors, then without them"

    def prepare(self, machine: Machine) -> Prepared:
        """Return the run-up, and the signal of the part with its Woehler line. Raises ``InputError``."""
        case = start_case(machine, self.start, RunSettings(until=self.until, tolerance=self.tolerance, engine=self.engine))
        if self.woehler is None:
            return case, None, None
        signal = machine_signal(case.machine, self.signal, self.direction)
        return case, signal, woehler_line(self.woehler, signal.unit, "study.woehler")

    def stored_numbers(self, prepared: Prepared) -> float:
        """Bound: time and value of two turning points a turn at the highest speed expected."""
        horizon = prepared[0].horizon
        return 4 * horizon.first / (horizon.step * horizon.samples_per_turn)

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Integrate the cycle leg by leg."""
        case, signal, line = prepared
        for up in loaded_runs(case, signal, 0.0, work.part("up", 0.0, _UP_SHARE)):
            yield Answer(machine.units, partial(self._fill, machine, prepared, up, None))
        settings = RunSettings(tolerance=self.tolerance, engine=self.engine)
        stop = None if up.trajectory.failure else stop_case(case.machine, up.trajectory, settings)
        if stop is None:
            return
        signal = None if line is None else machine_signal(stop.machine, self.signal, self.direction)
        for down in loaded_runs(stop, signal, up.trajectory.end_time, work.part("down", _UP_SHARE, 1.0)):
            yield Answer(machine.units, partial(self._fill, machine, prepared, up, down))

    def _fill(self, machine: Machine, prepared: Prepared, up: LoadedRun, down: LoadedRun | None, a: Answer) -> None:
        verdict, runs = up.verdict, [up, *([] if down is None else [down])]
        a.failure = next((r.trajectory.failure for r in runs if r.trajectory.failure), None)
        a.warn(*([a.failure] if a.failure else []), *up.case.horizon.warnings, *up.case.models[0].warnings)
        a.attribute(outcome=str(verdict.outcome))
        a.sentence = f"up: {verdict.sentence}"
        down_time = None if down is None else down.trajectory.end_time
        if down is not None:
            duration, is_slow = f"{down_time:.4g} {machine.units.time}".strip(), down.trajectory.stopped_by == SLOW_EVENT
            a.sentence += f"; down in {duration}" if is_slow else f"; down: {down.verdict.outcome.sentence} after {duration}"
        if bare_drives := [d.on for d in drives_without_circuit(up.case.machine)]:
            shafts = " and ".join(bare_drives)
            a.assume(f"the energy from the supply is the work on the shaft of {shafts}, whose torque alone is known")
        a.number("outcome", str(verdict.outcome), "outcome of the run-up")
        _state_peak(a, machine, "up", up)
        off, amplitude = up.trajectory.end_time, (verdict.amplitudes or [None])[0]
        speed_name = f"speed of {up.case.machine.rotor.name} before the switch-off"
        a.number("operating_amplitude", amplitude, "mean amplitude of the axis before the switch-off", machine.orbit_unit)
        a.number("operating_speed", verdict.speed, speed_name, "speed")
        a.number("settling_time", verdict.settling_time, "time until the speed has settled", "time")
        a.number("switch_off_time", off, "time at which the drives are switched off", "time")
        a.line("operation", "{operating_amplitude} at {operating_speed}; switched off at {switch_off_time:.4g}")
        _state_peak(a, machine, "down", down)
        a.number("down_time", down_time, "time of the coast-down", "time")
        if verdict.advice:
            a.warn(f"at the switch-off the machine does not run steadily yet: {verdict.advice}")
        if machine.schedules and SCHEDULE_WORK in up.trajectory.quadratures:
            a.warn("schedules end at the switch-off: on its way down the machine keeps the values that they have then")
        _state_loads(a, runs)
        _state_energy(a, up, down_time or 0.0)
        self._state_damage(a, prepared, up, down)
        courses = [MotionCourse.from_turns(r.case.machine, r.trajectory, r.loads.observation) for r in runs]
        a.curve("time", np.concatenate([c.time + at for c, at in zip(courses, (0.0, off), strict=False)]), "time", "time")
        a.curve("rotor", [r.name for r in machine.rotors], "rotor")
        a.curve("rotor_speed", np.concatenate([c.speeds for c in courses], axis=1), "speed", "speed", "rotor time")
        amplitudes = np.concatenate([c.amplitude for c in courses])
        a.curve("amplitude", amplitudes, "amplitude of the axis", machine.orbit_unit, "time")
        state_natural_vibrations(a, up.case.machine, in_summary=False)

    def _state_damage(self, a: Answer, prepared: Prepared, up: LoadedRun, down: LoadedRun | None) -> None:
        """State Miner's sum of a cycle and of steady operation, and how many cycles the target life allows."""
        _, signal, line = prepared
        if line is None or signal is None:
            a.number("damage", None, "Miner's sum of a cycle")
            return
        histories = [r.loads.points.points_to_end() for r in (up, down) if r is not None]
        times, values = (np.concatenate([history[k] for history in histories]) for k in (0, 1))
        damage, (begin, end), rate, allowed = _damage_of(line, values), up.verdict.window, None, None
        if up.verdict.outcome not in OPEN_OUTCOMES and end > begin:
            up_times, up_values = histories[0]
            rate = _damage_of(line, up_values[(up_times >= begin) & (up_times <= end)]) / (end - begin)
        life, is_done = self.target_life, down is not None
        if life is not None and rate is not None:
            allowed = allowed_cycles(damage, rate, up.trajectory.end_time, life)
        cycles = 1 / damage if damage and is_done else None
        a.number("damage", damage if is_done else None, "Miner's sum of a cycle", headline=True)
        a.number("operation_damage", rate, "Miner's sum of a time of steady operation", "1/time")
        a.number("cycles", cycles, "cycles until the part fails, without operation between them")
        a.number("allowed_cycles", allowed if is_done else None, "cycles that the target life allows")
        a.number("target_life", life, "target life", "time")
        a.number("signal", signal.name, "signal whose cycles are counted")
        a.number("largest_range", float(np.ptp(values)), "largest range of the signal", signal.unit)
        if is_done:
            a.line("damage", "{damage:.4g} a cycle" + ("" if cycles is None else "; the part endures {cycles:.4g} cycles"))
            a.line("in operation", "damage {operation_damage:.4g}")
        if life is not None and rate is None:
            a.warn("the damage of operation is not known, nor how many cycles the target life allows: run longer")
        elif life is not None and is_done:
            number = "any number of" if allowed is None else f"{math.floor(allowed):.6g}"
            duration = f"{life / 3600:.5g} h" if life >= 3600 else f"{life:.4g} s"
            a.line("target life", f"{duration} of operation allow {number} cycles")
        ends = np.unique(np.linspace(0, len(values), min(_STEPS, len(values)) + 1).round().astype(int))[1:]
        damage_so_far, course = AccumulatedDamage(line), list[float]()
        for stretch in np.split(values, ends[:-1]):
            damage_so_far = damage_so_far.update(stretch)
            course.append(damage_so_far.total)
        a.curve("damage_time", times[ends - 1], "time", "time")
        a.curve("damage_course", np.array(course), "damage so far", "", "damage_time")

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw speeds, amplitude, energy and damage over the time of the cycle."""
        panels = [_speeds, _amplitude, _energy, *([_damage] if "damage_course" in result else [])]
        fig, axes = new_figure(len(panels), result.attrs["title"], answer_in_print(result), 1.6)
        off = result.wucht.summary["switch_off_time"]
        for draw_panel, axis in zip(panels, axes, strict=True):
            label = "switched off" if axis is axes[0] else None
            axis.axvline(off, label=label, color="black", linestyle="--", linewidth=0.9)
            draw_panel(axis, result)
            legend_beside(axis)
        fast = np.abs(result.rotor_speed.values).max(axis=0)
        if (end := float(result.time.values[fast >= _SLOW * fast.max()][-1])) > 0:
            axes[-1].set_xlim(0.0, end)
        axes[-1].set_xlabel(abscissa_label(result, "time"))
        return fig


def allowed_cycles(damage: float, rate: float, up_time: float, life: float) -> float | None:
    """Return the number of cycles until the part fails just at the end of its target life, in which the run-ups are counted.

    n (damage - rate up_time) + rate life = 1: what a cycle damages more than operation of the same time. None where that is
    nothing, so that any number is allowed; 0 where operation alone is too much.
    """
    left, extra = 1 - rate * life, damage - rate * up_time
    if left <= 0:
        return 0.0
    return left / extra if extra > 0 else None


def _damage_of(line: WoehlerLine, values: np.ndarray) -> float:
    return float(line.damages(rainflow(values, "repeat")).sum())


def _state_peak(a: Answer, machine: Machine, way: str, run: LoadedRun | None) -> None:
    """State the largest amplitude on a way, and the speed there."""
    peak = None if run is None else run.loads.observation.largest
    speed = None if run is None else speed_at_largest(run.case.machine, run.loads.observation)
    a.number(
        f"peak_amplitude_{way}", peak, f"largest amplitude of the axis on the way {way}", machine.orbit_unit, headline=True
    )
    there = f"mean speed of {machine.rotor.name} over the turn there"
    a.number(f"peak_speed_{way}", None if speed is None else abs(speed), there, "speed")
    if peak:
        at_speed = "" if speed is None else f", at {{peak_speed_{way}}}"
        a.line(way, f"{{peak_amplitude_{way}}} at most{at_speed}")


def _state_loads(a: Answer, runs: list[LoadedRun]) -> None:
    forces, travels = (
        {name: max(values[name] for values in maxima) for name in maxima[0]}
        for maxima in ([dict(r.loads.bearing_forces) for r in runs], [dict(r.loads.travels) for r in runs])
    )
    a.number("bearing_forces", forces, "largest force of each rotor, with the bodies about it, on the carrier", "force")
    a.number("mount_travel", travels, "largest distance of each mount from its position at rest", "length")
    a.line("bearings", f"{_fields('bearing_forces', forces)} at most, of each rotor on the carrier")
    static = state_static_loads(a, runs[0].case.machine)
    for way, run in zip(("up", "down"), runs, strict=False):
        state_largest_forces(a, way, static, run.loads.foundation_forces)
    if travels:
        a.line("travel", f"{_fields('mount_travel', travels)} at most from rest")


def _fields(key: str, values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {{{key}.{name}}}" for name in values)


def _state_energy(a: Answer, up: LoadedRun, down_time: float) -> None:
    """State energy and work of the drives, also over the time of the cycle: after the switch-off they stay."""
    times, energy, work = up.trajectory.time, supplied_energy(up.trajectory), up.trajectory.quadratures[SUPPLIED_WORK]
    if down_time:
        times, energy, work = (np.append(x, x[-1]) for x in (times, energy, work))
        times[-1] += down_time
    a.number("energy", float(energy[-1]), "energy that the drives take from the supply", "energy", headline=True)
    a.number("shaft_work", float(work[-1]), "work of the drives on their shafts", "energy")
    a.line("energy", "{energy} from the supply, {shaft_work} of it as work on the shafts")
    a.curve("energy_time", times, "time", "time")
    a.curve("supplied_energy", energy, "energy from the supply", "energy", "energy_time")
    a.curve("shaft_work_course", work, "work on the shafts", "energy", "energy_time")


def _speeds(axis: Axes, result: xr.Dataset) -> None:
    """Draw the speeds, forwards, and the natural frequencies."""
    for k, name in enumerate(map(str, result.rotor.values)):
        axis.plot(result.time, np.abs(result.rotor_speed[k]), label=name, **line_style(k))
    highest = float(np.abs(result.rotor_speed).max())
    natural = np.unique(np.round(result.natural_frequency.values, 9))
    visible = natural[natural <= 1.05 * highest]
    mark_natural_frequencies(axis, visible.tolist())
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
