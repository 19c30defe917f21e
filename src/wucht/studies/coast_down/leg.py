"""From the samples of a leg to what is recorded of it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wucht.machines.machine import LOST
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.turns import PER_TURN, turns
from wucht.studies.coast_down.prepare import REVERSAL, Plan
from wucht.studies.coast_down.record import Leg, Record
from wucht.studies.observables import Orbit, rows_of

_NO_TURNS, _NO_TAIL = np.empty((2, 0)), np.empty((3, 0))
_TAIL_TURNS, _TAIL_SAMPLES_PER_TURN = 4, 3072  # more are thinned out: the error of interpolation is of fourth order


def reduced(plan: Plan, compiled: CompiledSystem, before: Record, t: Trajectory) -> Leg:
    """A leg that begins with the last sample of what was recorded before."""
    outputs, rotor = rows_of(compiled, t), plan.machine.rotor.coordinate
    angle, speed = outputs[rotor.position.name], outputs[rotor.velocity.name]
    balance, residual = before.balance.after(outputs["stored_energy"], t.quadratures)
    amplitude = Orbit.of(plan.machine, t.time, outputs, plan.at_rest).peaks
    last = _last_samples_of_rows(before, t.time)
    first = np.concatenate([[0], last])[: len(last)].astype(int)  # of what a row stands for, the last of the row before
    rows = {
        "time": t.time[last],
        "angle": angle[last],
        "speed": speed[last],
        "min_speed": np.minimum(np.minimum.reduceat(speed, first), speed[last]),
        "max_speed": np.maximum(np.maximum.reduceat(speed, first), speed[last]),
        "amplitude": np.maximum(np.maximum.reduceat(amplitude, first), amplitude[last]),
        "energy_residual": residual[last],
        "dissipated_work": t.quadratures[LOST][last],
    }
    reversals = tuple(h.time for h in t.hits if h.name == REVERSAL)
    mean, half_time, tail = _NO_TURNS, before.half_time, _NO_TAIL
    if before.reversal_time is None:
        mean, half_time, tail = _averaged(before, np.array([t.time, angle, speed]))
    return Leg(rows, mean, reversals, half_time, _NO_TAIL if reversals else _sparse(tail), balance, replace(t.tail(1), hits=()))


def _last_samples_of_rows(before: Record, time: np.ndarray) -> np.ndarray:
    """The samples (N,) with which rows end: one a stride, the last one of the leg, and the very first of the run."""
    width = max(1, round(before.stride / (time[1] - time[0]))) if len(time) > 1 else 1
    begun = bool(before.legs)
    found = np.unique([*range(width if begun else 0, len(time), width), len(time) - 1])
    return found[found >= int(begun)]


def _averaged(before: Record, samples: np.ndarray) -> tuple[np.ndarray, float | None, np.ndarray]:
    """Turn by turn, with what the leg before left over: the turns, the half time, and what is left over.

    samples: time, angle and speed (3, N).
    """
    joined = np.concatenate([before.tail, samples[:, int(before.tail.shape[1] > 0) :]], axis=1)
    back = np.flatnonzero(math.copysign(1.0, before.start_speed) * joined[2] <= 0)
    joined = joined[:, : back[0]] if len(back) else joined
    found = turns(joined[0], joined[1], joined[2], {})
    half_time, half = before.half_time, abs(before.start_speed) / 2
    if not len(found.time):
        return _NO_TURNS, _halved(joined[0], joined[2], half, 2) if half_time is None else half_time, joined
    if half_time is None:
        half_time = _halved(found.time, found.speed, half, 2 * PER_TURN)
    mean = np.array([found.time[::PER_TURN], found.speed[::PER_TURN]])
    last = before.turns[0, -1] if before.turns.size else -math.inf
    whole = mean[0] > last + 0.5 * 2 * math.pi / np.abs(mean[1])
    return mean[:, whole], half_time, joined[:, np.abs(joined[1, -1] - joined[1]) < 2 * math.pi * _TAIL_TURNS]


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
    t, y = time[near], over[near]
    straight = time[i] + over[i] / (over[i] - over[i + 1]) * (time[i + 1] - time[i])
    if len(t) < 4:
        return float(straight)
    roots = np.polynomial.Polynomial.fit(t, y, 3).roots()
    real = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots).max()].real
    return float(min(real, key=lambda r: abs(r - straight))) if len(real) else float(straight)
