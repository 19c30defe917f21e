"""Integration of a machine with an observer: sampled as densely as the motion needs, however little of it is stored."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from wucht.dynamics.verdicts.observation import fastest_of
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory

_PER_TURN, _FEWEST_SHARE = 24, 0.5  # observed samples, and the share of them that is enough
_MOST_AT_ONCE = 32_768  # of these
_FEWEST_AT_ONCE = 16_384  # before they are observed: an update costs as much as some thousand samples
_SLOWER = 0.25  # of a turn a span: a body that swings or creeps is observed as often as one that turns so slowly
_FASTER = 20.0  # times the speed: vibrations faster than that are not resolved, turns average over them
_ROUNDING = 1e-9  # of a step
Seen = TypeVar("Seen")


class Watcher(Protocol[Seen]):
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

    def begin(self) -> Seen:
        """Return the empty observation."""
        ...

    def looked(self, seen: Seen, motion: Trajectory) -> Seen:
        """Return the observation after a further part of the motion, which may begin with the last sample of the one before."""
        ...


@dataclass(frozen=True)
class Leg(Generic[Seen]):
    """A part of a motion: its stored samples, the observation until shortly before its end, the machine's motion since."""

    stored: Trajectory
    seen: Seen
    waiting: tuple[Trajectory, ...]


@dataclass(frozen=True)
class Watched(Generic[Seen]):
    """Integration of a machine with an observer.

    observer: of the machine. compiled_system: its equations, or others whose trajectory ``machine_motion`` turns into the
    machine's. vibration: the highest frequency of it. energy: the size of the works. per_turn: observed samples.
    """

    watch: Watcher[Seen]
    compiled: CompiledSystem
    seen: Callable[[Trajectory], Trajectory]
    vibration: float
    energy: float
    per_turn: int = _PER_TURN

    @property
    def machine(self) -> Machine:
        """The observed machine."""
        return self.watch.machine

    def begin(self, initial: np.ndarray, values: tuple[float, ...]) -> Leg[Seen]:
        """Return the leg that has the first sample alone."""
        start = integrate(self.compiled, initial, values, np.zeros(1))
        return Leg(start, self.watch.begin(), (self.seen(start),))

    def observation(self, leg: Leg[Seen]) -> Seen:
        """Return the observation of a motion until the end of a leg."""
        return self._looked(leg.seen, leg.waiting)

    def rate(self, leg: Leg[Seen]) -> float:
        """The highest frequency (rad per time) in a motion at the end of a leg: of a body that turns, or of vibrations."""
        return self._highest(fastest_of(self.machine, self.seen(leg.stored.tail(1))))

    def leg(
        self,
        before: Leg[Seen],
        grid: np.ndarray,
        report: Callable[[float], None] | None = None,
        closest: float | None = None,
    ) -> Leg[Seen]:
        """Integrate the leg over a grid, the samples that are stored, from the last sample of the leg before on.

        report: called with the time reached. closest: if the motion is much faster than the grid is made for, more
        samples are stored, at least this span of time apart; None: those of the grid. Raises ``KeyboardInterrupt`` where the
        user has stopped it.
        """
        last, seen, waiting, stored = before.stored, before.seen, before.waiting, list[Trajectory]()
        if last.ended:
            return before
        while len(grid) > 1 and not last.ended:
            motion, of_machine, fine = self._piece(last, grid, report)
            every, over = fine, (len(motion.time) - 1) // fine
            if closest is not None and len(motion.time) > 1:
                highest = self._highest(fastest_of(self.machine, of_machine))
                span, apart = 2 * math.pi / (self.per_turn * highest), float(np.diff(motion.time).max())
                if fine * apart * _FEWEST_SHARE > span:
                    every = min(fine, max(1, math.floor(max(span, closest) / apart * (1 + _ROUNDING))))
            last = motion.every(every) if motion.ended else motion.every(every, with_last=True)
            stored.append(last)
            waiting = (*waiting, replace(of_machine, quadratures={}))
            if sum(len(part.time) for part in waiting) > _FEWEST_AT_ONCE:
                seen, waiting = self._looked(seen, waiting), (waiting[-1].tail(1),)
            grid = grid[over:]
        return Leg(Trajectory.of(stored), seen, waiting)

    def _highest(self, fastest: float) -> float:
        """The highest frequency of a motion in which the fastest body turns with this speed."""
        return max(fastest, self.vibration, _SLOWER * 2 * math.pi / self.watch.span)

    def _looked(self, seen: Seen, motion: tuple[Trajectory, ...]) -> Seen:
        """Return the observation after some further parts of the machine's motion."""
        return self.watch.looked(seen, Trajectory.of(motion))

    def _piece(
        self, before: Trajectory, grid: np.ndarray, report: Callable[[float], None] | None
    ) -> tuple[Trajectory, Trajectory, int]:
        """Integrate as much as is held at once; also return it as the machine's motion, and by how much its grid is refined.

        The refinement is what the speeds in it need.
        """
        step, fine = float(np.diff(grid).max()), 0
        fastest = fastest_of(self.machine, self.seen(before.tail(1)))
        while True:
            rate = max(fastest, min(self.vibration, _FASTER * fastest), _SLOWER * 2 * math.pi / self.watch.span)
            wanted = self.per_turn * rate * step / (2 * math.pi)
            fine = min(max(fine + 1, math.ceil(wanted * (1 - _ROUNDING))), _MOST_AT_ONCE)
            dense = _refined(grid[: max(1, _MOST_AT_ONCE // fine) + 1], fine)
            motion = integrate(self.compiled, before.end_state, before.parameters, dense, report, self.energy).uninterrupted()
            of_machine = self.seen(motion)
            fastest = fastest_of(self.machine, of_machine)
            enough = _FEWEST_SHARE * self.per_turn * fastest * step <= 2 * math.pi * fine
            if enough or motion.failure or fine == _MOST_AT_ONCE:
                return motion, of_machine, fine


def _refined(grid: np.ndarray, times: int) -> np.ndarray:
    """Return a grid (N,) with so many intervals in place of each."""
    if times == 1:
        return grid
    between = grid[:-1, None] + np.diff(grid)[:, None] * np.arange(times) / times
    return np.append(between.ravel(), grid[-1])
