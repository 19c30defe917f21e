"""Machine whose stiffness falls while it runs: by its schedules, or with the damage that has been counted so far.

Between two checks of the damage the stiffness is constant. At each check it may jump at the current state: the energy that the
spring then loses leaves the machine, and is booked as work of the stiffness, as that of a schedule.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from wucht.dynamics.run_ups.observed_integration import Leg, ObservedIntegration
from wucht.dynamics.run_ups.observed_loads import LoadObservation
from wucht.dynamics.run_ups.run_up import verdict_at_end
from wucht.dynamics.verdicts.observation import motion_of
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import Work
from wucht.fatigue.damage import AccumulatedDamage
from wucht.machines.machine import DISSIPATED_WORK, SUPPLIED_WORK, Machine
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance

_CHECKS_PER_UNIT = 50


@dataclass(frozen=True)
class FallingStiffness:
    """Law of the stiffness over the damage D. value: of the whole specimen. remaining: share that is left in the end.
    at_once: the stiffness falls when D reaches 1; else in proportion to D."""

    parameter: str
    value: float
    remaining: float
    at_once: bool

    def stiffness_at(self, damage: float) -> float:
        """Return the stiffness at a damage."""
        loss_share = float(damage >= 1.0) if self.at_once else min(damage, 1.0)
        return self.value * (1 - loss_share * (1 - self.remaining))


@dataclass(frozen=True, eq=False)
class FailureCourse:
    """Time series at the samples (N,) of a run, the first at its begin: angle of the main rotor, stiffness as a share of
    the first, damage, largest and smallest value of the load since the sample before (nan without a reversal), the
    residual of the energy balance, and the work of the changing stiffness."""

    time: np.ndarray
    angle: np.ndarray
    stiffness: np.ndarray
    damage: np.ndarray
    highest: np.ndarray
    lowest: np.ndarray
    residual: np.ndarray
    work: np.ndarray

    @classmethod
    def join(cls, parts: list[FailureCourse]) -> FailureCourse:
        """Join several that follow each other."""
        names = cls.__dataclass_fields__
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True)
class RunState:
    """State of a run. last: its motion. damage: None where nothing is counted. balance: of the energy. jump_work: of the
    stiffness at its jumps. broken: time of the check at which the damage had reached 1. onset: the motion when the stiffness
    began to fall."""

    last: Leg[LoadObservation]
    balance: EnergyBalance
    damage: AccumulatedDamage | None = None
    jump_work: float = 0.0
    broken: float | None = None
    onset: Leg[LoadObservation] | None = None


@dataclass(frozen=True, eq=False)
class FailingRun:
    """Run so far. verdict: on its end; verdict_before: on the motion when the stiffness began to fall, None if it has not."""

    course: FailureCourse
    state: RunState
    verdict: Verdict
    verdict_before: Verdict | None

    @property
    def failure(self) -> str | None:
        """Reason of an early end of the run."""
        return self.state.last.trajectory.failure


@dataclass(frozen=True)
class FailingMachine:
    """Machine that is ready to run.

    initial: the state (n,) from which it starts. step: between samples; count: their number; samples_per_check: between two
    checks of the damage. damage, falling: of the load, and the law of the stiffness; None: a schedule makes it fall. schedule:
    then the share of the stiffness (N,) at times (N,). begin: end of the motion before the failure; None: when the stiffness
    falls.
    """

    machine: Machine
    integration: ObservedIntegration[LoadObservation]
    initial: np.ndarray
    step: float
    count: int
    samples_per_check: int
    damage: AccumulatedDamage | None = None
    falling: FallingStiffness | None = None
    schedule: Callable[[np.ndarray], np.ndarray] | None = field(default=None, compare=False)
    begin: float | None = None

    @property
    def compiled_system(self) -> CompiledSystem:
        """Compiled equations."""
        return self.integration.compiled_system

    @cached_property
    def _row(self) -> int:
        assert self.falling is not None
        return self.machine.system.parameter_names.index(self.falling.parameter)

    def run(self, work: Work) -> Iterator[FailingRun]:
        """Run; yield the result after each unit of work."""
        first = self.integration.begin(self.initial, self.machine.system.values(self.machine.values))
        state = RunState(first, EnergyBalance(), self.damage)
        balance, course = self._observe(state, first.trajectory)
        state, courses = replace(state, balance=balance), [course]
        checks = -(-self.count // self.samples_per_check)
        yield self._assemble_run(courses, state)
        for number, check in enumerate(range(0, checks, _CHECKS_PER_UNIT), 1):
            if state.last.trajectory.has_ended:
                return
            state, course = work.unit(
                f"leg {number}", partial(self._stretch, state, check, min(check + _CHECKS_PER_UNIT, checks), work)
            )
            courses.append(course)
            yield self._assemble_run(courses, state)

    def _stretch(self, state: RunState, first: int, last: int, work: Work) -> tuple[RunState, FailureCourse]:
        """Return the state after some checks, and the time series until then: a unit of work."""
        courses = list[FailureCourse]()
        for check in range(first, last):
            begin, end = check * self.samples_per_check, min((check + 1) * self.samples_per_check, self.count)
            grid = self.step * np.arange(begin, end + 1)
            state, course = self._advance(state, grid)
            courses.append(course)
            work.report(end / self.count)
            if state.last.trajectory.has_ended:
                break
        return state, FailureCourse.join(courses)

    def _advance(self, state: RunState, grid: np.ndarray) -> tuple[RunState, FailureCourse]:
        """Run over a grid at constant stiffness, then update the stiffness."""
        onset = state.onset
        if onset is None and self.begin is not None and grid[-1] > self.begin:
            onset = state.last
        observation = state.last.observation
        fresh = replace(state.last, observation=replace(observation, points=observation.points.without_points()))
        leg = self.integration.leg(fresh, grid)
        new_observation = self.integration.observation(leg)
        leg = replace(leg, observation=new_observation, pending=(leg.pending[-1].tail(1),))
        state = replace(state, last=leg, onset=onset)
        if state.damage is not None:
            state = replace(state, damage=state.damage.update(new_observation.points.values))
        balance, course = self._observe(state, leg.trajectory)
        # The first sample is the last one of the motion before.
        course = FailureCourse(*(getattr(course, name)[1:] for name in FailureCourse.__dataclass_fields__))
        return self._update_stiffness(replace(state, balance=balance)), course

    def _update_stiffness(self, state: RunState) -> RunState:
        """Update the stiffness to the damage, and book the energy of its change."""
        if self.falling is None or state.damage is None or state.last.trajectory.has_ended:
            return state
        trajectory, total = state.last.trajectory, state.damage.total
        stiffness, broken = self.falling.stiffness_at(total), state.broken
        broken = trajectory.end_time if broken is None and total >= 1.0 else broken
        if stiffness == trajectory.final_parameter_values[self._row]:
            return replace(state, broken=broken)
        onset = state.onset or (state.last if self.begin is None else None)
        parameters = trajectory.final_parameter_values.copy()
        parameters[self._row] = stiffness
        last = trajectory.tail(1)
        before, after = (
            float(self._energy(replace(last, final_parameter_values=p))[0])
            for p in (trajectory.final_parameter_values, parameters)
        )
        restart, waiting = replace(trajectory, final_parameter_values=parameters), state.last.pending[-1]
        leg = replace(state.last, trajectory=restart, pending=(replace(waiting, final_parameter_values=parameters),))
        return replace(state, last=leg, jump_work=state.jump_work + after - before, broken=broken, onset=onset)

    def _energy(self, motion: Trajectory) -> np.ndarray:
        return np.asarray(
            self.compiled_system.outputs(motion.time, motion.states, motion.final_parameter_values)["stored_energy"]
        )

    def _observe(self, state: RunState, motion: Trajectory) -> tuple[EnergyBalance, FailureCourse]:
        """Return balance and time series at the samples of a motion, the first of which is the last of the motion before."""
        time, works = motion.time, motion.quadratures
        stiffness_work = works.get(SCHEDULE_WORK, np.zeros(len(time))) + state.jump_work
        balance, residual = state.balance.update(
            self._energy(motion), np.array([works[SUPPLIED_WORK], stiffness_work]), works[DISSIPATED_WORK]
        )
        highest, lowest = np.full(len(time), -np.inf), np.full(len(time), np.inf)
        points = state.last.observation.points
        at = np.clip(np.searchsorted(time, points.time), 0, len(time) - 1)
        np.maximum.at(highest, at, points.values)
        np.minimum.at(lowest, at, points.values)
        highest, lowest = (np.where(np.isfinite(x), x, np.nan) for x in (highest, lowest))
        angle = motion_of(self.machine, motion, self.machine.rotor)[0]
        total = np.full(len(time), np.nan if state.damage is None else state.damage.total)
        return balance, FailureCourse(time, angle, self._stiffness(motion), total, highest, lowest, residual, stiffness_work)

    def _stiffness(self, motion: Trajectory) -> np.ndarray:
        """Return the stiffness as a share of that of the whole specimen."""
        if self.falling is not None:
            return np.full(len(motion.time), motion.final_parameter_values[self._row] / self.falling.value)
        assert self.schedule is not None
        return self.schedule(motion.time)

    def _assemble_run(self, courses: list[FailureCourse], state: RunState) -> FailingRun:
        machine, last, onset, before = self.machine, state.last, state.onset, None
        if self.falling is not None:  # the machine with its final stiffness
            stiffness = float(last.trajectory.final_parameter_values[self._row])
            machine = machine.with_unchecked_values({self.falling.parameter: stiffness})
        verdict = self._judge(last, machine)
        if onset is not None:  # the machine as it was then, without its later schedules
            before = self._judge(onset, self.machine.at(onset.trajectory.end_time).with_fields(schedules=()))
        return FailingRun(FailureCourse.join(courses), state, verdict, before)

    def _judge(self, leg: Leg[LoadObservation], machine: Machine) -> Verdict:
        return verdict_at_end(machine, self.integration.observation(leg).observation, leg.trajectory)
