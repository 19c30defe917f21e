"""The machine in operation: its state after a run-up, or at a stable working point where it does not start by itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from wucht.analysis.starting import starts_from_rest
from wucht.analysis.working_points import creep_speed, is_held_at_rest
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.horizon import Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.operating_state import machine_after_schedules, state_at_working_point
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.run_ups.run_up_models import FullModel
from wucht.dynamics.verdicts.outcomes import PHASE_TOLERANCE, SPEED_TOLERANCE, Outcome
from wucht.dynamics.work import Work
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrap_to_pi
from wucht.numerics.flow.events import Event

_BEFORE_ROWS = 60  # of the course before
REST = "rest"
NOT_TURNING = (Outcome.NOT_STARTED, Outcome.STOPPED, Outcome.OSCILLATING)
NO_OPERATION = (*NOT_TURNING, Outcome.RUNAWAY, Outcome.UNIDENTIFIED, Outcome.FAILED)


def case_from_state(machine: Machine, state: np.ndarray, settings: RunSettings) -> RunUpCase:
    """Return the run of the full equations from a state (n,). It ends when dry friction has brought all rotors to rest."""
    horizon = Horizon.of(machine, settings, state)
    if is_held_at_rest(machine) and settings.until is None:  # the creep is a very slow balance of torques: not waited for
        horizon = replace(horizon, first=horizon.expected_end)
    horizon = replace(horizon, events=(*horizon.events, *rest_events(machine)))
    return RunUpCase(machine, horizon, (FullModel(machine, state),), settings)


def rest_events(machine: Machine) -> tuple[Event, ...]:
    """Return the event at which dry friction has brought all rotors to rest; none where it does not hold them."""
    if not is_held_at_rest(machine):
        return ()
    squares = [(r.coordinate.velocity / creep_speed(machine)) ** 2 for r in machine.rotors]
    return (Event(REST, sp.Add(*squares) - 1, -1, terminal=True),)


@dataclass(frozen=True)
class EndState:
    """The verdict on the end of a run, in numbers.

    speeds: of all rotors, in magnitude, the main one first. phases: of other rotors to the main one where they turn at one
    mean speed. amplitude: mean of the axis, None with a modulation. end: time. advice: how to get a verdict.
    """

    outcome: str
    speeds: tuple[float, ...]
    phases: tuple[float, ...]
    amplitude: float | None
    end: float
    advice: str | None = None

    @classmethod
    def at_rest(cls, machine: Machine, end: float, outcome: Outcome = Outcome.STOPPED) -> EndState:
        """The end of a run in which nothing turns, as dry friction holds it."""
        return cls(str(outcome), (0.0,) * len(machine.rotors), (), 0.0, end)

    @classmethod
    def of(cls, motion: Motion) -> EndState:
        """The end of a run."""
        machine, verdict, end = motion.case.machine, motion.verdict, motion.trajectory.end_time
        if motion.trajectory.stopped_by == REST:
            return cls.at_rest(machine, end)
        outcome, locking, phases = verdict.outcome, verdict.locking, dict[str, float]()
        speeds: tuple[float, ...] = (verdict.speed,)
        if locking is not None:
            speeds = tuple(abs(locking.final_speeds[r.name]) for r in machine.rotors)
            phases = dict(locking.phases) if verdict.outcome is Outcome.SYNCHRONISED else {}
        amplitudes = verdict.amplitudes
        return cls(
            str(outcome), speeds, tuple(phases.values()), None if amplitudes is None else amplitudes[0], end,
            verdict.advice,
        )  # fmt: skip

    @property
    def speed(self) -> float:
        """The mean speed of the main rotor, in magnitude."""
        return self.speeds[0]

    def equals(self, operation: EndState) -> bool:
        """True if this is the operating state: the same outcome, speeds within 0.5 %, rotors in the same configuration."""
        speeds, phases = zip(self.speeds, operation.speeds, strict=False), zip(self.phases, operation.phases, strict=False)
        return (
            self.outcome == operation.outcome
            and all(abs(w - before) <= SPEED_TOLERANCE * before for w, before in speeds)
            and all(abs(float(wrap_to_pi(a - b))) <= PHASE_TOLERANCE for a, b in phases)
        )


@dataclass(frozen=True)
class SettledOperation:
    """The machine in operation: a unit of work.

    state: (n,) in which it is when a dip begins. end: the verdict on it. course: shortly before, at negative times.
    locks: values of the locks of bodies, by name. working_point: speed of the working point at which it was placed, since
    it does not start by itself; None after a run-up.
    """

    state: np.ndarray
    end: EndState
    course: MotionCourse
    locks: Mapping[str, float]
    working_point: float | None = None

    @classmethod
    def at_rest(cls, machine: Machine, state: np.ndarray) -> SettledOperation:
        """A machine that does not turn."""
        course = MotionCourse(np.zeros(1), np.zeros((len(machine.rotors), 1)), np.zeros(1))
        is_held = any(start.is_held for start in starts_from_rest(machine).values())
        outcome = Outcome.NOT_STARTED if is_held else Outcome.STOPPED
        return cls(state, EndState.at_rest(machine, 0.0, outcome), course, {})

    @classmethod
    def of(cls, motion: Motion, turns: float, working_point: float | None = None) -> SettledOperation:
        """The state in which a motion ends. turns: of the main rotor that the course shows."""
        machine, t = motion.case.machine, motion.trajectory
        end = EndState.of(motion)
        begin = t.end_time - turns * 2 * np.pi / max(end.speed, 1e-9)
        last = t.tail(max(2, int((t.time >= begin).sum())))
        course = MotionCourse.from_samples(machine, motion.compiled_system, last).shift(-t.end_time).thin(_BEFORE_ROWS)
        names = motion.compiled_system.system.parameter_names
        values = dict(zip(names, t.final_parameter_values.tolist(), strict=True))
        locks = {n: x for n, x in values.items() if n.endswith(".locked")}
        return cls(t.end_state[: len(machine.state_names)], end, course, locks, working_point)


def last_motion(case: RunUpCase, work: Work) -> Motion:
    """Return the motion of a case at its end."""
    *_, (motion,) = run_up(case, work)
    return motion


def operation_of(
    machine: Machine, start: Mapping[str, Any], settings: RunSettings, turns: float, work: Work
) -> SettledOperation:
    """Return the machine in operation: settled after a run-up from a start, with the full equations.

    A machine that does not start, as its motor cannot lift its load from standstill, is placed at its fastest stable working
    point, if it has one, and settles there; unless the start gives a speed. Raises ``InputError`` where the start does not fit.
    """
    has_speed = any(isinstance(entry, Mapping) and "speed" in entry for entry in start.values())
    steady, operation = machine_after_schedules(machine), None
    if has_speed or not is_held_at_rest(steady):
        operation = SettledOperation.of(last_motion(RunUpCase.of(machine, start, settings), work.part("", 0.0, 0.5)), turns)
        if has_speed or operation.end.outcome not in NOT_TURNING:
            return operation
    place = state_at_working_point(steady, start, lambda: work.report(0.5, "working points"))
    if place is None:
        return operation or SettledOperation.at_rest(steady, initial_state(steady, with_default_start(steady, start)))
    state, speed = place
    return SettledOperation.of(
        last_motion(case_from_state(steady, state, settings), work.part("working point/", 0.5, 1.0)), turns, speed
    )
