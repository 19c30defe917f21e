"""From samples over time to signals averaged over turns, without the ripple within a turn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

PER_TURN = 16


@dataclass(frozen=True)
class Turns:
    """Signals averaged over one turn of a leading angle, PER_TURN points a turn.

    time, angle: (K,), of the middle of each turn. speed: mean over the turn. followers: mean speeds of other angles (n, K).
    phases: exp(i (follower - leader)) averaged over the turn (n, K): of modulus 1 for a body that turns synchronously.
    """

    time: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    followers: np.ndarray
    phases: np.ndarray

    @property
    def count(self) -> float:
        """The number of turns."""
        return len(self.time) / PER_TURN

    def last(self, share: float) -> slice:
        """The last share of all turns, at least one point."""
        return slice(len(self.time) - max(1, round(share * len(self.time))), None)


def turns(
    time: np.ndarray, angle: np.ndarray, speed: np.ndarray, followers: Mapping[str, tuple[np.ndarray, np.ndarray]]
) -> Turns:
    """Average over turns of the leading angle, over the last part of the samples in which it turns one way.

    time, angle, speed: (N,). followers: (angle, speed) of other bodies. Cubic Hermite interpolation makes use of the
    speeds; the error is of fourth order in the sampling interval. Returns empty signals if there is not one full turn.
    """
    n = len(followers)
    nothing = Turns(np.empty(0), np.empty(0), np.empty(0), np.empty((n, 0)), np.empty((n, 0), complex))
    if len(time) < 4:
        return nothing
    sense = np.sign(speed[-1]) or 1.0
    backward = np.flatnonzero(sense * speed <= 1e-9 * np.abs(speed).max())
    first = int(backward[-1]) + 1 if len(backward) else 0
    t, leader = time[first:], sense * angle[first:]
    if len(t) < 4 or leader[-1] - leader[0] < 2 * np.pi * (1 + 2 / PER_TURN):
        return nothing
    grid = np.arange(leader[0], leader[-1], 2 * np.pi / PER_TURN)
    at = hermite(grid, leader, t, 1 / (sense * speed[first:]))
    duration = at[PER_TURN:] - at[:-PER_TURN]
    middle = slice(PER_TURN // 2, PER_TURN // 2 + len(duration))
    mean_speeds, phases = np.empty((n, len(duration))), np.empty((n, len(duration)), complex)
    for k, (body_angle, body_speed) in enumerate(followers.values()):
        follower = hermite(at, t, body_angle[first:], body_speed[first:])
        mean_speeds[k] = (follower[PER_TURN:] - follower[:-PER_TURN]) / duration
        phases[k] = _moving_mean(np.exp(1j * (follower - sense * grid)))[: len(duration)]
    return Turns(at[middle], sense * grid[middle], sense * 2 * np.pi / duration, mean_speeds, phases)


def hermite(at: np.ndarray, x: np.ndarray, y: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Cubic Hermite interpolation of y(x) with its derivative, all (N,), at points ``at``; error of fourth order.

    SciPy has the same, but importing it takes longer than a whole run-up.
    """
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    h = x[i + 1] - x[i]
    s = (at - x[i]) / h
    rise = y[i + 1] - y[i]
    left, right = h * slope[i] - rise, rise - h * slope[i + 1]
    return np.asarray(y[i] + s * rise + s * (1 - s) * ((1 - s) * left + s * right))


def _moving_mean(signal: np.ndarray) -> np.ndarray:
    total = np.concatenate([[0.0], np.cumsum(signal)])
    # Trapezoid over one full turn: the end points count half each.
    return np.asarray((total[PER_TURN:-1] - total[: -PER_TURN - 1] + (signal[PER_TURN:] - signal[:-PER_TURN]) / 2) / PER_TURN)
