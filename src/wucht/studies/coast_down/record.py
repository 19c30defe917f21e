"""What is recorded of a coast-down: few rows of the whole run, the speed averaged over each turn, and when it had halved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.numerics.flow.trajectory import Trajectory
from wucht.studies.observables import EnergyBalance

MOST_ROWS = 8000
ROW = ("time", "angle", "speed", "min_speed", "max_speed", "amplitude", "energy_residual", "dissipated_work")
_OF_TWO = {"min_speed": np.minimum, "max_speed": np.maximum, "amplitude": np.maximum}


@dataclass(frozen=True)
class Leg:
    """A leg of the run, reduced: a unit of work.

    rows: the columns of ``ROW``, (N,) each. turns: (2, K), see ``Record``. reversals: when the rotor turns back. half_time,
    tail, balance, end: those of the record after it.
    """

    rows: Mapping[str, np.ndarray]
    turns: np.ndarray
    reversals: tuple[float, ...]
    half_time: float | None
    tail: np.ndarray
    balance: EnergyBalance
    end: Trajectory


@dataclass(frozen=True)
class Record:
    """The run so far.

    rows: time, angle, speed, least and largest speed since the row before, largest amplitude since, energy residual, energy
    lost, (N,) each; stride: the time between them. turns: the time in the middle of each turn up to the first reversal, and
    the mean speed over it (2, K). half_time: when the speed averaged over a turn has fallen to half of ``start_speed``.
    swings: how often it has turned back, at first at ``reversal_time``. tail: time, angle and speed (3, k) of the last turns,
    with which the average over the next ones begins. end: the last sample, from which the run goes on.
    """

    start_speed: float
    stride: float
    end: Trajectory
    rows: Mapping[str, np.ndarray] = field(default_factory=lambda: dict.fromkeys(ROW, np.empty(0)))
    turns: np.ndarray = field(default_factory=lambda: np.empty((2, 0)))
    half_time: float | None = None
    reversal_time: float | None = None
    swings: int = 0
    legs: int = 0
    tail: np.ndarray = field(default_factory=lambda: np.empty((3, 0)))
    balance: EnergyBalance = field(default_factory=EnergyBalance)

    def after(self, leg: Leg) -> Record:
        """The record with the next leg."""
        rows = {name: np.concatenate([self.rows[name], leg.rows[name]]) for name in ROW}
        crowded = len(rows["time"]) > MOST_ROWS
        return replace(
            self,
            stride=2 * self.stride if crowded else self.stride,
            end=leg.end,
            rows={name: _every_second(name, column) for name, column in rows.items()} if crowded else rows,
            turns=np.concatenate([self.turns, leg.turns], axis=1),
            half_time=leg.half_time,
            reversal_time=next(iter(leg.reversals), None) if self.reversal_time is None else self.reversal_time,
            swings=self.swings + len(leg.reversals),
            legs=self.legs + 1,
            tail=leg.tail,
            balance=leg.balance,
        )


def _every_second(name: str, column: np.ndarray) -> np.ndarray:
    """The first row, of the others every second one; the extremes of both stay."""
    rest = column[1:]
    even = len(rest) // 2 * 2
    first, second = rest[:even:2], rest[1:even:2]
    return np.concatenate([column[:1], _OF_TWO[name](first, second) if name in _OF_TWO else second, rest[even:]])
