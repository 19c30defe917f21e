"""A modulated speed: its period, its range, and whether it lasts."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from wucht.numerics.observers.records import Blocks, TurnRecord

FEWEST_CYCLES = 3
_SHARES = (
    0.5,
    0.8,
    *(0.5**k for k in range(2, 40)),
)  # parts of the record in which cycles are searched: slow ones, then fast ones
_BLOCKS_PER_CYCLE = 8  # blocks a cycle, at least
_WITHIN = 0.5  # largest range of the speed within a block, relative to the whole range
_LAST = 3  # cycles, over which the period and the window are taken
_GROUPS = 5  # of cycles, at most
_EVEN = 0.05  # of a period: cycles that differ by more are irregular


@dataclass(frozen=True)
class Modulation:
    """A modulation of the speed.

    period, period_angle: of the last cycles, in time and in angle. low, high: the range over the last cycle; over all counted
    cycles where they are irregular. window: the last cycles. cycles: their number. regular: true if the last ones take the
    same time. groups: mean, least and greatest speed (3, g), each the mean over equally many successive cycles; borders: the
    times (g + 1,) between these.
    """

    period: float
    period_angle: float
    low: float
    high: float
    window: Blocks
    cycles: int
    regular: bool
    groups: np.ndarray
    borders: np.ndarray

    @property
    def span(self) -> float:
        """Mean duration of a group."""
        return float(self.borders[-1] - self.borders[0]) / (len(self.borders) - 1)


def modulation(record: TurnRecord, threshold: float) -> Modulation | None:
    """Return the modulation in the last part of a record, None if its range is below the threshold or cycles are too few.

    Cycles are counted between upward crossings of the middle, with hysteresis: in the last half of the record, if there are too
    few in the last four fifths, and where the record is long against them in its last part, stored in more detail.
    """
    late = record.last(_SHARES[0] / 2)
    if not len(late) or late.highest.max() - late.lowest.min() < threshold:
        return None
    for share in _SHARES:
        part = record.last(share)
        crossings = _upward_crossings(part)
        if len(crossings) > FEWEST_CYCLES and _is_resolved(part, crossings):
            return _modulation_from_cycles(part, crossings)
        if part.size == 1 and share < _SHARES[0]:
            return None
    return None


def _is_resolved(part: Blocks, crossings: np.ndarray) -> bool:
    """True if blocks are short against the cycles: else their means would beat."""
    within, range_ = part.highest - part.lowest, part.highest.max() - part.lowest.min()
    return part.size == 1 or bool(np.diff(crossings).min() >= _BLOCKS_PER_CYCLE and np.median(within) < _WITHIN * range_)


def _modulation_from_cycles(part: Blocks, crossings: np.ndarray) -> Modulation:
    """Compute the modulation with cycles between these crossings, in blocks of a part of the record."""
    i = crossings.astype(int)
    periods, turn_angles = (np.diff(np.interp(crossings, np.arange(len(part)), x)) for x in (part.time, part.angle))
    regular = bool(np.ptp(periods[-_LAST:]) <= _EVEN * periods[-1])
    count = min(_LAST, len(periods)) if regular else len(periods)
    window, last = part.part(slice(i[-1 - count], i[-1] + 1)), part.part(slice(i[-2] if regular else i[0], i[-1] + 1))
    bounds = [(part.lowest[j : k + 1].min(), part.highest[j : k + 1].max()) for j, k in itertools.pairwise(i)]
    cycle_values = np.array([np.abs(turn_angles) / periods, *np.transpose(bounds)])
    size = -(-len(periods) // _GROUPS)
    skip_count = len(periods) % size
    groups = cycle_values[:, skip_count:].reshape(3, -1, size).mean(axis=2)
    borders = np.interp(crossings[skip_count::size], np.arange(len(part)), part.time)
    period, angle = float(periods[-count:].mean()), float(np.abs(turn_angles[-count:].mean()))
    low, high = float(last.lowest.min()), float(last.highest.max())
    return Modulation(period, angle, low, high, window, len(periods), regular, groups, borders)


def _upward_crossings(part: Blocks) -> np.ndarray:
    """Return the places (k,), in blocks, where the speed rises through the middle of its range, from far below to far above."""
    late = part.last(0.5)
    low, high = float(late.speed.min()), float(late.speed.max())
    s, reach = part.speed - (low + high) / 2, 0.25 * (high - low)
    side = np.sign(s) * (np.abs(s) > reach)
    outside = np.flatnonzero(side)
    rising = (side[outside[:-1]] < 0) & (side[outside[1:]] > 0)
    crossings = np.flatnonzero((s[:-1] < 0) & (s[1:] >= 0))
    i = crossings[np.searchsorted(crossings, outside[1:][rising]) - 1] if rising.any() else crossings[:0]
    return np.asarray(i + s[i] / (s[i] - s[i + 1]))
