"""Recurrence at the end of a run: the time after which its last state returns, and the turns of angles in it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

_TURN = 2 * math.pi
_RETURNS = 0.01  # of the largest distance of the motion from its last state: a return comes nearer
_LEAVES = 0.2  # likewise: between returns it goes farther
_SMALL = 1e-4  # of a radian, or of a state's size: a smaller motion does not count
_SAME = 0.02  # relative: a second period that lasts as long as the first
_STEADY = 1e-6  # of a radian, or of a state's size


@dataclass(frozen=True)
class Recurrence:
    """Recurrent motion. period: the time from one return to the next. turns (n,): of angles in it, 0 of other states."""

    period: float
    turns: np.ndarray


def is_at_rest(states: np.ndarray) -> bool:
    """True if states (n, K), angles not wrapped, do not change."""
    sizes = np.maximum(np.abs(states).max(axis=1), 1.0)
    return bool((np.ptp(states, axis=1) < _STEADY * sizes).all())


def recurrence(times: np.ndarray, states: np.ndarray, turning: np.ndarray) -> Recurrence | None:
    """Return the last period of a motion that has become periodic, None where the last two differ or there are no two.

    Parameters
    ----------
    times : ndarray, (K,)
        Many in each period.
    states : ndarray, (n, K)
        Angles continued, not wrapped.
    turning : ndarray of bool, (n,)
        True for states that are angles.
    """
    away = _distance(states, turning)
    far = float(away.max())
    if not far > 0:
        return None
    returns = _returns(times, away / far)
    if len(returns) < 2:
        return None
    first, second = times[-1] - returns[0], times[-1] - returns[1]
    if abs(second / first - 2) > _SAME:
        return None
    gains = np.array([x[-1] - np.interp(returns[0], times, x) for x in states])
    return Recurrence(float(first), np.where(turning, np.round(gains / _TURN), 0).astype(int))


def _distance(states: np.ndarray, turning: np.ndarray) -> np.ndarray:
    """Return the distance of each state (n, K) from the last one, angles around the circle, in units of each one's range."""
    total = np.zeros(states.shape[1])
    for x, angle in zip(states, turning, strict=True):
        off, range_ = x - x[-1], float(np.ptp(x))
        least = _SMALL * (1.0 if angle else max(float(np.abs(x).max()), _SMALL))
        if angle and range_ > math.pi:
            total += (2 * np.sin(off / 2)) ** 2
        else:
            total += (off / max(range_, least)) ** 2
    return np.asarray(np.sqrt(total))


def _returns(times: np.ndarray, away: np.ndarray) -> list[float]:
    """Return the times of the last returns, the latest first: minima of the distance, between which it is large."""
    square, return_times = away**2, list[float]()
    last = len(away) - 1
    while True:
        departures = np.flatnonzero(away[:last] > _LEAVES)
        if not len(departures):
            return return_times
        inside = np.flatnonzero(away[: departures[-1]] < _LEAVES)
        if not len(inside):
            return return_times
        end = int(inside[-1])
        outside = np.flatnonzero(away[:end] >= _LEAVES)
        begin = int(outside[-1]) + 1 if len(outside) else 0
        k = begin + int(square[begin : end + 1].argmin())
        if 0 < k < len(away) - 1:
            a, b, c = square[k - 1 : k + 2]
            bend = a - 2 * b + c
            shift = (a - c) / (2 * bend) if bend > 0 else 0.0
            if math.sqrt(max(b - bend * shift**2 / 2, 0.0)) < _RETURNS:
                return_times.append(float(times[k] + shift * (times[k + 1] - times[k])))
        last = begin
        if len(return_times) > 2 or begin == 0:
            return return_times
