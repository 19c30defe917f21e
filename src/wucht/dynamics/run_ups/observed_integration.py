"""Integration of a machine with an observer: sampled as densely as the motion needs, however little of it is stored."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from wucht.dynamics.verdicts.observation import fastest_speed
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory

_PER_TURN, _FEWEST_SHARE = 24, 0.5  # observed samples, and the share of them that is enough
_MOST_AT_ONCE = 32_768  # of these
_FEWEST_AT_ONCE = 16_384  # before they are observed: an update costs as much as some thousand samples
_SLOWER = 0.25  # of a turn a span: a body that swings or creeps is observed as often as one that turns so slowly
_FASTER = 20.0  # times the speed: vibrations faster than that are not resolved, turns average over them
_ROUNDING = 1e-9  # of a step
ObservationT = TypeVar("ObservationT")


class MachineObserver(Protocol[ObservationT]):
    """An observer of a machine, whose observation of the motion so far is a value that it returns anew.

    span: of time, in which the fastest motion is sampled several times.
    """

    @property
    def machine(self) -> Machine:
        """The observed machine."""
        ...

    @property
    def span(self) -> float:
        """The sampled span of time: see the class."""
        ...

    def begin(self) -> ObservationT:
        """Return the empty observation."""
        ...

    def update(self, previous: ObservationT, motion: Trajectory) -> ObservationT:
        """Return the observation after a further part of the motion, which may begin with the last sample of the one before."""
        ...


@dataclass(frozen=True)
class Leg(Generic[ObservationT]):
    """A part of a motion: its stored samples, the observation until shortly before its end, the machine's motion since."""

    trajectory: Trajectory
    observation: ObservationT
    pending: tuple[Trajectory, ...]


@dataclass(frozen=True)
class ObservedIntegration(Generic[ObservationT]):
    """Integration of a machine with an observer.

    observer: of the machine. compiled_system: its equations, or others whose trajectory ``machine_motion`` turns into the
    machine's. vibration: the highest frequency of it. energy: the size of the works. per_turn: observed samples.
    """

    observer: MachineObserver[ObservationT]
    compiled_system: CompiledSystem
    machine_motion: Callable[[Trajectory], Trajectory]
    vibration: float
    energy: float
    per_turn: int = _PER_TURN

    @property
    def machine(self) -> Machine:
        """The observed machine."""
        return self.observer.machine

    def begin(self, initial: np.ndarray, values: tuple[float, ...]) -> Leg[ObservationT]:
        """Return the leg that has the first sample alone."""
        start = integrate(self.compiled_system, initial, values, np.zeros(1)).reraise_interrupt()
        return Leg(start, self.observer.begin(), (self.machine_motion(start),))

    def observation(self, leg: Leg[ObservationT]) -> ObservationT:
        """Return the observation of a motion until the end of a leg."""
        return self._update(leg.observation, leg.pending)

    def rate(self, leg: Leg[ObservationT]) -> float:
        """The highest frequency (rad per time) in a motion at the end of a leg: of a body that turns, or of vibrations."""
        return self._highest(fastest_speed(self.machine, self.machine_motion(leg.trajectory.tail(1))))

    def leg(
        self,
        before: Leg[ObservationT],
        grid: np.ndarray,
        report: Callable[[float], None] | None = None,
        closest: float | None = None,
    ) -> Leg[ObservationT]:
        """Integrate the leg over a grid, the samples that are stored, from the last sample of the leg before on.

        report: called with the time reached. closest: if the motion is much faster than the grid is made for, more
        samples are stored, at least this span of time apart; None: those of the grid. Raises ``KeyboardInterrupt`` where the
        user has stopped it.
        """
        last, observation, pending, parts = before.trajectory, before.observation, before.pending, list[Trajectory]()
        if last.has_ended:
            return before
        while len(grid) > 1 and not last.has_ended:
            motion, machine_motion, fine = self._piece(last, grid, report)
            every, interval_count = fine, (len(motion.time) - 1) // fine
            if closest is not None and len(motion.time) > 1:
                highest = self._highest(fastest_speed(self.machine, machine_motion))
                span, spacing = 2 * math.pi / (self.per_turn * highest), float(np.diff(motion.time).max())
                if fine * spacing * _FEWEST_SHARE > span:
                    every = min(fine, max(1, math.floor(max(span, closest) / spacing * (1 + _ROUNDING))))
            last = motion.subsample(every) if motion.has_ended else motion.subsample(every, with_last=True)
            parts.append(last)
            pending = (*pending, replace(machine_motion, quadratures={}))
            if sum(len(part.time) for part in pending) > _FEWEST_AT_ONCE:
                observation, pending = self._update(observation, pending), (pending[-1].tail(1),)
            grid = grid[interval_count:]
        return Leg(Trajectory.of(parts), observation, pending)

    def _highest(self, fastest: float) -> float:
        """The highest frequency of a motion in which the fastest body turns with this speed."""
        return max(fastest, self.vibration, _SLOWER * 2 * math.pi / self.observer.span)

    def _update(self, previous: ObservationT, motion: tuple[Trajectory, ...]) -> ObservationT:
        """Return the observation after some further parts of the machine's motion."""
        return self.observer.update(previous, Trajectory.of(motion))

    def _piece(
        self, before: Trajectory, grid: np.ndarray, report: Callable[[float], None] | None
    ) -> tuple[Trajectory, Trajectory, int]:
        """Integrate as much as is held at once; also return it as the machine's motion, and by how much its grid is refined.

        The refinement is what the speeds in it need.
        """
        step, fine = float(np.diff(grid).max()), 0
        fastest = fastest_speed(self.machine, self.machine_motion(before.tail(1)))
        while True:
            rate = max(fastest, min(self.vibration, _FASTER * fastest), _SLOWER * 2 * math.pi / self.observer.span)
            samples_per_step = self.per_turn * rate * step / (2 * math.pi)
            fine = min(max(fine + 1, math.ceil(samples_per_step * (1 - _ROUNDING))), _MOST_AT_ONCE)
            dense = _refine_grid(grid[: max(1, _MOST_AT_ONCE // fine) + 1], fine)
            motion = integrate(
                self.compiled_system, before.end_state, before.final_parameter_values, dense, report, self.energy
            ).reraise_interrupt()
            machine_motion = self.machine_motion(motion)
            fastest = fastest_speed(self.machine, machine_motion)
            enough = _FEWEST_SHARE * self.per_turn * fastest * step <= 2 * math.pi * fine
            if enough or motion.failure or fine == _MOST_AT_ONCE:
                return motion, machine_motion, fine


def _refine_grid(grid: np.ndarray, times: int) -> np.ndarray:
    """Return a grid (N,) with so many intervals in place of each."""
    if times == 1:
        return grid
    between = grid[:-1, None] + np.diff(grid)[:, None] * np.arange(times) / times
    return np.append(between.ravel(), grid[-1])
