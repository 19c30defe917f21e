"""The lag of a body behind its rotor, and the divergence of bodies that are modulated together."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import LAG_TOLERANCE
from wucht.numerics.observers.projection import Course, Projection, project, scatters, trend, windows_of
from wucht.numerics.observers.records import Blocks
from wucht.numerics.observers.turns import MARKS_PER_TURN

_CYCLES_ROUNDING = 1e-3  # of the lag: where cycles of a modulation begin and end is not known better
_AT_REST = 1e-3  # rad: a phase that moves less from window to window is at rest
LIBRATION = math.pi / 2  # rad: a body that swings by less about its place on the rotor keeps doing so
_TUMBLING, _EVENLY = 1.5 * math.pi, 0.1  # rad, and share by which the halves of a swing differ at most
_WIDER = 2.0  # times the observed range of the lag: it may leave that by as much
_IRREGULAR, _MANY_SLIPS = 0.1, 1000  # of the lag, and turns: a body that tumbles irregularly lags if it has done so for so long
_SMALL, _GROWING = 0.1, 1.05  # rad, and from quarter to quarter of the record: a swing that grows
_CATCHING_UP = 0.25  # of the lag: a drift that removes less of it in the windows ahead does not count


@dataclass(frozen=True)
class Lag(Projection):
    """Projected lag of a body, as a share of the speed. windows: until it is known. growing: it swings about its place, ever
    further."""

    growing: bool = False


def lag_of(whole: Blocks, i: int, speed: float, ahead: float, borders: np.ndarray | None, noise: Noise) -> Lag:
    """Project the lag of a body: zero as long as it swings within a turn.

    i: its row among the followers. speed: the rotor's. ahead: the windows to look ahead. borders: of the groups of cycles that
    are the windows; None: tenths of the record. noise: of the integration.
    """
    lag, durations = whole.followers[i] - whole.speed, 1 / whole.speed
    slip = np.cumsum(lag * durations) * (2 * math.pi * whole.size / MARKS_PER_TURN)
    place = project(windows_of(slip).mean(axis=1), ahead, max(_AT_REST, noise.angle))
    half = slip[len(slip) // 2 :]
    if _librates(half) and place.width < 2 * math.pi:
        growing = bool(grows(half)) and not scatters(np.abs(slip - half.mean()))
        return Lag(0.0, 0.0, 0.0, Course.STATIONARY, growing=growing)
    rounding = noise.speed
    if borders is not None:
        means = np.diff(np.interp(borders, whole.time, slip)) / np.diff(borders) / speed
        rounding = max(rounding, _CYCLES_ROUNDING * abs(float(means[-1])))
    else:
        means = windows_of(lag * durations).sum(axis=1) / windows_of(durations).sum(axis=1) / speed
    p = project(means, ahead, rounding, _WIDER)
    if abs(p.last) <= LAG_TOLERANCE:
        if p.course is Course.DRIFTING and p.low < 0 < p.high:  # one that catches up does not overtake
            p = replace(p, low=min(p.last, 0.0), high=max(p.last, 0.0))
        return Lag(p.last, p.low, p.high, p.course, p.windows_until(LAG_TOLERANCE))
    last, low, high = p.last, min(p.low, float(means.min())), max(p.high, float(means.max()))
    # One that catches up, however slowly, will have done so; one that has slipped too little, or tumbles, may do so.
    wait = _windows_until_caught_up(means, p, ahead)
    late, slips = float(np.ptp(slip[-max(2, len(slip) // 5) :])), float(np.ptp(slip)) / (2 * math.pi)
    irregular = np.ptp(means) > _IRREGULAR * abs(last)
    if wait is None and (late < 2 * math.pi or (irregular and slips < _MANY_SLIPS)):
        wait = math.inf  # the time at which a body is caught that slips slowly, or tumbles, is not known
    if wait is None:
        return Lag(last, low, high, p.course, replace(p, low=low, high=high).windows_until(LAG_TOLERANCE))
    return Lag(last, min(low, 0.0), max(high, 0.0), p.course, wait)


def _windows_until_caught_up(means: np.ndarray, p: Projection, ahead: float) -> float | None:
    """Return the windows until a body turns with the rotor if its lag continues to fall; None if it does not reach that."""
    sizes = np.abs(means)
    change = abs(float(means[-1] - means[-2])) * ahead
    if p.course is Course.DRIFTING and (p.high > p.last) == (p.last < 0) and change > _CATCHING_UP * abs(p.last):
        return abs(p.last) * ahead / change
    if p.course is not Course.APPROACHING or trend(sizes) >= 0 or (means * means[-1] <= 0).any() or sizes[-1] >= sizes[0]:
        return None
    fall = math.log(sizes[0] / sizes[-1]) / (len(sizes) - 1)
    until = math.log(sizes[-1] / LAG_TOLERANCE) / fall
    return until if until < ahead else None


def grows(slip: np.ndarray, axis: int = 0) -> np.ndarray:
    """True if a swing grows that is not small."""
    earlier, late = (np.ptp(part, axis=axis) for part in np.array_split(slip, 2, axis=axis))
    return np.asarray(late > np.maximum(_SMALL, _GROWING * earlier))


def _librates(slip: np.ndarray) -> bool:
    """True if a body swings by less than a quarter of a turn about its place, or further, but evenly and without tumbling."""
    if np.ptp(slip) < LIBRATION:
        return True
    earlier, late = (float(np.ptp(part)) for part in np.array_split(slip, 2))
    return bool(np.ptp(slip) < _TUMBLING and abs(late - earlier) <= _EVENLY * earlier)


def is_undecided(lag: Projection) -> bool:
    """True if it is not known whether a body lags."""
    return (lag.low < -LAG_TOLERANCE <= lag.high) or (lag.low <= LAG_TOLERANCE < lag.high)


_VISIBLE = 1e-4  # rad: a difference that exceeds the accuracy of cycles
_APART = 1.0  # rad
_SLOWS_DOWN = 0.5  # of its first growth, in the logarithm: what grows less at last comes to a limit


def windows_until_divergence(whole: Blocks, about: Sequence[int], borders: np.ndarray, noise: Noise) -> float:
    """Return the windows until two bodies about a rotor have diverged, as their difference grows; inf if none does.

    about: their rows among the followers. borders: the times (g + 1,) between groups of whole cycles, the windows. noise: of
    the integration.
    """
    slip_angles = np.cumsum(
        (whole.followers[list(about)] / whole.speed - 1) * (2 * math.pi * whole.size / MARKS_PER_TURN), axis=1
    )
    at = np.searchsorted(whole.time, borders)
    differences = [a - b for a, b in itertools.combinations(slip_angles, 2)]
    if (np.diff(at) == 0).any():  # a window between two blocks of the record
        return math.inf
    window_sizes = ([float(np.ptp(d[i:j])) for i, j in itertools.pairwise(at)] for d in differences)
    return min((_windows_until_radian(sizes, max(_VISIBLE, noise.angle)) for sizes in window_sizes), default=math.inf)


def _windows_until_radian(sizes: Sequence[float], least: float) -> float:
    """Return the windows until a difference of such sizes in successive windows is a radian; inf if it will not be.

    least: smaller differences are treated as zero.
    """
    if len(sizes) < 3 or min(sizes) < least:
        return math.inf
    growth = np.diff(np.log(sizes))
    if (growth <= 0).any() or growth[-1] < _SLOWS_DOWN * growth[0]:
        return math.inf
    return max(math.log(_APART / sizes[-1]), 0.0) / float(growth.mean())
