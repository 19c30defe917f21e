"""Integration of a machine that is watched: as densely as its motion asks, whatever of it is stored."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.studies.motion.observation import Observation, Watch, fastest_of

_PER_TURN, _FEWEST_PER_TURN = 24, 12  # samples that are looked at
_MOST_AT_ONCE = 32_768  # of these
_FEWEST_AT_ONCE = 16_384  # before they are looked at: a look costs as much as some thousand samples
_SLOWER = 0.25  # of a turn a span: a body that swings or creeps is looked at as often as one that turns so slowly
_FASTER = 20.0  # times the speed: vibrations faster than that are not followed, turns average over them


@dataclass(frozen=True)
class Leg:
    """A part of a motion: what is stored of it, what was seen until shortly before its end, the machine's motion since then."""

    stored: Trajectory
    seen: Observation
    waiting: tuple[Trajectory, ...]


@dataclass(frozen=True)
class Watched:
    """watch: of the machine. compiled: its equations, or others whose trajectory ``seen`` turns into the machine's. vibration:
    the highest frequency of it. energy: the size of the works."""

    watch: Watch
    compiled: CompiledSystem
    seen: Callable[[Trajectory], Trajectory]
    vibration: float
    energy: float

    @property
    def machine(self) -> Machine:
        """What is watched."""
        return self.watch.machine

    def begin(self, initial: np.ndarray, values: tuple[float, ...]) -> Leg:
        """The first sample."""
        start = integrate(self.compiled, initial, values, np.zeros(1))
        return Leg(start, self.watch.begin(), (self.seen(start),))

    def observation(self, leg: Leg) -> Observation:
        """What was seen of a motion until the end of a part of it."""
        return self._looked(leg.seen, leg.waiting)

    def leg(self, before: Leg, grid: np.ndarray, report: Callable[[float], None] | None = None) -> Leg:
        """The part over an even grid, of which samples are stored, that begins at the last sample of the part before.

        report: called with the time reached. Raises ``KeyboardInterrupt`` where the user has stopped it.
        """
        last, seen, waiting, stored = before.stored, before.seen, before.waiting, list[Trajectory]()
        if last.ended:
            return before
        while len(grid) > 1 and not last.ended:
            motion, of_machine, fine = self._piece(last, grid, report)
            last = motion.every(fine)
            stored.append(last)
            waiting = (*waiting, replace(of_machine, quadratures={}))
            if sum(len(part.time) for part in waiting) > _FEWEST_AT_ONCE:
                seen, waiting = self._looked(seen, waiting), (waiting[-1].tail(1),)
            grid = grid[len(last.time) - 1 :]
        return Leg(Trajectory.of(stored), seen, waiting)

    def _looked(self, seen: Observation, motion: tuple[Trajectory, ...]) -> Observation:
        """What was seen after some parts of the machine's motion."""
        return self.watch.after(seen, self.watch.samples(Trajectory.of(motion)))

    def _piece(
        self, before: Trajectory, grid: np.ndarray, report: Callable[[float], None] | None
    ) -> tuple[Trajectory, Trajectory, int]:
        """As much of it as is held at once, the same as the machine's motion, and how many times more densely it is sampled.

        More densely than the grid: as the speeds in it ask.
        """
        step, fine = float(grid[1] - grid[0]), 0
        fastest = fastest_of(self.machine, self.seen(before.tail(1)).states)
        while True:
            rate = max(fastest, min(self.vibration, _FASTER * fastest), _SLOWER * 2 * math.pi / self.watch.span)
            wanted = _PER_TURN * rate * step / (2 * math.pi)
            fine = min(max(fine + 1, math.ceil(wanted * (1 - 1e-9))), _MOST_AT_ONCE)
            dense = _refined(grid[: max(1, _MOST_AT_ONCE // fine) + 1], fine)
            motion = integrate(self.compiled, before.end_state, before.parameters, dense, report, self.energy).uninterrupted()
            of_machine = self.seen(motion)
            fastest = fastest_of(self.machine, of_machine.states)
            enough = _FEWEST_PER_TURN * fastest * step <= 2 * math.pi * fine
            if enough or motion.failure or fine == _MOST_AT_ONCE:
                return motion, of_machine, fine


def _refined(grid: np.ndarray, times: int) -> np.ndarray:
    """An evenly spaced grid (N,) with so many intervals in place of each."""
    if times == 1:
        return grid
    between = grid[:-1, None] + np.diff(grid)[:, None] * np.arange(times) / times
    return np.append(between.ravel(), grid[-1])
