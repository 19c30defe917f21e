"""Whether a slow signal is steady, modulated, or in transition: decided from its last part, with an estimate of the rest."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Trend:
    """How far a signal still moves, estimated from three equal windows at its end.

    change: between the last two windows. remaining: what a geometric approach would still add (inf if it does not contract).
    windows_needed: how many more windows until both together fall below the tolerance (inf likewise).
    """

    change: float
    remaining: float
    windows_needed: float

    def steady(self, tolerance: float) -> bool:
        """Whether what is left to change is below the tolerance."""
        return self.change + self.remaining <= tolerance


def trend(signals: np.ndarray, tolerance: float) -> Trend:
    """The trend of signals (k, N), complex or real, already scaled so that 1 is large.

    The three windows are the last three tenths of the samples. For a geometric approach with ratio rho between windows the
    rest is change rho/(1 - rho).
    """
    n = signals.shape[1] // 10
    if n < 1:
        return Trend(math.inf, math.inf, math.inf)
    before, after = np.abs(np.diff(_last_means(signals, n), axis=0)).max(axis=1).tolist()
    if after <= 1e-2 * tolerance:
        return Trend(after, 0.0, 0.0)
    ratio = after / before if before > 0 else math.inf
    if ratio >= 1:
        return Trend(after, math.inf, math.inf)
    remaining = after * ratio / (1 - ratio)
    needed = max(0.0, math.log(max(after + remaining, 1e-300) / tolerance) / -math.log(ratio)) if ratio > 0 else 0.0
    return Trend(after, remaining, needed)


def creep(signals: np.ndarray) -> float:
    """By how much the means of signals (k, N) differ between the last three windows of a tenth each, at most."""
    n = max(1, signals.shape[1] // 10)
    return float(np.ptp(_last_means(signals, n), axis=0).max())


def _last_means(signals: np.ndarray, n: int) -> np.ndarray:
    """The means (3, k) over the last three windows of n samples of signals (k, N)."""
    return np.array([signals[:, -(k + 1) * n : signals.shape[1] - k * n].mean(axis=1) for k in (2, 1, 0)])


@dataclass(frozen=True)
class Modulation:
    """A periodic modulation: period in time and in angle, range of the signal over the last period, and where the last whole
    periods begin and end (indices). sustained: it neither grows nor decays any more."""

    period: float
    period_angle: float
    low: float
    high: float
    begin: int
    end: int
    sustained: bool


def modulation(time: np.ndarray, angle: np.ndarray, signal: np.ndarray, threshold: float) -> Modulation | None:
    """The modulation in the last half of a signal, None if its range is below the threshold or there are not three periods.

    time, angle, signal: (N,). Periods are counted between upward crossings of the middle, with hysteresis.
    """
    half = len(signal) // 2
    t, a, s = time[half:], angle[half:], signal[half:]
    if len(s) < 8 or np.ptp(s[len(s) // 2 :]) < threshold:
        return None
    tail = s[len(s) // 2 :]
    middle, reach = (tail.max() + tail.min()) / 2, 0.25 * np.ptp(tail)
    crossings = _upward_crossings(s - middle, reach)
    if len(crossings) < 4:
        return None
    fraction = (middle - s[crossings]) / (s[crossings + 1] - s[crossings])
    periods, turned = (np.diff(x[crossings] + fraction * (x[crossings + 1] - x[crossings])) for x in (t, a))
    ranges = np.array([np.ptp(s[j : k + 1]) for j, k in itertools.pairwise(crossings)])
    last = slice(crossings[-2], crossings[-1] + 1)
    count = min(3, len(periods))
    even = abs(periods[-1] - periods[-2]) <= 0.05 * periods[-1]
    return Modulation(
        period=float(periods[-count:].mean()),
        period_angle=float(abs(turned[-count:].mean())),
        low=float(s[last].min()),
        high=float(s[last].max()),
        begin=half + int(crossings[-1 - count]),
        end=half + int(crossings[-1]) + 1,
        sustained=bool(even and _holds(ranges)),
    )


def _upward_crossings(s: np.ndarray, reach: float) -> np.ndarray:
    """Indices i with s[i] < 0 <= s[i + 1], one for each rise from below -reach to above reach."""
    side = np.sign(s) * (np.abs(s) > reach)
    outside = np.flatnonzero(side)
    rising = (side[outside[:-1]] < 0) & (side[outside[1:]] > 0)
    crossings = np.flatnonzero((s[:-1] < 0) & (s[1:] >= 0))
    last = np.searchsorted(crossings, outside[1:][rising]) - 1
    return np.asarray(crossings[last])


def _holds(ranges: np.ndarray) -> bool:
    """Whether the range of successive periods tends to something other than zero, and is nearly there."""
    last, previous, before = ranges[-1], ranges[-2], ranges[-3]
    first, second = previous - before, last - previous
    if abs(second) <= 1e-3 * last:
        return True
    ratio = second / first if first else math.inf
    if abs(ratio) >= 0.95:
        return False
    limit = last + second * ratio / (1 - ratio)
    return bool(limit > 0.5 * last and abs(limit - last) <= 0.05 * limit)
