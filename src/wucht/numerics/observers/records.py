"""Records of a motion of any length in bounded memory: its turns, or equal spans of time where it makes none.

The last blocks are stored as they are, and ever longer ones further back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wucht.numerics.observers.turns import MARKS_PER_TURN, LargestTurn, Samples, TurnObserver
from wucht.numerics.zeros_and_peaks import interval_maxima

FINAL_SHARE = 0.05  # of the turns: the final window, over which the numbers of a summary are taken
LEVEL_BLOCKS = 4096  # blocks of each length
LAST, LOW, HIGH, MEAN = range(4)  # how two neighbouring blocks are merged
_PER_SPAN = 12  # samples are enough: more are left out
_KINDS = (LAST, LAST, LOW, HIGH, LOW, HIGH, LOW, HIGH)
_EXTREMES = {LOW: np.minimum, HIGH: np.maximum}
_ROUNDING = 1e-9  # of a turn, or of a span


@dataclass(frozen=True)
class Pyramid:
    """Record of blocks at several resolutions. kinds: of each row of a block. count: of blocks so far. levels: the last
    ``LEVEL_BLOCKS`` blocks of 1, 2, 4, ... merged, each a column; the last level reaches back to the beginning. Two records of
    the same blocks are the same to the last bit, whatever the parts in which they were added."""

    kinds: tuple[int, ...]
    count: int = 0
    levels: tuple[np.ndarray, ...] = ()

    def update(self, blocks: np.ndarray) -> Pyramid:
        """Return the record with more blocks (rows, K)."""
        if not blocks.shape[1]:
            return self
        return Pyramid(self.kinds, self.count + blocks.shape[1], _levels(self.levels, blocks, self.count, self.kinds))

    def last(self, share: float) -> tuple[np.ndarray, int]:
        """Return the last share of the record in the finest blocks that reach back so far, and the number merged in each."""
        if not self.levels:
            return np.empty((len(self.kinds), 0)), 1
        block_count, top = share * self.count, len(self.levels) - 1
        k = next((k for k, level in enumerate(self.levels) if level.shape[1] * 2**k >= block_count), top)
        return self.levels[k][:, -max(1, round(block_count / 2**k)) :], 2**k


def _levels(before: tuple[np.ndarray, ...], blocks: np.ndarray, count: int, kinds: Sequence[int]) -> tuple[np.ndarray, ...]:
    """Return the levels with more blocks of the first one, which had ``count`` before."""
    level = np.concatenate([before[0], blocks], axis=1) if before else blocks
    total = count + blocks.shape[1]
    if total <= LEVEL_BLOCKS:
        return (level,)
    # The next level stays empty as long as this one has all blocks.
    pair_count = count // 2 if len(before) > 1 else 0
    new = level[:, 2 * pair_count - total + level.shape[1] : level.shape[1] - total % 2]
    return level[:, -LEVEL_BLOCKS:], *_levels(before[1:], _merge_pairs(new, kinds), pair_count, kinds)


def _merge_pairs(blocks: np.ndarray, kinds: Sequence[int]) -> np.ndarray:
    """Merge each two neighbouring blocks."""
    first, second, merged_blocks = blocks[:, ::2], blocks[:, 1::2], blocks[:, 1::2].copy()
    for kind, merge in ((LOW, np.minimum), (HIGH, np.maximum), (MEAN, _mean)):
        rows = [row for row, k in enumerate(kinds) if k == kind]
        merged_blocks[rows] = merge(first[rows], second[rows])
    return merged_blocks


def _mean(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.asarray((first + second) / 2)


@dataclass(frozen=True)
class Spans:
    """Record over K spans of time: time and angle (K,) at their ends, least and greatest angle, speed and distance within
    them."""

    time: np.ndarray
    angle: np.ndarray
    least_angle: np.ndarray
    greatest_angle: np.ndarray
    least_speed: np.ndarray
    greatest_speed: np.ndarray
    least_distance: np.ndarray
    greatest_distance: np.ndarray


@dataclass(frozen=True)
class SpanRecord:
    """Record of a motion over equal spans of time. span: the length of one; motions must be sampled several times in it.
    sample: the last one. open: the span that is not yet complete, (8, 1)."""

    span: float
    sample: Samples | None = None
    open: np.ndarray = field(default_factory=lambda: np.empty((len(_KINDS), 0)))
    pyramid: Pyramid = field(default_factory=lambda: Pyramid(_KINDS))

    def update(self, samples: Samples) -> SpanRecord:
        """The record after a part of the motion, which may begin with the last sample of the part before."""
        s = _sparse(samples.with_previous(self.sample), self.span / _PER_SPAN)
        if len(s.time) < 2:
            return replace(self, sample=s if len(s.time) else None)
        angle, speed, end = s.angles[0], s.speeds[0], s.time[1:]
        columns = np.array([
            end, angle[1:], -interval_maxima(s.time, -angle, -speed), interval_maxima(s.time, angle, speed),
            np.minimum(speed[:-1], speed[1:]), np.maximum(speed[:-1], speed[1:]),
            _root(-interval_maxima(s.time, -s.square, -s.rate)), _root(interval_maxima(s.time, s.square, s.rate)),
        ])  # fmt: skip
        columns = np.concatenate([self.open, columns], axis=1)
        number = np.ceil(columns[0] / self.span - _ROUNDING)  # samples at the ends of spans belong to those that end there
        first = np.append(0, np.flatnonzero(np.diff(number)) + 1)
        last = np.append(first[1:], columns.shape[1]) - 1
        blocks = columns[:, last]
        for row, kind in enumerate(_KINDS):
            if kind in _EXTREMES:
                blocks[row] = _EXTREMES[kind].reduceat(columns[row], first)
        return replace(self, sample=s.part(slice(-1, None)), open=blocks[:, -1:], pyramid=self.pyramid.update(blocks[:, :-1]))

    def last(self, share: float) -> Spans:
        """Return the last share of the time, in the shortest spans that reach back so far, with the incomplete one."""
        values, _ = self.pyramid.last(share)
        return Spans(*np.concatenate([values, self.open], axis=1))


def _root(square: np.ndarray) -> np.ndarray:
    """Return the root of a square, which may be negative by rounding."""
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def _sparse(s: Samples, every: float) -> Samples:
    """Return the first sample in each span of time of this length."""
    number = np.floor(s.time / every + _ROUNDING)
    first = np.append(0, np.flatnonzero(number[1:] != number[:-1]) + 1)
    return s if len(first) >= len(number) else s.part(first)


@dataclass(frozen=True)
class Blocks:
    """Averages over turns, merged in K blocks of equally many, of a leading body and n followers.

    Speeds are positive in the sense in which the leading body turns.

    size: the number of averages in a block. sense: +1 or -1. time, angle, angles (n, K): at the end of each block. speed: mean
    over time. lowest, highest: of the mean over a turn. followers: mean speeds of the followers (n, K). phases: means of
    exp(i (follower - leader)) (n, K). least_sum, greatest_sum: of the magnitude of the weighted sum of these. amplitude: the
    mean of the largest distance over a turn; least_amplitude, greatest_amplitude: of that.
    """

    size: int
    sense: int
    time: np.ndarray
    angle: np.ndarray
    angles: np.ndarray
    speed: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    followers: np.ndarray
    phases: np.ndarray
    least_sum: np.ndarray
    greatest_sum: np.ndarray
    amplitude: np.ndarray
    least_amplitude: np.ndarray
    greatest_amplitude: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    @property
    def turns(self) -> float:
        """Number of turns."""
        return len(self) * self.size / MARKS_PER_TURN

    @property
    def middle(self) -> np.ndarray:
        """Time in the middle of the last turn of each block (K,)."""
        return np.asarray(self.time - math.pi / self.speed)

    @property
    def amplitudes(self) -> tuple[float, float, float]:
        """Mean, least and greatest value of the largest distance over a turn."""
        return float(self.amplitude.mean()), float(self.least_amplitude.min()), float(self.greatest_amplitude.max())

    @property
    def mean_speeds(self) -> np.ndarray:
        """Mean speeds from the end of the first block to that of the last (1 + n,): of the leading body and the followers."""
        if len(self) < 2:
            return np.append(self.speed, self.followers)
        turn_angles = np.append(self.angle[-1] - self.angle[0], self.angles[:, -1] - self.angles[:, 0])
        return np.asarray(self.sense * turn_angles / (self.time[-1] - self.time[0]))

    @property
    def smooth_mean_speeds(self) -> np.ndarray:
        """Mean speeds (1 + n,), weighted against the bias of a modulation that is cut at the ends: ``smooth_weights``."""
        if len(self) < 3:
            return self.mean_speeds
        durations = smooth_weights(len(self)) / self.speed
        return np.asarray(np.append(self.speed @ durations, self.followers @ durations) / durations.sum())

    def part(self, selection: slice) -> Blocks:
        """Return a selection of the blocks."""
        arrays: dict[str, Any] = {name: x[..., selection] for name, x in vars(self).items() if isinstance(x, np.ndarray)}
        return replace(self, **arrays)

    def last(self, share: float) -> Blocks:
        """Return the last share of the blocks, at least one."""
        return self.part(slice(len(self) - max(1, round(share * len(self))), None))


def _resultant(weights: Sequence[complex], phases: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Return the magnitude (K,) of the weighted sum of 1 and phases (n, K), in real numbers: to the last bit independent of K.

    moments: real, added to the weights (1 + n, K), or no rows.
    """
    extra_weights = moments if len(moments) else np.zeros((len(weights), 1))
    real = np.zeros(phases.shape[1]) + (complex(weights[0]).real + extra_weights[0])
    imaginary = np.full(phases.shape[1], complex(weights[0]).imag)
    for weight, more, phase in zip(map(complex, weights[1:]), extra_weights[1:], phases, strict=True):
        real += (weight.real + more) * phase.real - weight.imag * phase.imag
        imaginary += (weight.real + more) * phase.imag + weight.imag * phase.real
    return np.asarray(np.sqrt(real * real + imaginary * imaginary))


def smooth_weights(count: int) -> np.ndarray:
    """Return weights (count,) of a mean over an oscillation that is cut at both ends.

    J. Laskar, Physica D 67 (1993) 257-281; S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111-4140.
    """
    share = (np.arange(count) + 0.5) / count
    return np.asarray(np.exp(-1 / (share * (1 - share))))


@dataclass(frozen=True)
class TurnRecord:
    """Record of a motion turn by turn: the turns since the leading body last reversed.

    follower_count: the number of other bodies. weights: of exp(i angle) of the leading body and the followers, relative to the
    leading one, in a sum that is recorded; none if it is not needed. largest_turn: of all turns, also before a reversal.
    """

    follower_count: int
    weights: tuple[complex, ...] = ()
    observer: TurnObserver = field(default_factory=TurnObserver)
    passage: int = 0
    sense: int = 1
    pyramid: Pyramid = field(default_factory=lambda: Pyramid(()))
    largest_turn: LargestTurn = field(default_factory=LargestTurn)

    def update(self, samples: Samples) -> TurnRecord:
        """The record after a part of the motion, which may begin with the last sample of the part before."""
        observer, turns = self.observer.update(samples)
        if not len(turns.time):
            return replace(self, observer=observer)
        passage, n = int(turns.passage[-1]), self.follower_count
        same = turns.passage == passage
        new = turns if same.all() else turns.part(same)
        speed, largest = np.abs(new.speed), new.largest
        # Averages are over equal parts of a turn: the mean speed over time follows from the turns' durations.
        means = [largest, 2 * math.pi / speed, *new.advance, *new.phases.real, *new.phases.imag]
        total = _resultant(self.weights or (0.0,) * (1 + n), new.phases, new.moments)
        columns = np.array([new.time, new.angle, *new.angles, speed, speed, largest, largest, total, total, *means])
        goes_on = passage == self.passage and self.pyramid.kinds
        kinds = (*(LAST,) * (2 + n), *(LOW, HIGH) * 3, *(MEAN,) * (2 + 3 * n))
        pyramid = self.pyramid if goes_on else Pyramid(kinds)
        sense, largest_turn = 1 if new.speed[-1] > 0 else -1, self.largest_turn.update(turns)
        return TurnRecord(n, self.weights, observer, passage, sense, pyramid.update(columns), largest_turn)

    @property
    def turns(self) -> float:
        """Number of averaged turns."""
        return self.pyramid.count / MARKS_PER_TURN

    @property
    def whole(self) -> Blocks:
        """All turns, in the finest blocks that reach back so far."""
        return self.last(1.0)

    def whole_turns(self, share: float) -> Blocks:
        """Return the last share of all turns: the end of the first block and that of the last are whole turns apart.

        With less than two turns it is the last average alone.
        """
        if not self.pyramid.count:
            return self.last(1.0)
        turn_count = (self.pyramid.count + MARKS_PER_TURN) / MARKS_PER_TURN  # the first average ends after a turn
        average_count = max(1, math.floor(share * turn_count + _ROUNDING)) * MARKS_PER_TURN  # averages
        blocks = self.last(min(1.0, (average_count + 1) / self.pyramid.count))
        blocks_per_turn = max(1, MARKS_PER_TURN // blocks.size)
        block_count = min(max(1, average_count // blocks.size), (len(blocks) - 1) // blocks_per_turn * blocks_per_turn)
        return blocks.part(slice(-1 - block_count, None))

    def final_turns(self, cycle: float = 1.0) -> Blocks:
        """Return the final window: the last twentieth of all turns, at least two, in whole cycles; at most half of the record.

        cycle: the number of turns after which the motion repeats.
        """
        least = max(FINAL_SHARE, 2 / self.turns)
        cycles = math.ceil(least * self.turns / cycle * (1 - _ROUNDING))
        return self.whole_turns(least if cycle == 1.0 else min(max(0.5, least), cycles * cycle / self.turns))

    def last(self, share: float) -> Blocks:
        """Return the last share of the turns, in the finest blocks that reach back so far."""
        values, size = self.pyramid.last(share)
        n, sense = self.follower_count, self.sense
        if not len(values):
            values = np.empty((10 + 4 * n, 0))
        time, angle, angles = values[0], values[1], values[2 : 2 + n]
        lowest, highest, least, greatest, least_sum, greatest_sum, amplitude, duration = values[2 + n : 10 + n]
        advance, real, imaginary = values[10 + n : 10 + 4 * n].reshape(3, n, values.shape[1])
        return Blocks(
            size,
            sense,
            time,
            angle,
            angles,
            speed=2 * math.pi / duration,
            lowest=lowest,
            highest=highest,
            followers=sense * advance / duration,
            phases=real + 1j * imaginary,
            least_sum=least_sum,
            greatest_sum=greatest_sum,
            amplitude=amplitude,
            least_amplitude=least,
            greatest_amplitude=greatest,
        )
