"""A modulated speed: its period, its range, and whether it lasts."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from wucht.numerics.observers.turn_record import Blocks, TurnRecord
from wucht.numerics.observers.trend import LOOKAHEAD, Trend, trend_of

FEWEST_CYCLES = 3
_FEWEST_IRREGULAR = 12
_SHARE = 0.5  # of the record, in which cycles are looked for
_RESOLVED = 8  # blocks a cycle, at least
_LAST = 3  # cycles, of which the period and the window are
_WINDOWS = 5  # of the range
_TENTH = 0.1  # of the record: such a window, if it has two cycles
_LASTING = 0.1  # of the range: a modulation lasts that is going to change by no more than that
_ROUNDING = 1e-3  # of the range: the extremes of sampled cycles are not known better
_EVEN = 0.05  # of a period: cycles that differ by more are irregular


@dataclass(frozen=True)
class Modulation:
    """A modulation of the speed.

    period, period_angle: of the last cycles, in time and in angle. low, high: the range over the last cycle; over all that are
    seen where they are irregular. window: the last cycles. cycles: how many are seen. regular: whether the last ones take the
    same time. trend: of the range, as a share of it. rate: by which the range grows, the logarithm of it over time.
    """

    period: float
    period_angle: float
    low: float
    high: float
    window: Blocks
    cycles: int
    regular: bool
    trend: Trend
    rate: float

    @property
    def range(self) -> float:
        """Of the speed."""
        return self.high - self.low

    @property
    def sustained(self) -> bool:
        """Whether it neither dies out nor grows."""
        return self.trend.steady(_LASTING) and self.cycles >= (FEWEST_CYCLES if self.regular else _FEWEST_IRREGULAR)


def modulation(record: TurnRecord, threshold: float) -> Modulation | None:
    """The modulation in the last half of a record, None if its range is below the threshold or there are too few cycles.

    Cycles are counted between upward crossings of the middle, with hysteresis; where the record is long against them, in the
    last part of it, which is known in more detail.
    """
    late = record.last(_SHARE / 2)
    if not len(late) or late.highest.max() - late.lowest.min() < threshold:
        return None
    share = _SHARE
    while True:
        part = record.last(share)
        crossings = _upward_crossings(part)
        resolved = part.size == 1 or (len(crossings) > 1 and np.diff(crossings).min() >= _RESOLVED)
        if len(crossings) > FEWEST_CYCLES and resolved:
            return _of_cycles(record, part, crossings)
        if part.size == 1:
            return None
        share /= 2


def _of_cycles(record: TurnRecord, part: Blocks, crossings: np.ndarray) -> Modulation:
    """The modulation with cycles between those blocks of a part of the record."""
    i = crossings.astype(int)
    periods, turned = (np.diff(np.interp(crossings, np.arange(len(part)), x)) for x in (part.time, part.angle))
    regular = bool(abs(periods[-1] - periods[-2]) <= _EVEN * periods[-1])
    count = min(_LAST, len(periods)) if regular else len(periods)
    window, last = part.part(slice(i[-1 - count], i[-1] + 1)), part.part(slice(i[-2] if regular else i[0], i[-1] + 1))
    low, high, period = float(last.lowest.min()), float(last.highest.max()), float(periods[-count:].mean())
    each = np.array([(part.lowest[j : k + 1].min(), part.highest[j : k + 1].max()) for j, k in itertools.pairwise(i)])
    ranges, span = _ranges(record, part, each, period)
    duration = float(record.whole.time[-1] - record.whole.time[0])
    heading = trend_of(ranges / (high - low), _LASTING, LOOKAHEAD * duration / span, _ROUNDING, _LASTING / 2)
    first, final = ranges[0, 1] - ranges[0, 0], ranges[-1, 1] - ranges[-1, 0]
    rate = math.log(final / first) / ((len(ranges) - 1) * span) if first > 0 and final > 0 else 0.0
    angle = float(np.abs(turned[-count:].mean()))
    return Modulation(period, angle, low, high, window, len(periods), regular, heading, rate)


def _ranges(record: TurnRecord, part: Blocks, each: np.ndarray, period: float) -> tuple[np.ndarray, float]:
    """Least and greatest speed (w, 2) in successive windows, and the time between these: tenths of the record or some cycles."""
    whole = record.whole
    n = int(_TENTH * len(whole))
    tenth = float(whole.time[-1] - whole.time[0]) * _TENTH
    if n and 2 * period <= tenth:
        low, high = (x[len(whole) - _WINDOWS * n :].reshape(_WINDOWS, n) for x in (whole.lowest, whole.highest))
        return np.array([low.min(axis=1), high.max(axis=1)]).T, tenth
    groups = np.array_split(each, min(_WINDOWS, len(each)))
    return np.array([g.mean(axis=0) for g in groups]), period * len(each) / len(groups)


def _upward_crossings(part: Blocks) -> np.ndarray:
    """Where the speed rises through the middle of its range (k,), in blocks from the first: once from far below to far above."""
    late = part.last(0.5)
    low, high = float(late.speed.min()), float(late.speed.max())
    s, reach = part.speed - (low + high) / 2, 0.25 * (high - low)
    side = np.sign(s) * (np.abs(s) > reach)
    outside = np.flatnonzero(side)
    rising = (side[outside[:-1]] < 0) & (side[outside[1:]] > 0)
    crossings = np.flatnonzero((s[:-1] < 0) & (s[1:] >= 0))
    i = crossings[np.searchsorted(crossings, outside[1:][rising]) - 1] if rising.any() else crossings[:0]
    return np.asarray(i + s[i] / (s[i] - s[i + 1]))
