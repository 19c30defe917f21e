"""Machine whose stiffness falls while it runs: by its schedules, or with the damage that has been counted so far.

Between two checks of the damage the stiffness is constant. At each check it may jump at the current state: the energy that the
spring then loses leaves the machine, and is booked as work of the stiffness, as that of a schedule.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from wucht.dynamics.run_ups.machine_signals import SignalObservation
from wucht.dynamics.run_ups.observed_integration import Leg, Watched
from wucht.dynamics.run_ups.run_up import verdict_at_end
from wucht.dynamics.verdicts.observation import motion_of
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import Work
from wucht.fatigue.damage import AccumulatedDamage
from wucht.machines.machine import LOST, SUPPLIED, Machine
from wucht.machines.schedules import SCHEDULED
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance

_LOOKS_A_UNIT = 50


@dataclass(frozen=True)
class FallingStiffness:
    """Law of the stiffness over the damage D. value: of the whole specimen. remaining: share that is left in the end.
    at_once: the stiffness falls when D reaches 1; else in proportion to D."""

    parameter: str
    value: float
    remaining: float
    at_once: bool

    def at(self, damage: float) -> float:
        """Return the stiffness at a damage."""
        lost = float(damage >= 1.0) if self.at_once else min(damage, 1.0)
        return self.value * (1 - lost * (1 - self.remaining))


@dataclass(frozen=True, eq=False)
class Course:
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
    def of(cls, parts: list[Course]) -> Course:
        """Join several that follow each other."""
        names = cls.__dataclass_fields__
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True)
class Standing:
    """State of a run. last: its motion. damage: None where nothing is counted. balance: of the energy. jump_work: of the
    stiffness at its jumps. broken: time of the check at which the damage had reached 1. onset: the motion when the stiffness
    began to fall."""

    last: Leg[SignalObservation]
    balance: EnergyBalance
    damage: AccumulatedDamage | None = None
    jumped: float = 0.0
    broken: float | None = None
    begun: Leg[SignalObservation] | None = None


@dataclass(frozen=True, eq=False)
class Stretch:
    """Unit of work: the state at its end, and its time series."""

    standing: Standing
    course: Course


@dataclass(frozen=True, eq=False)
class FailingRun:
    """Run so far. verdict: on its end; verdict_before: on the motion when the stiffness began to fall, None if it has not."""

    course: Course
    standing: Standing
    verdict: Verdict
    before: Verdict | None

    @property
    def failure(self) -> str | None:
        """Reason of an early end of the run."""
        return self.standing.last.stored.failure


@dataclass(frozen=True)
class FailingMachine:
    """Machine that is ready to run.

    initial: the state (n,) from which it starts. step: between samples; count: their number; samples_per_check: between two
    checks of the damage. damage, falling: of the load, and the law of the stiffness; None: a schedule makes it fall. schedule:
    then the share of the stiffness (N,) at times (N,). begin: end of the motion before the failure; None: when the stiffness
    falls.
    """

    machine: Machine
    watched: Watched[SignalObservation]
    initial: np.ndarray
    step: float
    count: int
    per_look: int
    damage: AccumulatedDamage | None = None
    falling: FallingStiffness | None = None
    scheduled: Callable[[np.ndarray], np.ndarray] | None = field(default=None, compare=False)
    begin: float | None = None

    @property
    def compiled(self) -> CompiledSystem:
        """Compiled equations."""
        return self.watched.compiled

    @cached_property
    def _row(self) -> int:
        assert self.falling is not None
        return self.machine.system.parameter_names.index(self.falling.parameter)

    def run(self, work: Work) -> Iterator[FailingRun]:
        """Run; yield the result after each unit of work."""
        first = self.watched.begin(self.initial, self.machine.system.values(self.machine.values))
        standing = Standing(first, EnergyBalance(), self.damage)
        balance, course = self._seen(standing, first.stored)
        standing, courses = replace(standing, balance=balance), [course]
        looks = -(-self.count // self.per_look)
        yield self._found(courses, standing)
        for number, look in enumerate(range(0, looks, _LOOKS_A_UNIT), 1):
            if standing.last.stored.ended:
                return
            stretch = work.unit(f"leg {number}", partial(self._stretch, standing, look, min(look + _LOOKS_A_UNIT, looks), work))
            standing = stretch.standing
            courses.append(stretch.course)
            yield self._found(courses, standing)

    def _stretch(self, standing: Standing, first: int, last: int, work: Work) -> Stretch:
        courses = list[Course]()
        for look in range(first, last):
            begin, end = look * self.per_look, min((look + 1) * self.per_look, self.count)
            grid = self.step * np.arange(begin, end + 1)
            standing, course = self._look(standing, grid)
            courses.append(course)
            work.report(end / self.count)
            if standing.last.stored.ended:
                break
        return Stretch(standing, Course.of(courses))

    def _look(self, standing: Standing, grid: np.ndarray) -> tuple[Standing, Course]:
        """Run over a grid at constant stiffness, then update the stiffness."""
        begun = standing.begun
        if begun is None and self.begin is not None and grid[-1] > self.begin:
            begun = standing.last
        seen = standing.last.seen
        fresh = replace(standing.last, seen=replace(seen, points=seen.points.forgotten()))
        leg = self.watched.leg(fresh, grid)
        looked = self.watched.observation(leg)
        leg = replace(leg, seen=looked, waiting=(leg.waiting[-1].tail(1),))
        standing = replace(standing, last=leg, begun=begun)
        if standing.damage is not None:
            standing = replace(standing, damage=standing.damage.after(looked.points.values))
        balance, course = self._seen(standing, leg.stored)
        # The first sample is the last one of the motion before.
        course = Course(*(getattr(course, name)[1:] for name in Course.__dataclass_fields__))
        return self._fallen(replace(standing, balance=balance)), course

    def _fallen(self, standing: Standing) -> Standing:
        """Update the stiffness to the damage, and book the energy of its change."""
        if self.falling is None or standing.damage is None or standing.last.stored.ended:
            return standing
        stored, total = standing.last.stored, standing.damage.total
        left, broken = self.falling.at(total), standing.broken
        broken = stored.end_time if broken is None and total >= 1.0 else broken
        if left == stored.parameters[self._row]:
            return replace(standing, broken=broken)
        begun = standing.begun or (standing.last if self.begin is None else None)
        changed = stored.parameters.copy()
        changed[self._row] = left
        last = stored.tail(1)
        before, after = (float(self._energy(replace(last, parameters=p))[0]) for p in (stored.parameters, changed))
        moved, waiting = replace(stored, parameters=changed), standing.last.waiting[-1]
        leg = replace(standing.last, stored=moved, waiting=(replace(waiting, parameters=changed),))
        return replace(standing, last=leg, jumped=standing.jumped + after - before, broken=broken, begun=begun)

    def _energy(self, motion: Trajectory) -> np.ndarray:
        return np.asarray(self.compiled.outputs(motion.time, motion.states, motion.parameters)["stored_energy"])

    def _seen(self, standing: Standing, motion: Trajectory) -> tuple[EnergyBalance, Course]:
        """Return balance and time series at the samples of a motion, the first of which is the last of the motion before."""
        time, works = motion.time, motion.quadratures
        carried = works.get(SCHEDULED, np.zeros(len(time))) + standing.jumped
        balance, residual = standing.balance.after(self._energy(motion), np.array([works[SUPPLIED], carried]), works[LOST])
        highest, lowest = np.full(len(time), -np.inf), np.full(len(time), np.inf)
        points = standing.last.seen.points
        at = np.clip(np.searchsorted(time, points.time), 0, len(time) - 1)
        np.maximum.at(highest, at, points.values)
        np.minimum.at(lowest, at, points.values)
        highest, lowest = (np.where(np.isfinite(x), x, np.nan) for x in (highest, lowest))
        angle = motion_of(self.machine, motion, self.machine.rotor)[0]
        total = np.full(len(time), np.nan if standing.damage is None else standing.damage.total)
        return balance, Course(time, angle, self._stiffness(motion), total, highest, lowest, residual, carried)

    def _stiffness(self, motion: Trajectory) -> np.ndarray:
        """Return the stiffness as a share of that of the whole specimen."""
        if self.falling is not None:
            return np.full(len(motion.time), motion.parameters[self._row] / self.falling.value)
        assert self.scheduled is not None
        return self.scheduled(motion.time)

    def _found(self, courses: list[Course], standing: Standing) -> FailingRun:
        verdict = self._judged(standing.last, self._now(standing))
        if (begun := standing.begun) is None:
            return FailingRun(Course.of(courses), standing, verdict, None)
        # The machine as it was then, without its later schedules.
        then = self.machine.at(begun.stored.end_time).changed(schedules=())
        return FailingRun(Course.of(courses), standing, verdict, self._judged(begun, then))

    def _now(self, standing: Standing) -> Machine:
        """Return the machine with its final stiffness."""
        if self.falling is None:
            return self.machine
        return self.machine.with_unchecked({self.falling.parameter: float(standing.last.stored.parameters[self._row])})

    def _judged(self, leg: Leg[SignalObservation], machine: Machine) -> Verdict:
        return verdict_at_end(machine, self.watched.observation(leg).observation, leg.stored)
