"""Coast-down of a rotor after its drive is switched off: its duration, and the vibration as it passes the resonances."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from wucht.analysis.vibration import unbalances
from wucht.analysis.working_points import energy_scale
from wucht.dynamics.run_ups.coasting import (
    REVERSAL,
    CarrierStart,
    Descent,
    Record,
    driving_machine,
    further_angle,
    phases_of_bodies,
    place_bodies,
    reduce_leg,
    state_at_start,
    vibrating_state,
    without_drives,
)
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.initial_state import angles_in, format_phases, machine_in_state, start_gives
from wucht.dynamics.run_ups.operating_points import SteadyState, steady_state
from wucht.dynamics.run_ups.operating_state import states_in_configurations
from wucht.dynamics.run_ups.run_up import RunUpCase, verdict_at_end
from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.dynamics.run_ups.steady_phases import HELD_HINT, BodyPhases
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver, speed_at_largest
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import axis_at_rest, natural_frequencies
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.plots.scales import name_speeds, printed_values
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS, GREY, line_style, mark_levels
from wucht.plots.time_courses import RANGE, TurnWindows, draw_greatest
from wucht.results.formatting import ReportLines, abscissa_label
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.schema import SI, Composite, composite, si
from wucht.studies.from_rest_variables import FROM_REST_WORDS, from_rest_quantities
from wucht.studies.motion_variables import natural_vibrations, parameter_values
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, BalancingBodies, Engine, Spec, Start, Tolerance

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class CoastDown(Spec):
    """Let the machine run without its drives; loads, bearings and dampers remain."""

    kind: ClassVar[str] = "coast-down"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("time", "speed"), ("speed", "amplitude"))
    solves: ClassVar[str] = FULL_EQUATIONS

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
        """See ``Spec``."""
        if self.vibration is not None and "carrier" in self.start:
            raise InputError("study.vibration", self.vibration, "not allowed: study.start.carrier gives the carrier's start")

    def turning(self) -> str:
        """See ``Spec``."""
        return "without its drives"


_WITHOUT_VIBRATION = 0.05  # share by which vibration may keep a rotor below the speed at which a run starts
SAMPLES_PER_TURN, _FEWEST_SAMPLES, _ROWS = 24, 64, 4000
_MOST_TURNS = 50_000


@dataclass(frozen=True)
class SingleCoastDown:
    """Plan of one run.

    machine: without its drives. initial: state (n,) at the start. carrier: its kind of start; rest_reason: why it starts at
    rest without being given so. bodies: kind of start of the balancing bodies; phases: their phases to the rotor. label: of
    the configuration in which several rotors start, empty without one. start_speed: of the main rotor. limit: latest end.
    step: between samples. stride: between rows of the result, initially. energy: scale of the works. rest_position: of the
    axis. events: the rotor turns back, and locked bodies are released. observer: of the motion, for its outcome. operation: the
    state in which the drives turn the machine at the start; None where study.start gives the speed, or bodies are held.
    """

    spec: CoastDown
    machine: Machine
    initial: np.ndarray
    carrier: CarrierStart
    rest_reason: str
    bodies: BodyPhases
    phases: Mapping[str, float]
    label: str
    start_speed: float
    limit: float
    step: float
    stride: float
    energy: float
    rest_position: Mapping[str, float]
    events: tuple[Event, ...]
    observer: MotionObserver
    operation: SteadyState | None = None

    def verdict(self, record: Record) -> Verdict:
        """The verdict on the motion so far: the criteria are those of a run-up."""
        assert record.observation is not None
        return verdict_at_end(self.machine, record.observation, record.end)


@dataclass(frozen=True)
class Plan:
    """Plan of the study: a run for each stable configuration of several rotors, else one.

    held_reason: why the rotors are at the phases of the start, empty where they are not or as requested. driven: the machine
    with its drives; None where no run starts as they turn it.
    """

    runs: tuple[SingleCoastDown, ...]
    held_reason: str = ""
    driven: Machine | None = None

    @property
    def operations(self) -> list[SteadyState]:
        """The states in operation in which the runs start."""
        return [one.operation for one in self.runs if one.operation is not None]


def prepare(spec: CoastDown, machine: Machine, watch: Callable[[], None] | None = None) -> Plan:
    """The plan. watch: called often. Raises ``InputError`` if the start does not fit the machine, or if nothing would turn."""
    coasting = without_drives(machine)
    initial = state_at_start(machine, coasting, spec.start)
    driven = None if start_gives(spec.start, machine.rotor.name, "speed") else machine
    if spec.bodies != "held" and len(machine.rotors) > 1:
        reason = "no synchronous configuration of the rotors is stable"
        try:
            states = states_in_configurations(driving_machine(machine), coasting, initial, spec.start, watch=watch)
        except InputError as error:
            states, reason = [], error.explanation
        if states:
            runs = (
                _one_run(spec, coasting, state, BodyPhases({}), label, steady_state(machine, c) if driven else None)
                for c, label, state in states
            )
            return Plan(tuple(runs), driven=driven)
        if spec.bodies == "steady":
            explanation = f"not possible here: {reason}; {HELD_HINT}"
            raise InputError("study.bodies", spec.bodies, explanation, code="no-stable-phases")
        return Plan((_single_run(spec, coasting, initial),), reason)
    one = _single_run(spec, coasting, initial)
    is_placed = one.phases and not one.bodies.to_rotor
    if driven is None or len(machine.rotors) > 1 or is_placed:
        return Plan((one,))
    share = _residual_share(coasting, one.phases) if one.bodies.to_rotor else None
    return Plan(
        (replace(one, operation=SteadyState(abs(one.start_speed), share=share, reach=_WITHOUT_VIBRATION)),), driven=driven
    )


def _residual_share(machine: Machine, phases: Mapping[str, float]) -> float | None:
    """The residual unbalance of a rotor with its bodies at phases, as a share of its own; None without one."""
    main, *moments = unbalances(machine)
    return float(abs(main + moments @ np.exp(1j * np.array(list(phases.values()))))) / abs(main) if main else None


def _single_run(spec: CoastDown, coasting: Machine, initial: np.ndarray) -> SingleCoastDown:
    """The run from given phases of the rotors. Raises ``InputError``."""
    bodies = BodyPhases.of(coasting, spec.start, float(initial[coasting.row(coasting.rotor.coordinate.velocity)]), spec.bodies)
    return _one_run(spec, coasting, place_bodies(coasting, initial, bodies.to_rotor), bodies)


def _one_run(
    spec: CoastDown, coasting: Machine, initial: np.ndarray, bodies: BodyPhases, label: str = "",
    operation: SteadyState | None = None,
) -> SingleCoastDown:  # fmt: skip
    """The run from a state (n,) with the carrier at rest. Raises ``InputError`` where its vibration is unbounded."""
    velocity = coasting.rotor.coordinate.velocity
    coasting = machine_in_state(coasting, initial)
    initial, carrier, rest_reason = vibrating_state(coasting, initial, spec.start, spec.vibration)
    start_speed = float(initial[coasting.row(velocity)])
    turn = 2 * math.pi / max([abs(start_speed), *(f for f in natural_frequencies(coasting).values() if f > 0)])
    limit = spec.until or _MOST_TURNS * turn
    return SingleCoastDown(
        spec, coasting, initial, carrier, rest_reason, bodies, phases_of_bodies(coasting, initial), label, start_speed, limit,
        step=limit / max(_FEWEST_SAMPLES, math.ceil(limit * SAMPLES_PER_TURN / turn)),  # a whole number of steps until the end
        stride=turn if spec.until is None else limit / _ROWS, energy=energy_scale(coasting),
        rest_position=axis_at_rest(coasting),
        events=(Event(REVERSAL, velocity, -1 if start_speed > 0 else 1), *release_events(coasting)),
        observer=RunUpCase.from_state(coasting, initial, RunSettings(spec.until, tolerance=spec.tolerance)).observer,
        operation=operation,
    )  # fmt: skip


def numbers(plan: Plan) -> float:
    """Greatest number of stored values: time and mean speed of each turn, at the rate of turns of the start."""
    return sum(2 * one.limit * abs(one.start_speed) / (2 * math.pi) for one in plan.runs)


SAMPLES_A_LEG = 20_480
SLOW = 0.01  # of the speed at the start: without `until` the run ends below it
_STILL = 1e-4  # likewise, after the rotor has turned back
_ENOUGH_SWINGS = 20
_AT_REST = (Outcome.STOPPED, Outcome.OSCILLATING)

Coasting = tuple[Record, CompiledSystem]  # the record so far, and the integrated system


@dataclass(frozen=True)
class Findings:
    """The runs so far. from_rest: the ends of run-ups from rest, None before it and where no run starts in operation."""

    runs: tuple[Coasting, ...]
    from_rest: FromRest | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate run by run; yield the records after each leg, and at last the state that is reached from rest."""
    complete_runs, count = list[Coasting](), len(plan.runs)
    for k, one in enumerate(plan.runs):
        part = work if count == 1 else work.part(f"run {k + 1}", k / count, (k + 1) / count)
        latest = None
        for latest in _descend(one, part):
            yield Findings((*complete_runs, latest))
        assert latest is not None
        complete_runs.append(latest)
    if plan.driven is not None:
        yield Findings(tuple(complete_runs), FromRest.of(plan.driven, plan.driven.rotor.name, plan.operations, work))


def _descend(plan: SingleCoastDown, work: Work) -> Iterator[Coasting]:
    """Integrate one run; yield the record after each leg."""
    flow = compile_system(plan.machine.system, plan.spec.tolerance, plan.events, plan.spec.engine)
    start = integrate(flow, plan.initial, plan.machine.values, np.zeros(1)).reraise_interrupt()
    record = Record(start_speed=plan.start_speed, stride=plan.stride, end=start, observation=plan.observer.begin())
    record = record.update(_reduce_and_observe(plan, flow, record, start))
    yield record, flow
    while not _has_ended(plan, record):
        record = record.update(work.unit(f"leg {record.legs + 1}", partial(_leg, plan, flow, record, work)))
        yield record, flow


def _leg(plan: SingleCoastDown, flow: CompiledSystem, before: Record, work: Work) -> Descent:
    """Integrate the leg that begins at the end of the preceding one."""
    last = before.end
    count = max(1, min(SAMPLES_A_LEG, round((plan.limit - last.end_time) / plan.step)))
    grid = last.end_time + plan.step * np.arange(count + 1)
    t = integrate(flow, last.end_state, last.final_parameter_values, grid, partial(_report, plan, work), plan.energy)
    return _reduce_and_observe(plan, flow, before, t.reraise_interrupt())


def _reduce_and_observe(plan: SingleCoastDown, flow: CompiledSystem, before: Record, t: Trajectory) -> Descent:
    """Reduce a leg to its record, and observe it."""
    assert before.observation is not None
    leg = reduce_leg(plan.machine, plan.rest_position, flow, before, t)
    return replace(leg, observation=plan.observer.update(before.observation, t))


def _report(plan: SingleCoastDown, work: Work, time: float) -> None:
    """Report the progress: a share of the time where that is given; else it is not known how long the rotor will turn."""
    work.report(0.0 if plan.spec.until is None else time / plan.limit)


def _has_ended(plan: SingleCoastDown, record: Record) -> bool:
    """True if the time is over, the run failed, or, without a time, the rotor has stopped, swung often enough, or is slow."""
    if record.end.has_ended or record.end.end_time >= plan.limit * (1 - 1e-9):
        return True
    if plan.spec.until is not None:
        return False
    rows, start_speed = record.rows, abs(record.start_speed)
    if record.reversals:
        is_enough = len(record.reversals) >= _ENOUGH_SWINGS or abs(rows["max_speed"][-1]) < _STILL * start_speed
        return is_enough and plan.verdict(record).outcome in _AT_REST
    return bool(record.turns.size) and abs(rows["speed"][-1]) < SLOW * start_speed


_LAST = 0.1  # share of the run over which the speeds at the end are taken


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of a coast-down: that of the first run, and the others beside it."""
    runs = [_RunResult.of(one, record) for one, (record, _) in zip(plan.runs, findings.runs, strict=False)]
    one, first, flow, end_from_rest = plan.runs[0], runs[0], findings.runs[0][1], findings.from_rest
    answers = _answers(plan, end_from_rest)
    record, units, end = first.record, one.machine.units, first.record.end
    quantities = [
        *first.at_the_end,
        *_course_quantities(one, record, first.rows),
        *_row_quantities(one.machine, first.rows),
        Quantity("turn_time", record.turns[0], "time", units.time, "turn", coordinate=True),
        Quantity("mean_speed", record.turns[1], "mean speed over a turn", units.speed, "turn"),
        *(q for q in natural_vibrations(one.machine) if q.dimensions),
        *parameter_values(one.machine),
        Quantity("end_state", end.end_state, "state and accumulated works at the end", "", "state"),
        *_configuration_quantities(one.machine, runs, answers),
        Quantity("reached_from_rest", answers[0], f"state at the start: {FROM_REST_WORDS[0]}"),
        *from_rest_quantities(end_from_rest, units),
    ]
    unit, reversal_time = f" {units.time}" if units.time else "", next(iter(record.reversals), None)
    half = "" if record.half_time is None else f"; the speed has halved after {record.half_time:.5g}{unit}"
    back = "" if reversal_time is None else f"; it turns back at {reversal_time:.5g}{unit}"
    assumptions = [*_carrier_assumptions(one), *_rotor_assumptions(plan), *one.bodies.assumptions(one.phases)]
    more = {"outcome": first.outcome or "", "engine": flow.engine_name, "tolerance": flow.tolerance}
    failure = next((run.record.end.failure for run in runs if run.record.end.failure), None)
    several = f"; the first of {len(plan.runs)} runs, one from each stable configuration" if len(plan.runs) > 1 else ""
    sentence = f"{first.ending}{half}{back}{several}"
    warnings = [*_warnings(plan, failure), *_reaching_warnings(plan, end_from_rest), *first.advice]
    return result_dataset(quantities, sentence, warnings, assumptions, failure, **more)


def _answers(plan: Plan, end: FromRest | None) -> list[bool | None]:
    """Return for each run whether the state in which it starts is reached from rest."""
    if end is None:
        return [None] * len(plan.runs)
    return end.is_reached(plan.runs[0].machine.rotor.name, plan.operations)


def _reaching_warnings(plan: Plan, end: FromRest | None) -> list[str]:
    """Return a warning where a run starts in a state that is not reached from rest, or where that is not known."""
    if end is None or all(answers := _answers(plan, end)):
        return []
    labels = [one.label for one in plan.runs]
    subject = "operating state at the start" if len(labels) == 1 else "operating states at the start"
    return [f"{subject}: {end.sentence(answers, labels)}"]


@dataclass(frozen=True)
class _RunResult:
    """A run with its rows (N,) by name, the sentence on its end, and the quantities of that."""

    plan: SingleCoastDown
    record: Record
    rows: Mapping[str, np.ndarray]
    ending: str
    at_the_end: list[Quantity]

    @classmethod
    def of(cls, plan: SingleCoastDown, record: Record) -> _RunResult:
        rows = dict(record.rows)
        if plan.carrier is CarrierStart.STEADY:  # as large before the run as in its first turn
            first = rows["time"] <= 2 * math.pi / abs(plan.start_speed)
            rows["amplitude"] = np.append(rows["amplitude"][first].max(), rows["amplitude"][1:])
        work, noise = rows["dissipated_work"], Noise.of(plan.spec.tolerance).angle * record.balance.scale
        if np.abs(work).max(initial=0.0) <= noise:  # of a rotor that nothing brakes, whose speed drifts by rounding
            rows["dissipated_work"] = np.zeros_like(work)
        return cls(plan, record, rows, *_ending(plan, record))

    @property
    def advice(self) -> list[str]:
        """How long to run until the outcome of a rotor that has turned back is known; nothing where it is."""
        advice = self.plan.verdict(self.record).advice if self.outcome is None and self.record.reversals else None
        return [advice] if advice else []

    @property
    def outcome(self) -> str | None:
        """The outcome, None while the rotor still turns."""
        return None if self.at_the_end[0].value is None else str(self.at_the_end[0].value)


def _configuration_quantities(machine: Machine, runs: Sequence[_RunResult], answers: Sequence[bool | None]) -> list[Quantity]:
    """The run from each configuration of several rotors, and over one time if there are several; none for a single rotor."""
    if not runs[0].plan.label:
        return []
    units, orbit, rows = machine.units, machine.orbit_unit, list[dict[str, Any]]()
    for run, answer in zip(runs, answers, strict=False):
        course = {q.name: q.value for q in _course_quantities(run.plan, run.record, run.rows)}
        keys = ("start_speed", "half_time", "end_time", "peak_amplitude", "peak_speed")
        names = {"configuration": run.plan.label, "outcome": run.outcome, "reached_from_rest": answer}
        rows.append(names | {key: course[key] for key in keys})
    parts = {
        "configuration": ("configuration in which the rotors start", ""), "outcome": ("outcome", ""),
        "start_speed": ("speed of the main rotor at the start", units.speed),
        "half_time": ("time after which the speed has halved", units.time), "end_time": ("time at the end", units.time),
        "peak_amplitude": ("largest amplitude of the axis", orbit),
        "peak_speed": ("mean speed of the rotor over the turn there", units.speed), "reached_from_rest": FROM_REST_WORDS,
    }  # fmt: skip
    quantities = table("configurations", rows, "the run from each stable synchronous configuration", parts)
    if len(runs) == 1:
        return quantities
    longest = max((run.rows["time"] for run in runs), key=lambda time: float(time[-1]))
    courses = {
        name: np.array([np.interp(longest, run.rows["time"], run.rows[name], right=np.nan) for run in runs])
        for name in ("speed", "amplitude")
    }
    labels = np.array([run.plan.label for run in runs], str)
    return [
        *quantities,
        Quantity("configuration_name", labels, "configuration in which the rotors start", "", "configuration", coordinate=True),
        Quantity("run_time", longest, "time", units.time, "run_time", coordinate=True),
        Quantity("run_speed", courses["speed"], "speed of the rotor in each run", units.speed, "configuration run_time"),
        Quantity("run_amplitude", courses["amplitude"], "amplitude of the axis in each run", orbit, "configuration run_time"),
    ]


def _row_quantities(machine: Machine, rows: Mapping[str, np.ndarray]) -> list[Quantity]:
    """Quantities recorded over the time."""
    units = machine.units
    words = {
        "time": ("time", units.time),
        "angle": ("angle of the rotor", "rad"),
        "speed": ("speed of the rotor", units.speed),
        "min_speed": ("least speed since the last sample", units.speed),
        "max_speed": ("largest speed since the last sample", units.speed),
        "amplitude": ("amplitude of the axis", machine.orbit_unit),
        "energy_residual": ("energy residual, relative", ""),
        "dissipated_work": ("energy dissipated", units.energy),
    }
    quantities = [Quantity(name, rows[name], *words_and_unit, "time") for name, words_and_unit in words.items()]
    if further := [r.name for r in machine.rotors[1:]]:
        angles = [rows["angle"], *(rows[further_angle(name)] for name in further)]
        quantities += [
            Quantity("rotor", [machine.rotor.name, *further], "rotor", "", "rotor"),
            Quantity("rotor_angle", angles, "angle of each rotor", "rad", "rotor time"),
        ]
    return quantities


def _course_quantities(plan: SingleCoastDown, record: Record, rows: Mapping[str, np.ndarray]) -> list[Quantity]:
    """Times of the coast-down, number of turns, and largest vibration."""
    units, largest = plan.machine.units, int(rows["amplitude"].argmax())
    turns, amplitude = float(rows["angle"][-1] - rows["angle"][0]) / (2 * math.pi), float(rows["amplitude"][largest])
    observation, residual = record.observation, float(rows["energy_residual"].max())
    peak_speed = speed_at_largest(plan.machine, observation) if amplitude and observation is not None else None
    back, length = next(iter(record.reversals), None), plan.machine.orbit_unit
    return [
        Quantity("start_speed", record.start_speed, "speed of the rotor at the start", units.speed, headline=True),
        Quantity("half_time", record.half_time, "time after which the speed has halved", units.time, headline=True),
        Quantity("reversal_time", back, "time at which the rotor first turns back", units.time, headline=True),
        Quantity("end_time", float(rows["time"][-1]), "time at the end", units.time, headline=True),
        Quantity("turns", turns, "number of turns"),
        Quantity("carrier_start", str(plan.carrier), "start of the carrier"),
        Quantity("peak_amplitude", amplitude, "largest amplitude of the axis", length, headline=True),
        Quantity("peak_speed", peak_speed, "mean speed of the rotor over the turn there", units.speed),
        Quantity("energy_residual", residual, "largest relative error of the energy balance"),
    ]


def _warnings(coast_down: Plan, failure: str | None) -> list[str]:
    warnings, plan = [failure] if failure else [], coast_down.runs[0]
    if coast_down.held_reason:
        warnings.append(f"the rotors start at the phases of the start: {coast_down.held_reason}")
    if plan.carrier is CarrierStart.REST:
        steady = "vibration = 'steady' starts with the vibration of that speed"
        advice = f"the machine {plan.rest_reason}" if plan.rest_reason else steady
        warnings.append(
            "the carrier starts at rest, although the rotor turns: its initial vibration, possibly the largest, is a transient "
            f"of this start; {advice}"
        )
    if plan.bodies.held_reason:
        warnings.append(
            f"balancing bodies start as held, because their steady phases are not computed: {plan.bodies.held_reason}"
        )
    return warnings


def _rotor_assumptions(plan: Plan) -> list[str]:
    """Statement on where several rotors start: the vibration depends on their relative phases."""
    if label := plan.runs[0].label:
        further_starts = [f"{one.label}, from {abs(one.start_speed):.5g}{_unit(one.machine)}" for one in plan.runs[1:]]
        more = f"; the other runs start in {' and in '.join(further_starts)}" if further_starts else ""
        return [f"rotors start in the stable synchronous configuration {label} (averaged equations){more}"]
    one = plan.runs[0]
    rotors, angles = one.machine.rotors, angles_in(one.machine, one.initial)
    return [f"rotors start at {format_phases({r.name: angles[r.name] for r in rotors})}"] if len(rotors) > 1 else []


def _unit(machine: Machine) -> str:
    return f" {machine.units.speed}" if machine.units.speed else ""


def _carrier_assumptions(plan: SingleCoastDown) -> list[str]:
    """Statement on the start of the carrier; none if it cannot move, or if the start gives it."""
    if plan.carrier in (CarrierStart.FIXED, CarrierStart.GIVEN):
        return []
    at_first = "in the steady vibration of its speed" if plan.carrier is CarrierStart.STEADY else "at rest"
    return [f"the carrier starts {at_first}"]


def _ending(plan: SingleCoastDown, record: Record) -> tuple[str, list[Quantity]]:
    """The end of the run, in words and numbers; speeds over its last tenth, or from the first reversal on if that is shorter.

    ``failed``, ``stopped`` and ``oscillating`` are those of a run-up. Otherwise there is no outcome: the rotor still turns, or
    its swing may yet die out.
    """
    time, start, unit = record.rows["time"], abs(record.start_speed), plan.machine.units.speed
    since = time[-1] - _LAST * (time[-1] - time[0])
    if record.reversals:
        since = min(max(since, record.reversals[0]), float(time[-2]))
    late = {name: column[time >= since] for name, column in record.rows.items()}
    low, high = float(late["min_speed"].min()), float(late["max_speed"].max())
    duration = float(late["time"][-1] - late["time"][0])
    mean = float((late["angle"][-1] - late["angle"][0]) / duration) if duration else float(late["speed"][-1])
    speed = mean if record.reversals or not record.turns.size else record.turns[1, -1]
    turning = "the rotor has turned back" if record.reversals else "the rotor still turns"
    sentence = f"{turning}, at {100 * abs(speed / start):.3g} % of its speed at the start"
    verdict = Outcome.FAILED if record.end.failure else plan.verdict(record).outcome
    outcome = verdict if verdict in (Outcome.FAILED, *_AT_REST) else None
    ending = outcome.sentence if outcome else sentence
    return ending, [
        Quantity("outcome", outcome and str(outcome), "outcome"),
        Quantity("sentence", ending, "sentence on the end of the run"),
        Quantity("final_speed", mean, "mean speed of the rotor at the end", unit),
        Quantity("min_speed", low, "least speed of the rotor at the end", unit),
        Quantity("max_speed", high, "greatest speed of the rotor at the end", unit),
    ]


_VISIBLE_RANGE = 1e-2  # of the range of the mean speed: a narrower range about it is not drawn
_STARTS = {
    "steady": "it starts in the steady vibration of its speed",
    "rest": "the carrier starts at rest",
    "given": "the carrier starts as given by study.start",
    "fixed": "the carrier moves as prescribed",
}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a coast-down."""
    s, lines = result.wucht.summary, ReportLines(result)
    lines.add("speed", "{start_speed} at the start, {final_speed} on average at the end")
    for row in s.get("configurations", [])[1:]:
        half = "" if row["half_time"] is None else "; halved after {half_time:.5g}"
        text = f"{{peak_amplitude}} at most, from {{start_speed}}{half}"
        lines.add("other start", f"{row['configuration']}: {text}", row, "configurations")
    lines.add("halved", "not within this time" if s["half_time"] is None else "after {half_time:.5g}")
    lines.add("turns back", "at {reversal_time:.6g}")
    lines.add("turned", "{turns:.5g} times in {end_time:.5g}")
    there = "" if s["peak_speed"] is None else ", at {peak_speed}"
    lines.add("amplitude", f"{{peak_amplitude}} at most{there}; {_STARTS[s['carrier_start']]}")
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}" if s["outcome"] else s["sentence"])


def figure(result: xr.Dataset) -> Figure:
    """Draw the speed of a coast-down, and the amplitude if the carrier moves, from its Dataset alone."""
    moves = bool(np.nanmax(result.amplitude.values, initial=0.0) > 0)
    fig, axes = new_figure(1 + moves, result.attrs["title"], result.attrs["sentence"], 2.0)
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
