"""Coast-downs: the machine without its drives, run by run, from the states in which they turn it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np

from wucht.analysis.foundation_forces import FoundationForces
from wucht.analysis.vibration import unbalances
from wucht.analysis.working_points import energy_scale
from wucht.dynamics.run_ups.coasting import (
    REVERSAL,
    CarrierStart,
    Record,
    driving_machine,
    phases_of_bodies,
    place_bodies,
    reduce_leg,
    state_at_start,
    vibrating_state,
    without_drives,
)
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.initial_state import machine_in_state, start_gives
from wucht.dynamics.run_ups.observed_loads import joint_maxima, largest_forces
from wucht.dynamics.run_ups.operating_points import SteadyState, steady_state
from wucht.dynamics.run_ups.operating_state import states_in_configurations
from wucht.dynamics.run_ups.run_up import RunUpCase, verdict_at_end
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

_WITHOUT_VIBRATION = 0.05  # share by which vibration may keep a rotor below the speed at which a run starts
SAMPLES_PER_TURN, _FEWEST_SAMPLES, _ROWS = 24, 64, 4000
_MOST_TURNS = 50_000
_SAMPLES_A_LEG = 20_480
_SLOW = 0.01  # of the speed at the start: without a time at which it ends the run ends below it
_STILL = 1e-4  # likewise, after the rotor has turned back
_ENOUGH_SWINGS = 20
_AT_REST = (Outcome.STOPPED, Outcome.OSCILLATING)


@dataclass(frozen=True)
class CoastDownCase:
    """Definition of a coast-down.

    machine: without its drives. initial: state (n,) at the start. carrier: its kind of start; rest_reason: why it starts at
    rest without being given so. bodies: kind of start of the balancing bodies. label: of the configuration in which several
    rotors start, empty without one. operation: the state in which the drives turn the machine at the start; None where the
    start gives the speed, or bodies are held. observer: of the motion, for its outcome.
    """

    machine: Machine
    initial: np.ndarray
    settings: RunSettings
    carrier: CarrierStart
    rest_reason: str
    bodies: BodyPhases
    label: str
    operation: SteadyState | None
    observer: MotionObserver

    @classmethod
    def of(
        cls, machine: Machine, state: np.ndarray, start: Mapping[str, Any], vibration: str | None, settings: RunSettings,
        bodies: BodyPhases, label: str = "", operation: SteadyState | None = None,
    ) -> CoastDownCase:  # fmt: skip
        """Return the run from a state (n,) with the carrier at rest. Raises ``InputError`` where its vibration is unbounded."""
        machine = machine_in_state(machine, state)
        initial, carrier, rest_reason = vibrating_state(machine, state, start, vibration)
        observer = RunUpCase.from_state(machine, initial, settings).observer
        return cls(machine, initial, settings, carrier, rest_reason, bodies, label, operation, observer)

    @property
    def phases(self) -> Mapping[str, float]:
        """The phases of the balancing bodies to their rotor at the start."""
        return phases_of_bodies(self.machine, self.initial)

    @property
    def start_speed(self) -> float:
        """The speed of the main rotor at the start."""
        return float(self.initial[self.machine.row(self.machine.rotor.coordinate.velocity)])

    @cached_property
    def foundation(self) -> FoundationForces | None:
        """The forces on the foundation as functions of the motion."""
        return FoundationForces.of(self.machine)

    @cached_property
    def turn(self) -> float:
        """The shortest period of the start: of a turn, or of a natural vibration."""
        return 2 * math.pi / max([abs(self.start_speed), *(f for f in natural_frequencies(self.machine).values() if f > 0)])

    @property
    def limit(self) -> float:
        """The latest end."""
        return self.settings.until or _MOST_TURNS * self.turn

    @property
    def step(self) -> float:
        """The time between samples: a whole number of steps until the end."""
        return self.limit / max(_FEWEST_SAMPLES, math.ceil(self.limit * SAMPLES_PER_TURN / self.turn))


@dataclass(frozen=True)
class CoastDownRun:
    """A coast-down so far. flow: the integrated equations."""

    case: CoastDownCase
    record: Record
    flow: CompiledSystem

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict on the motion: the criteria are those of a run-up."""
        assert self.record.observation is not None
        return verdict_at_end(self.case.machine, self.record.observation, self.record.end)

    @property
    def outcome(self) -> Outcome | None:
        """Its outcome: failed, at rest, or None while the rotor turns or its swing may yet die out."""
        outcome = Outcome.FAILED if self.record.end.failure else self.verdict.outcome
        return outcome if outcome in (Outcome.FAILED, *_AT_REST) else None

    @cached_property
    def rows(self) -> dict[str, np.ndarray]:
        """The rows (N,) of the record by name, without what the start and rounding add to them."""
        record, rows = self.record, dict(self.record.rows)
        if self.case.carrier is CarrierStart.STEADY:  # as large before the run as in its first turn
            first = rows["time"] <= 2 * math.pi / abs(self.case.start_speed)
            rows["amplitude"] = np.append(rows["amplitude"][first].max(), rows["amplitude"][1:])
        work, noise = rows["dissipated_work"], Noise.of(self.case.settings.tolerance).angle * record.balance.scale
        if np.abs(work).max(initial=0.0) <= noise:  # of a rotor that nothing brakes, whose speed drifts by rounding
            rows["dissipated_work"] = np.zeros_like(work)
        return rows

    @property
    def peak_amplitude(self) -> float:
        """The largest amplitude of the axis."""
        return float(self.rows["amplitude"].max())

    @property
    def peak_speed(self) -> float | None:
        """The mean speed of the rotor over the turn there; None without vibration."""
        observation = self.record.observation
        return speed_at_largest(self.case.machine, observation) if self.peak_amplitude and observation is not None else None

    @property
    def has_ended(self) -> bool:
        """True if the time is over, the run failed, or, without a time, the rotor has stopped, swung enough, or is slow."""
        record, settings = self.record, self.case.settings
        if record.end.has_ended or record.end.end_time >= self.case.limit * (1 - 1e-9):
            return True
        if settings.until is not None:
            return False
        rows, start_speed = record.rows, abs(record.start_speed)
        if record.reversals:
            is_enough = len(record.reversals) >= _ENOUGH_SWINGS or abs(rows["max_speed"][-1]) < _STILL * start_speed
            return is_enough and self.verdict.outcome in _AT_REST
        return bool(record.turns.size) and abs(rows["speed"][-1]) < _SLOW * start_speed


def coast_down_cases(
    machine: Machine, start: Mapping[str, Any], bodies: Literal["steady", "held"] | None,
    vibration: str | None, settings: RunSettings, watch: Callable[[], None] | None,
) -> tuple[tuple[CoastDownCase, ...], str]:  # fmt: skip
    """Return a run for each stable configuration of several rotors, else one; and why the rotors start at given phases.

    start, bodies, vibration: as in the table of the study. watch: called often. The reason is empty where the rotors are not
    there or as requested. Raises ``InputError`` if the start does not fit the machine, or if nothing would turn.
    """
    coasting = without_drives(machine)
    initial = state_at_start(machine, coasting, start)
    is_driven, reason = not start_gives(start, machine.rotor.name, "speed"), ""
    if bodies != "held" and len(machine.rotors) > 1:
        reason = "no synchronous configuration of the rotors is stable"
        try:
            states = states_in_configurations(driving_machine(machine), coasting, initial, start, watch=watch)
        except InputError as error:
            states, reason = [], error.explanation
        if states:
            cases = (
                CoastDownCase.of(
                    coasting, state, start, vibration, settings, BodyPhases({}), label,
                    steady_state(machine, c) if is_driven else None,
                )
                for c, label, state in states
            )  # fmt: skip
            return tuple(cases), ""
        if bodies == "steady":
            explanation = f"not possible here: {reason}; {HELD_HINT}"
            raise InputError("study.bodies", bodies, explanation, code="no-stable-phases")
    phases = BodyPhases.of(coasting, start, float(initial[coasting.row(coasting.rotor.coordinate.velocity)]), bodies)
    state = place_bodies(coasting, initial, phases.to_rotor)
    case = CoastDownCase.of(coasting, state, start, vibration, settings, phases)
    is_placed = case.phases and not phases.to_rotor
    if is_driven and len(machine.rotors) == 1 and not is_placed:
        share = _residual_share(coasting, case.phases) if phases.to_rotor else None
        case = replace(case, operation=SteadyState(abs(case.start_speed), share=share, reach=_WITHOUT_VIBRATION))
    return (case,), reason


def _residual_share(machine: Machine, phases: Mapping[str, float]) -> float | None:
    """The residual unbalance of a rotor with its bodies at phases, as a share of its own; None without one."""
    main, *moments = unbalances(machine)
    return float(abs(main + moments @ np.exp(1j * np.array(list(phases.values()))))) / abs(main) if main else None


def coast_down(case: CoastDownCase, work: Work) -> Iterator[CoastDownRun]:
    """Integrate a coast-down; yield the run after each leg."""
    machine, settings, speed = case.machine, case.settings, case.start_speed
    back = Event(REVERSAL, machine.rotor.coordinate.velocity, -1 if speed > 0 else 1)
    flow = compile_system(machine.system, settings.tolerance, (back, *release_events(machine)), settings.engine)
    start = integrate(flow, case.initial, machine.values, np.zeros(1)).reraise_interrupt()
    stride = case.turn if settings.until is None else case.limit / _ROWS
    record = Record(start_speed=speed, stride=stride, end=start, observation=case.observer.begin())
    run = CoastDownRun(case, record.update(_reduce_and_observe(case, flow, record, start)), flow)
    yield run
    while not run.has_ended:
        leg = work.unit(f"leg {run.record.legs + 1}", partial(_leg, run, work))
        run = replace(run, record=run.record.update(leg))
        yield run


def _leg(run: CoastDownRun, work: Work) -> Record:
    """Integrate the leg that begins at the end of the preceding one."""
    case, last = run.case, run.record.end
    count = max(1, min(_SAMPLES_A_LEG, round((case.limit - last.end_time) / case.step)))
    grid = last.end_time + case.step * np.arange(count + 1)

    def report(time: float) -> None:
        """Report a share of the time where that is given; else it is not known how long the rotor will turn."""
        work.report(0.0 if case.settings.until is None else time / case.limit)

    t = integrate(run.flow, last.end_state, last.final_parameter_values, grid, report, energy_scale(case.machine))
    return _reduce_and_observe(case, run.flow, run.record, t.reraise_interrupt())


def _reduce_and_observe(case: CoastDownCase, flow: CompiledSystem, before: Record, t: Trajectory) -> Record:
    """Reduce a leg to its record, and observe it."""
    assert before.observation is not None
    leg = reduce_leg(case.machine, axis_at_rest(case.machine), flow, before, t)
    foundation_forces = joint_maxima(before.foundation_forces, largest_forces(case.foundation, t))
    return replace(leg, observation=case.observer.update(before.observation, t), foundation_forces=foundation_forces)
