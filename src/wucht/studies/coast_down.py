"""Coast-down of a rotor after its drive is switched off: its duration, and the vibration as it passes the resonances."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from wucht.dynamics.run_ups.coasting import CarrierStart, further_angle
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.initial_state import angles_in, format_phases
from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.dynamics.scenarios.coast_downs import CoastDownCase, CoastDownRun, coast_down, coast_down_cases
from wucht.dynamics.scenarios.runs_in_turn import runs_in_turn
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS, GREY, line_style, mark_levels
from wucht.plots.time_courses import RANGE, TurnWindows, draw_greatest
from wucht.results.formatting import abscissa_label
from wucht.results.report import answer_in_print
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.foundation_variables import state_largest_forces, state_static_loads
from wucht.studies.from_rest_variables import FROM_REST_WORDS, state_ends_from_rest
from wucht.studies.key_types import DEFAULT_TOLERANCE, BalancingBodies, Engine, Start, Tolerance
from wucht.studies.motion_variables import state_natural_vibrations, state_parameters
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import FULL_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_VISIBLE_RANGE = 1e-2  # of the range of the mean speed: a narrower range about it is not drawn
_LAST = 0.1  # share of the run over which the speeds at the end are taken
_STARTS = {
    CarrierStart.STEADY: "it starts in the steady vibration of its speed",
    CarrierStart.REST: "the carrier starts at rest",
    CarrierStart.GIVEN: "the carrier starts as given by study.start",
    CarrierStart.FIXED: "the carrier moves as prescribed",
}

Prepared = tuple[tuple[CoastDownCase, ...], str]  # the runs, and why the rotors are at the phases of the start


class CoastDown(Study):
    """Let the machine run without its drives; loads, bearings and dampers remain."""

    kind = "coast-down"
    next_questions = (
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves = (("time", "speed"), ("speed", "amplitude"))
    solves = FULL_EQUATIONS

    until: SI[float | None] = si("s", "time", default=None, gt=0, help=(
        "time at which the run ends; by default when the rotor has stopped, swings, or turns at a hundredth of its speed"
    ))  # fmt: skip
    start: Composite[Start] = composite(default_factory=dict, description=(
        "initial state; rotors without a given speed start with the speed that their drive reaches (several in a synchronous "
        "configuration: with its speed), and the bodies about them turn along. Phases of several rotors and bodies select the "
        'nearest stable configuration; with `bodies = "held"` they are the phases at the start'
    ))  # fmt: skip
    bodies: BalancingBodies = Field(default=None, description=(
        'where balancing bodies start: `"steady"`, in a stable steady configuration of that speed (one that compensates before '
        'others); or `"held"`, at the phases of `start`, by default at 0. By default steady where `start` names none of them '
        "and these phases are known, else held, with a warning if this key is not given. Several rotors and the bodies about "
        "them start in a stable synchronous configuration: a run from each, or from the one that `start` selects"
    ))  # fmt: skip
    vibration: Literal["steady", "none"] | None = Field(default=None, description=(
        'vibration of the carrier at the start: `"steady"`, the vibration while all bodies turn with their speeds and '
        'phases at the start; or `"none"`, at rest, so that a transient comes first. If `start` gives the motion of the '
        "carrier, it starts with that"
    ))  # fmt: skip
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """See ``Study``."""
        if self.vibration is not None and "carrier" in self.start:
            raise InputError("study.vibration", self.vibration, "not allowed: study.start.carrier gives the carrier's start")

    def turning(self) -> str:
        """See ``Study``."""
        return "without its drives"

    def prepare(self, machine: Machine, watch: Callable[[], None] | None = None) -> Prepared:
        """Return the runs, and why the rotors are at the phases of the start. watch: called often. Raises ``InputError``."""
        settings = RunSettings(self.until, tolerance=self.tolerance, engine=self.engine)
        return coast_down_cases(machine, self.start, self.bodies, self.vibration, settings, watch)

    def stored_numbers(self, prepared: Prepared) -> float:
        """Bound: time and mean speed of each turn, at the rate of turns of the start."""
        return sum(2 * case.limit * abs(case.start_speed) / (2 * math.pi) for case in prepared[0])

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Integrate run by run, and at last the run-up that shows whether their states are reached from rest."""
        cases, _ = prepared
        for runs in runs_in_turn(cases, coast_down, work, "run"):
            yield Answer(machine.units, partial(_fill, machine, prepared, runs, None))
        if operations := [case.operation for case in cases if case.operation is not None]:
            from_rest = FromRest.of(machine, machine.rotor.name, operations, work)
            yield Answer(machine.units, partial(_fill, machine, prepared, runs, from_rest))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the speed, and the amplitude if the carrier moves."""
        moves = bool(np.nanmax(result.amplitude.values, initial=0.0) > 0)
        fig, axes = new_figure(1 + moves, result.attrs["title"], answer_in_print(result), 2.0)
        start = f"from {result.configuration_name.values[0]}" if "run_speed" in result else ""
        windows = TurnWindows.of(result.time.values, result.angle.values, float(result.time[-1]))
        _speed(axes[0], result, windows, start)
        if moves:
            amplitude, name = printed_values(result, "amplitude")
            draw_greatest(axes[1], windows, amplitude, color=COLOURS[0], linewidth=1.1, label=start or "amplitude")
            axes[1].set(ylabel=name, ylim=(0, None))
        if start:
            _draw_other_runs(axes, result, moves)
        if result.sizes["time"] > 1:
            axes[-1].set_xlim(float(result.time[0]), float((result.run_time if start else result.time)[-1]))
        axes[-1].set_xlabel(abscissa_label(result, "time"))
        for axis in axes:
            legend_beside(axis)
        return fig


def _fill(machine: Machine, prepared: Prepared, runs: Sequence[CoastDownRun], from_rest: FromRest | None, a: Answer) -> None:
    cases, first = prepared[0], runs[0]
    case, record, is_reached = first.case, first.record, _reached_states(cases, from_rest)
    a.line("speed", "{start_speed} at the start, {final_speed} on average at the end")
    ending = _state_end(a, first)
    for k, run in enumerate(runs[1:], 1):
        half = "" if run.record.half_time is None else "; halved after {half_time:.5g}"
        text = f"{run.case.label}: {{peak_amplitude}} at most, from {{start_speed}}{half}"
        a.line("other start", text, at=f"configurations[{k}]")
    a.line("halved", "not within this time" if record.half_time is None else "after {half_time:.5g}")
    a.line("turns back", "at {reversal_time:.6g}")
    a.line("turned", "{turns:.5g} times in {end_time:.5g}")
    _state_course(a, machine, first)
    _state_rows(a, machine, first.rows)
    a.curve("turn_time", record.turns[0], "time", "time", "turn", coordinate=True)
    a.curve("mean_speed", record.turns[1], "mean speed over a turn", "speed", "turn")
    state_natural_vibrations(a, case.machine, in_summary=False)
    state_parameters(a, case.machine)
    a.curve("end_state", record.end.end_state, "state and accumulated works at the end", "", "state")
    if case.label:
        _state_configurations(a, machine, runs, is_reached)
    a.number("reached_from_rest", is_reached[0], f"state at the start: {FROM_REST_WORDS[0]}")
    state_ends_from_rest(a, from_rest)
    unit = f" {machine.units.time}" if machine.units.time else ""
    half = "" if record.half_time is None else f"; the speed has halved after {record.half_time:.5g}{unit}"
    back = "".join(f"; it turns back at {time:.5g}{unit}" for time in record.reversals[:1])
    several = f"; the first of {len(cases)} runs, one from each stable configuration" if len(cases) > 1 else ""
    a.sentence = f"{ending}{half}{back}{several}"
    a.verdict = f"{first.outcome.upper()}: {ending}" if first.outcome else ending
    a.attribute(outcome=str(first.outcome or ""), engine=first.flow.engine_name, tolerance=first.flow.tolerance)
    a.failure = next((run.record.end.failure for run in runs if run.record.end.failure), None)
    _warn(a, prepared, first, from_rest, is_reached)
    _assume(a, cases)


def _reached_states(cases: Sequence[CoastDownCase], from_rest: FromRest | None) -> list[bool | None]:
    """Return for each run whether the state in which it starts is reached from rest."""
    if from_rest is None:
        return [None] * len(cases)
    return from_rest.is_reached(cases[0].machine.rotor.name, [c.operation for c in cases if c.operation is not None])


def _state_end(a: Answer, run: CoastDownRun) -> str:
    """State the end of the run, and return it in words; speeds over its last tenth, or from the first reversal on if shorter.

    ``failed``, ``stopped`` and ``oscillating`` are those of a run-up. Otherwise there is no outcome: the rotor still turns, or
    its swing may yet die out.
    """
    record, outcome = run.record, run.outcome
    time, start = record.rows["time"], abs(record.start_speed)
    since = time[-1] - _LAST * (time[-1] - time[0])
    if record.reversals:
        since = min(max(since, record.reversals[0]), float(time[-2]))
    late = {name: column[time >= since] for name, column in record.rows.items()}
    duration = float(late["time"][-1] - late["time"][0])
    mean = float((late["angle"][-1] - late["angle"][0]) / duration) if duration else float(late["speed"][-1])
    speed = mean if record.reversals or not record.turns.size else record.turns[1, -1]
    turning = "the rotor has turned back" if record.reversals else "the rotor still turns"
    ending = outcome.sentence if outcome else f"{turning}, at {100 * abs(speed / start):.3g} % of its speed at the start"
    a.number("outcome", outcome and str(outcome), "outcome")
    a.number("sentence", ending, "sentence on the end of the run")
    a.number("final_speed", mean, "mean speed of the rotor at the end", "speed")
    a.number("min_speed", float(late["min_speed"].min()), "least speed of the rotor at the end", "speed")
    a.number("max_speed", float(late["max_speed"].max()), "greatest speed of the rotor at the end", "speed")
    return ending


def _state_course(a: Answer, machine: Machine, run: CoastDownRun) -> None:
    """State times of the coast-down, number of turns, and largest vibration."""
    record, rows, peak_speed = run.record, run.rows, run.peak_speed
    a.number("start_speed", record.start_speed, "speed of the rotor at the start", "speed", headline=True)
    a.number("half_time", record.half_time, "time after which the speed has halved", "time", headline=True)
    back = next(iter(record.reversals), None)
    a.number("reversal_time", back, "time at which the rotor first turns back", "time", headline=True)
    a.number("end_time", float(rows["time"][-1]), "time at the end", "time", headline=True)
    a.number("turns", float(rows["angle"][-1] - rows["angle"][0]) / (2 * math.pi), "number of turns")
    a.number("carrier_start", str(run.case.carrier), "start of the carrier")
    a.number("peak_amplitude", run.peak_amplitude, "largest amplitude of the axis", machine.orbit_unit, headline=True)
    a.number("peak_speed", peak_speed, "mean speed of the rotor over the turn there", "speed")
    there = "" if peak_speed is None else ", at {peak_speed}"
    a.line("amplitude", f"{{peak_amplitude}} at most{there}; {_STARTS[run.case.carrier]}")
    state_largest_forces(a, "", state_static_loads(a, run.case.machine), record.foundation_forces)
    a.number("energy_residual", float(rows["energy_residual"].max()), "largest relative error of the energy balance")
    a.line("energy", "balance closed to {energy_residual:.1e}")


def _state_rows(a: Answer, machine: Machine, rows: Mapping[str, np.ndarray]) -> None:
    """State what is recorded over the time."""
    a.curve("time", rows["time"], "time", "time")
    a.curve("angle", rows["angle"], "angle of the rotor", "rad", "time")
    a.curve("speed", rows["speed"], "speed of the rotor", "speed", "time")
    a.curve("min_speed", rows["min_speed"], "least speed since the last sample", "speed", "time")
    a.curve("max_speed", rows["max_speed"], "largest speed since the last sample", "speed", "time")
    a.curve("amplitude", rows["amplitude"], "amplitude of the axis", machine.orbit_unit, "time")
    a.curve("energy_residual", rows["energy_residual"], "energy residual, relative", "", "time")
    a.curve("dissipated_work", rows["dissipated_work"], "energy dissipated", "energy", "time")
    if further := [r.name for r in machine.rotors[1:]]:
        angles = [rows["angle"], *(rows[further_angle(name)] for name in further)]
        a.curve("rotor", [machine.rotor.name, *further], "rotor")
        a.curve("rotor_angle", angles, "angle of each rotor", "rad", "rotor time")


def _state_configurations(a: Answer, machine: Machine, runs: Sequence[CoastDownRun], is_reached: Sequence[bool | None]) -> None:
    """State the run from each configuration of several rotors, and over one time if there are several."""
    records, labels = [run.record for run in runs], [run.case.label for run in runs]
    a.table(
        "configurations", "the run from each stable synchronous configuration",
        configuration=(labels, "configuration in which the rotors start"),
        outcome=([run.outcome and str(run.outcome) for run in runs], "outcome"),
        reached_from_rest=(is_reached[: len(runs)], *FROM_REST_WORDS),
        start_speed=([record.start_speed for record in records], "speed of the main rotor at the start", "speed"),
        half_time=([record.half_time for record in records], "time after which the speed has halved", "time"),
        end_time=([float(run.rows["time"][-1]) for run in runs], "time at the end", "time"),
        peak_amplitude=([run.peak_amplitude for run in runs], "largest amplitude of the axis", machine.orbit_unit),
        peak_speed=([run.peak_speed for run in runs], "mean speed of the rotor over the turn there", "speed"),
    )  # fmt: skip
    if len(runs) == 1:
        return
    longest = max((run.rows["time"] for run in runs), key=lambda time: float(time[-1]))
    speeds, amplitudes = (
        np.array([np.interp(longest, run.rows["time"], run.rows[name], right=np.nan) for run in runs])
        for name in ("speed", "amplitude")
    )
    what = "configuration in which the rotors start"
    a.curve("configuration_name", np.array(labels, str), what, "", "configuration", coordinate=True)
    a.curve("run_time", longest, "time", "time", coordinate=True)
    a.curve("run_speed", speeds, "speed of the rotor in each run", "speed", "configuration run_time")
    a.curve("run_amplitude", amplitudes, "amplitude of the axis in each run", machine.orbit_unit, "configuration run_time")


def _warn(
    a: Answer, prepared: Prepared, first: CoastDownRun, from_rest: FromRest | None, is_reached: Sequence[bool | None]
) -> None:
    """State what is in doubt."""
    (cases, held_reason), case = prepared, first.case
    a.warn(*([a.failure] if a.failure else []))
    if held_reason:
        a.warn(f"the rotors start at the phases of the start: {held_reason}")
    if case.carrier is CarrierStart.REST:
        steady = "vibration = 'steady' starts with the vibration of that speed"
        advice = f"the machine {case.rest_reason}" if case.rest_reason else steady
        a.warn(
            "the carrier starts at rest, although the rotor turns: its initial vibration, possibly the largest, is a transient "
            f"of this start; {advice}"
        )
    if case.bodies.held_reason:
        reason = f"because their steady phases are not computed: {case.bodies.held_reason}"
        a.warn(f"balancing bodies start as held, {reason}")
    if from_rest is not None and not all(is_reached):
        labels = [one.label for one in cases]
        subject = "operating state at the start" if len(labels) == 1 else "operating states at the start"
        a.warn(f"{subject}: {from_rest.sentence(is_reached, labels)}")
    if first.outcome is None and first.record.reversals and first.verdict.advice:
        a.warn(first.verdict.advice)


def _assume(a: Answer, cases: Sequence[CoastDownCase]) -> None:
    """State where the carrier, several rotors and the balancing bodies start: the vibration depends on their phases."""
    case, machine = cases[0], cases[0].machine
    if case.carrier in (CarrierStart.STEADY, CarrierStart.REST):
        at_first = "in the steady vibration of its speed" if case.carrier is CarrierStart.STEADY else "at rest"
        a.assume(f"the carrier starts {at_first}")
    if case.label:
        unit = f" {machine.units.speed}" if machine.units.speed else ""
        starts = [f"{one.label}, from {abs(one.start_speed):.5g}{unit}" for one in cases[1:]]
        more = f"; the other runs start in {' and in '.join(starts)}" if starts else ""
        a.assume(f"rotors start in the stable synchronous configuration {case.label} (averaged equations){more}")
    elif len(machine.rotors) > 1:
        angles = angles_in(machine, case.initial)
        a.assume(f"rotors start at {format_phases({r.name: angles[r.name] for r in machine.rotors})}")
    a.assume(*case.bodies.assumptions(case.phases))


def _draw_other_runs(axes: Sequence[Axes], result: xr.Dataset, moves: bool) -> None:
    """Draw the runs that start in other configurations."""
    for k, name in enumerate(map(str, result.configuration_name.values)):
        if k:
            style: dict[str, Any] = {"color": COLOURS[2 + k % 4], "linewidth": 0.9, "linestyle": "-.", "label": f"from {name}"}
            axes[0].plot(result.run_time, result.run_speed[k], **style)
            if moves:
                axes[1].plot(result.run_time, printed_values(result, "run_amplitude")[0][k], **style)


def _draw_oscillation(axis: Axes, result: xr.Dataset, windows: TurnWindows, begin: float) -> None:
    """Draw the speed from the last whole turn on, or its mean where it swings too fast to be drawn: its range is there."""
    speed, after, late = result.speed.values, result.time.values >= begin, windows.at >= begin
    if late.any() and windows.shares(speed, float(np.ptp(speed)))[late].all():
        axis.plot(windows.at[late], windows.means(speed)[late], color=COLOURS[0], linewidth=1.3)
    else:
        axis.plot(result.time[after], result.speed[after], color=COLOURS[0], linewidth=0.5)


def _speed(axis: Axes, result: xr.Dataset, windows: TurnWindows, start: str) -> None:
    """Draw the mean speed over each turn, the range of the speed, and the times of half speed and of the reversal.

    start: words on the start of the run for the legend where there are several, else empty.
    """
    summary, time, blue = result.wucht.summary, result.time, COLOURS[0]
    start_speed, half_time, reversal_time = (summary[key] for key in ("start_speed", "half_time", "reversal_time"))
    names = [str(name) for name in result.rotor.values] if "rotor_angle" in result else []
    turns = result.sizes["turn"] > 1
    at, mean = (result.turn_time, result.mean_speed) if turns else (time, result.speed)
    course = np.interp(windows.at, at.values, mean.values)
    low, high = (windows.extremes(x.values, course)[k] for k, x in enumerate((result.min_speed, result.max_speed)))
    if (high - low).max() > _VISIBLE_RANGE * np.ptp(mean.values):
        axis.fill_between(windows.at, low, high, color=COLOURS[4], alpha=0.5, linewidth=0, label=RANGE)
    text = start or ("mean over a turn" if turns else "speed")
    axis.plot(at, mean, color=blue, linewidth=1.3, label=", ".join([*names[:1], text]))
    for k, name in enumerate(names[1:], 1):
        axis.plot(windows.at, windows.rates(result.rotor_angle.values[k]), **line_style(k) | {"label": ", ".join([name, text])})
    natural = np.unique(np.round(result.natural_frequency.values, 9))
    mark_levels(axis, np.sign(start_speed) * natural[np.abs(natural) <= 1.05 * abs(start_speed)], "natural frequency")
    if half_time is not None:
        axis.plot([half_time], [start_speed / 2], "o", color=COLOURS[1], markersize=5, zorder=4, label="speed halved")
    if reversal_time is not None:
        axis.plot([reversal_time], [0.0], "s", color=COLOURS[2], markersize=5, zorder=4, label="turns back")
        axis.axhline(0.0, color=GREY, linewidth=0.6)
        _draw_oscillation(axis, result, windows, float(at[-1]) if turns else reversal_time)
    name_speeds(axis, result)
