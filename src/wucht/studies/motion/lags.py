"""Whether a body lags behind its rotor: by how much, and for how long it must be watched until that is known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wucht.numerics.observers.projection import SHARE, Course, Projection, projected, windows_of
from wucht.numerics.observers.turn_record import Blocks
from wucht.numerics.observers.turns import PER_TURN
from wucht.results.outcomes import LAG_TOLERANCE

_ROUNDING = 1e-10  # of the speed
_AT_REST = 1e-3  # rad: a phase that moves less from window to window is at rest
_LIBRATION = math.pi / 2  # rad: a body that swings by less about where it rests on the rotor keeps doing so
_TUMBLING, _EVENLY = 1.5 * math.pi, 0.1  # rad, and share by which the halves of a swing differ at most
_WIDER = 2.0  # times the range of the lag seen: it may go beyond that by as much
_CATCHING_UP = 0.25  # of the lag: a drift that takes away less, as far as it is looked ahead, does not count


def lag_of(whole: Blocks, i: int, speed: float, ahead: float, borders: np.ndarray | None) -> Projection:
    """By how much a body will lag, as a share of the speed: not as long as it goes to and fro within a turn.

    i: which of the others. speed: the rotor's. ahead: how many windows are looked ahead. borders: of the groups of cycles that
    are the windows; None: tenths of the record. Its ``windows`` say in how many it will be known.
    """
    lag, durations = whole.followers[i] - whole.speed, 1 / whole.speed
    slip = np.cumsum(lag * durations) * (2 * math.pi * whole.size / PER_TURN)
    moving = projected(windows_of(slip).mean(axis=1), ahead, _AT_REST)
    if _librates(slip[len(slip) // 2 :]) and moving.width < 2 * math.pi:
        return Projection(0.0, 0.0, 0.0, Course.STATIONARY)
    if borders is not None:
        means = np.diff(np.interp(borders, whole.time, slip)) / np.diff(borders) / speed
    else:
        means = windows_of(lag * durations).sum(axis=1) / windows_of(durations).sum(axis=1) / speed
    p = projected(means, ahead, _ROUNDING, _WIDER)
    if abs(p.last) <= LAG_TOLERANCE:
        return replace(p, windows=p.windows * math.log(max(p.width / LAG_TOLERANCE, 1.0)))
    p = replace(p, low=min(p.low, float(means.min())), high=max(p.high, float(means.max())))
    # One that catches up, however slowly, will have done so; and one that has slipped by less than a turn may do so.
    change = abs(float(means[-1] - means[-2])) * ahead
    catching_up = p.course is Course.DRIFTING and (p.high > p.last) == (p.last < 0) and change > _CATCHING_UP * abs(p.last)
    late = float(np.ptp(slip[-max(2, len(slip) // 5) :]))
    e_fold = abs(p.last) * ahead / change if catching_up else p.windows
    windows = e_fold * math.log(max(p.width / LAG_TOLERANCE, 1.0))
    if not catching_up and 0 < late < 2 * math.pi:
        windows = (2 * math.pi / late - 1) / SHARE
    unsure = catching_up or late < 2 * math.pi
    return replace(p, low=min(p.low, 0.0), high=max(p.high, 0.0), windows=windows) if unsure else replace(p, windows=windows)


def _librates(slip: np.ndarray) -> bool:
    """Whether a body swings by less than a quarter of a turn about its place, or further, but evenly and without tumbling."""
    if np.ptp(slip) < _LIBRATION:
        return True
    earlier, late = (float(np.ptp(part)) for part in np.array_split(slip, 2))
    return bool(np.ptp(slip) < _TUMBLING and abs(late - earlier) <= _EVENLY * earlier)


def undecided(lag: Projection) -> bool:
    """Whether it cannot be told if a body lags."""
    return (lag.low < -LAG_TOLERANCE <= lag.high) or (lag.low <= LAG_TOLERANCE < lag.high)
