"""What is recorded of a coast-down, leg by leg: few rows of the run, the speed averaged over each turn, when it had halved."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.machines.machine import LOST
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.turns import PER_TURN, turns
from wucht.studies.coast_down.prepare import REVERSAL, Plan
from wucht.studies.observables import EnergyBalance, Orbit, rows_of

MOST_ROWS = 8000
ROW = ("time", "angle", "speed", "min_speed", "max_speed", "amplitude", "energy_residual", "dissipated_work")
_OF_TWO = {"min_speed": np.minimum, "max_speed": np.maximum, "amplitude": np.maximum}  # rows; of others the second stays
_TAIL_TURNS, _TAIL_SAMPLES_PER_TURN = 4, 3072  # more are thinned out: the error of interpolation is of fourth order


@dataclass(frozen=True, kw_only=True)
class Descent:
    """A leg of the run, reduced: a unit of work.

    rows: columns (N,) by the names of ``ROW``; extremes are those since the row before. turns: the time in the middle of each
    turn up to the first reversal, and the mean speed over it (2, K). reversals: when the rotor turns back. half_time: when the
    speed averaged over a turn has fallen to half of that at the start. tail: time, angle and speed (3, k) of the last turns,
    with which the average over the next ones begins. end: the last sample, from which the run continues.
    """

    end: Trajectory
    rows: dict[str, np.ndarray] = field(default_factory=lambda: dict.fromkeys(ROW, np.empty(0)))
    turns: np.ndarray = field(default_factory=lambda: np.empty((2, 0)))
    reversals: tuple[float, ...] = ()
    half_time: float | None = None
    tail: np.ndarray = field(default_factory=lambda: np.empty((3, 0)))
    balance: EnergyBalance = field(default_factory=EnergyBalance)


@dataclass(frozen=True, kw_only=True)
class Record(Descent):
    """The run so far, as one leg. stride: the time between rows. legs: how many there are."""

    start_speed: float
    stride: float
    legs: int = 0

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


def reduced(plan: Plan, compiled: CompiledSystem, before: Record, t: Trajectory) -> Descent:
    """A leg that begins with the last sample of what was recorded before."""
    outputs, rotor = rows_of(compiled, t), plan.machine.rotor.coordinate
    time, angle, speed = t.time, outputs[rotor.position.name], outputs[rotor.velocity.name]
    balance, residual = before.balance.after(outputs["stored_energy"], t.quadratures)
    amplitude = Orbit.of(plan.machine, time, outputs, plan.at_rest).peaks
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
    leg = Descent(end=replace(t.tail(1), hits=()), rows=rows, reversals=reversals, half_time=before.half_time, balance=balance)
    if before.reversals:
        return leg
    mean, half_time, tail = _averaged(before, np.array([time, angle, speed]))
    return replace(leg, turns=mean, half_time=half_time, tail=leg.tail if reversals else _sparse(tail))


def _averaged(before: Record, samples: np.ndarray) -> tuple[np.ndarray, float | None, np.ndarray]:
    """Turn by turn, with what the leg before left over: the turns, the half time, and what is left over.

    samples: time, angle and speed (3, N).
    """
    joined = np.concatenate([before.tail, samples[:, int(before.tail.shape[1] > 0) :]], axis=1)
    back = np.flatnonzero(math.copysign(1.0, before.start_speed) * joined[2] <= 0)
    joined = joined[:, : back[0]] if len(back) else joined
    averaged = turns(joined[0], joined[1], joined[2], {})
    half_time, half, whole = before.half_time, abs(before.start_speed) / 2, len(averaged.time) > 0
    if half_time is None:
        time, speed, reach = (averaged.time, averaged.speed, 2 * PER_TURN) if whole else (joined[0], joined[2], 2)
        half_time = _halved(time, speed, half, reach)
    if not whole:
        return np.empty((2, 0)), half_time, joined
    mean = np.array([averaged.time[::PER_TURN], averaged.speed[::PER_TURN]])
    last = before.turns[0, -1] if before.turns.size else -math.inf
    new = mean[0] > last + 0.5 * 2 * math.pi / np.abs(mean[1])
    return mean[:, new], half_time, joined[:, np.abs(joined[1, -1] - joined[1]) < 2 * math.pi * _TAIL_TURNS]


def _sparse(tail: np.ndarray) -> np.ndarray:
    """A tail (3, k) that is not too dense, evenly over the angle, with its last sample: a rotor that creeps has many a turn."""
    turned = np.abs(tail[1] - tail[1, :1])
    count = 2 + math.ceil(_TAIL_SAMPLES_PER_TURN * turned.max(initial=0.0) / (2 * math.pi))
    if tail.shape[1] <= count:
        return tail
    even = np.searchsorted(np.maximum.accumulate(turned), np.linspace(0.0, turned.max(), count))
    return tail[:, np.unique(np.append(even, tail.shape[1] - 1))]


def _halved(time: np.ndarray, speed: np.ndarray, half: float, reach: int) -> float | None:
    """When the speed falls to half: the root of the cubic through the points before and after the crossing, ``reach`` each.

    time, speed (N,): averages over a turn; before there is one whole turn, the speed itself. None where it does not.
    """
    over = np.abs(speed) - half
    below = np.flatnonzero((over[:-1] > 0) & (over[1:] <= 0))
    if not len(below):
        return None
    i = int(below[0])
    near = slice(max(0, i - reach), i + reach + 2)
    straight = time[i] + over[i] / (over[i] - over[i + 1]) * (time[i + 1] - time[i])
    if len(time[near]) < 4:
        return float(straight)
    roots = np.polynomial.Polynomial.fit(time[near], over[near], 3).roots()
    real = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots).max()].real
    return float(min(real, key=lambda r: abs(r - straight), default=straight))
