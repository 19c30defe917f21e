"""What is recorded of a coast-down, leg by leg: few rows of the run, the speed averaged over each turn, when it had halved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.dynamics.verdicts.observation import Orbit, balanced, rows_of
from wucht.machines.machine import LOST, Machine
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.turns import PER_TURN, Samples, TurnObserver

MOST_ROWS = 8000
REVERSAL = "reversal"  # the event at which the main rotor turns back
ROW = ("time", "angle", "speed", "min_speed", "max_speed", "amplitude", "energy_residual", "dissipated_work")
_OF_TWO = {"min_speed": np.minimum, "max_speed": np.maximum, "amplitude": np.maximum}  # rows; of others the second stays
_REACH = 2 * PER_TURN  # averages before and after the speed has halved, through which the time of that is found
_SAMPLES_REACH = 2  # likewise, samples


@dataclass(frozen=True, kw_only=True)
class Descent:
    """A leg of the run, reduced: a unit of work.

    rows: columns (N,) by the names of ``ROW``; extremes are those since the row before. turns: the time in the middle of each
    turn up to the first reversal, and the mean speed over it (2, K). reversals: when the rotor turns back. observer: averages
    over turns; averages: how many there were. halving: time and speed (2, k) of those around the moment at which the
    speed has fallen to half of that at the start, or of the last ones; samples around it, as long as no turn is made. end: the
    last sample, from which the run continues.
    """

    end: Trajectory
    rows: dict[str, np.ndarray] = field(default_factory=lambda: dict.fromkeys(ROW, np.empty(0)))
    turns: np.ndarray = field(default_factory=lambda: np.empty((2, 0)))
    reversals: tuple[float, ...] = ()
    observer: TurnObserver = field(default_factory=TurnObserver)
    averages: int = 0
    halving: np.ndarray = field(default_factory=lambda: np.empty((2, 0)))
    balance: EnergyBalance = field(default_factory=EnergyBalance)


@dataclass(frozen=True, kw_only=True)
class Record(Descent):
    """The run so far, as one leg. stride: the time between rows. legs: how many there are."""

    start_speed: float
    stride: float
    legs: int = 0

    @property
    def half_time(self) -> float | None:
        """When the speed averaged over a turn (without a turn, the speed itself) has fallen to half of that at the start."""
        return _halved(self.halving[0], self.halving[1], abs(self.start_speed) / 2)

    def after(self, leg: Descent) -> Record:
        """The record with the next leg; with too many rows each two become one."""
        rows, stride = {name: np.append(self.rows[name], leg.rows[name]) for name in ROW}, self.stride
        if len(rows["time"]) > MOST_ROWS:
            rows, stride = {name: _thinned(name, column) for name, column in rows.items()}, 2 * stride
        turns, reversals = np.append(self.turns, leg.turns, axis=1), self.reversals + leg.reversals
        joined = vars(leg) | {"rows": rows, "turns": turns, "reversals": reversals}
        return replace(self, **joined, stride=stride, legs=self.legs + 1)


def _thinned(name: str, column: np.ndarray) -> np.ndarray:
    """The first row, and one for each two after it; the extremes of both stay."""
    even = len(column) - 1 + len(column) % 2
    first, second = column[1:even:2], column[2:even:2]
    return np.concatenate([column[:1], _OF_TWO[name](first, second) if name in _OF_TWO else second, column[even:]])


def reduced(machine: Machine, at_rest: Mapping[str, float], compiled: CompiledSystem, before: Record, t: Trajectory) -> Descent:
    """A leg that begins with the last sample of what was recorded before. at_rest: where the carrier's axis rests."""
    outputs, rotor = rows_of(compiled, t), machine.rotor.coordinate
    time, angle, speed = t.time, outputs[rotor.position.name], outputs[rotor.velocity.name]
    balance, residual = balanced(before.balance, outputs["stored_energy"], t.quadratures)
    amplitude = Orbit.of(machine, time, outputs, at_rest).peaks
    # A row ends with one sample a stride, with the last one of the leg, and with the very first of the run.
    width, begun = max(1, round(before.stride / (time[1] - time[0]))) if len(time) > 1 else 1, int(before.legs > 0)
    last = np.unique([*range(width * begun, len(time), width), len(time) - 1])
    last = last[last >= begun]
    first = np.append(0, last)[: len(last)].astype(int)  # of what a row stands for, the last of the row before
    rows = {
        "time": time[last],
        "angle": angle[last],
        "speed": speed[last],
        "min_speed": np.minimum(np.minimum.reduceat(speed, first), speed[last]),
        "max_speed": np.maximum(np.maximum.reduceat(speed, first), speed[last]),
        "amplitude": np.maximum(np.maximum.reduceat(amplitude, first), amplitude[last]),
        "energy_residual": residual[last],
        "dissipated_work": t.quadratures[LOST][last],
    }
    reversals = tuple(h.time for h in t.hits if h.name == REVERSAL)
    leg = Descent(end=replace(t.tail(1), hits=()), rows=rows, reversals=reversals, balance=balance)
    if before.reversals:
        return replace(leg, averages=before.averages, halving=before.halving)
    observer, averaged = before.observer.after(Samples.of(time, (angle, speed)))
    averaged = averaged.part(averaged.passage == 0)
    number = before.averages + np.arange(len(averaged.time))
    mean = np.array([averaged.middle, averaged.speed])
    turns, averages, half = mean[:, number % PER_TURN == 0], before.averages + len(number), abs(before.start_speed) / 2
    # Where it halves before there is a whole turn, the speed itself must do.
    by_turns = bool(before.averages or (averages and abs(mean[1, 0]) > half))
    known = before.halving if before.averages or not by_turns else np.empty((2, 0))
    points = np.append(known, mean if by_turns else np.array([time, speed]), axis=1)
    halving = _around(points, half, _REACH if by_turns else _SAMPLES_REACH)
    return replace(leg, turns=turns, observer=observer, averages=averages, halving=halving)


def _around(points: np.ndarray, half: float, reach: int) -> np.ndarray:
    """Of times and speeds (2, k) those around the moment at which the speed has halved, else the last ones."""
    i = _crossing(points[1], half)
    return points[:, -reach:] if i is None else points[:, max(0, i + 1 - reach) : i + 1 + reach]


def _crossing(speed: np.ndarray, half: float) -> int | None:
    """After which point the speed falls to half."""
    over = np.abs(speed) - half
    below = np.flatnonzero((over[:-1] > 0) & (over[1:] <= 0))
    return int(below[0]) if len(below) else None


def _halved(time: np.ndarray, speed: np.ndarray, half: float) -> float | None:
    """When the speed falls to half: the root of the cubic through the points around. None where it does not."""
    i, over = _crossing(speed, half), np.abs(speed) - half
    if i is None:
        return None
    straight = time[i] + over[i] / (over[i] - over[i + 1]) * (time[i + 1] - time[i])
    if len(time) < 4:
        return float(straight)
    roots = np.polynomial.Polynomial.fit(time, over, 3).roots()
    real = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots).max()].real
    return float(min(real, key=lambda r: abs(r - straight), default=straight))
