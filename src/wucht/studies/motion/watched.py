"""Integration of a machine that is watched: as densely as its motion asks, whatever of it is stored."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.studies.motion.observation import fastest_of

_PER_TURN, _FEWEST_SHARE = 24, 0.5  # samples that are looked at, and what of them is enough
_MOST_AT_ONCE = 32_768  # of these
_FEWEST_AT_ONCE = 16_384  # before they are looked at: a look costs as much as some thousand samples
_SLOWER = 0.25  # of a turn a span: a body that swings or creeps is looked at as often as one that turns so slowly
_FASTER = 20.0  # times the speed: vibrations faster than that are not followed, turns average over them
Seen = TypeVar("Seen")


class Watcher(Protocol[Seen]):
    """What watches a machine, and what it has seen of its motion so far.

    span: of time, in which the fastest motion is sampled several times.
    """

    @property
    def machine(self) -> Machine:
        """What is watched."""
        ...

    @property
    def span(self) -> float:
        """See above."""
        ...

    def begin(self) -> Seen:
        """Before anything has been seen."""
        ...

    def looked(self, seen: Seen, motion: Trajectory) -> Seen:
        """After a part of the machine's motion, which may begin with the last sample of the part before."""
        ...


@dataclass(frozen=True)
class Leg(Generic[Seen]):
    """A part of a motion: what is stored of it, what was seen until shortly before its end, the machine's motion since then."""

    stored: Trajectory
    seen: Seen
    waiting: tuple[Trajectory, ...]


@dataclass(frozen=True)
class Watched(Generic[Seen]):
    """watch: of the machine. compiled: its equations, or others whose trajectory ``seen`` turns into the machine's. vibration:
    the highest frequency of it. energy: the size of the works. per_turn: samples that are looked at."""

    watch: Watcher[Seen]
    compiled: CompiledSystem
    seen: Callable[[Trajectory], Trajectory]
    vibration: float
    energy: float
    per_turn: int = _PER_TURN

    @property
    def machine(self) -> Machine:
        """What is watched."""
        return self.watch.machine

    def begin(self, initial: np.ndarray, values: tuple[float, ...]) -> Leg[Seen]:
        """The first sample."""
        start = integrate(self.compiled, initial, values, np.zeros(1))
        return Leg(start, self.watch.begin(), (self.seen(start),))

    def observation(self, leg: Leg[Seen]) -> Seen:
        """What was seen of a motion until the end of a part of it."""
        return self._looked(leg.seen, leg.waiting)

    def leg(self, before: Leg[Seen], grid: np.ndarray, report: Callable[[float], None] | None = None) -> Leg[Seen]:
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

    def _looked(self, seen: Seen, motion: tuple[Trajectory, ...]) -> Seen:
        """What was seen after some parts of the machine's motion."""
        return self.watch.looked(seen, Trajectory.of(motion))

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
            wanted = self.per_turn * rate * step / (2 * math.pi)
            fine = min(max(fine + 1, math.ceil(wanted * (1 - 1e-9))), _MOST_AT_ONCE)
            dense = _refined(grid[: max(1, _MOST_AT_ONCE // fine) + 1], fine)
            motion = integrate(self.compiled, before.end_state, before.parameters, dense, report, self.energy).uninterrupted()
            of_machine = self.seen(motion)
            fastest = fastest_of(self.machine, of_machine.states)
            enough = _FEWEST_SHARE * self.per_turn * fastest * step <= 2 * math.pi * fine
            if enough or motion.failure or fine == _MOST_AT_ONCE:
                return motion, of_machine, fine


def _refined(grid: np.ndarray, times: int) -> np.ndarray:
    """An evenly spaced grid (N,) with so many intervals in place of each."""
    if times == 1:
        return grid
    between = grid[:-1, None] + np.diff(grid)[:, None] * np.arange(times) / times
    return np.append(between.ravel(), grid[-1])
