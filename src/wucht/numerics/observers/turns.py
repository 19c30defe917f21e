"""From the samples of a motion to its averages over turns of a leading angle, without the ripple within a turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Self

import numpy as np

from wucht.numerics.zeros_and_peaks import interval_maxima

_MOST_STEPS = 60  # of Newton's method, which doubles the digits at each; bisection where the speed vanishes
_DIGITS = 1e-14
MARKS_PER_TURN = 8  # a power of two, so that sums over a turn are made by doubling, the same whatever the parts
_STEP = 2 * math.pi / MARKS_PER_TURN
_ROUNDING = 1e-9  # of a step: a sample so near before a mark is at it


def interpolate(share: np.ndarray, x: np.ndarray, y: np.ndarray, slope: np.ndarray, i: np.ndarray) -> np.ndarray:
    """Interpolate y (..., N) of x (N,) by its derivative, at shares (K,) of the way from samples i to the next: (..., K)."""
    h, first_value = x[i + 1] - x[i], y.take(i, axis=-1)
    rise = y.take(i + 1, axis=-1) - first_value
    before, after = h * slope.take(i, axis=-1) - rise, rise - h * slope.take(i + 1, axis=-1)
    return np.asarray(first_value + share * (rise + (1 - share) * ((1 - share) * before + share * after)))


def shares_at_values(values: np.ndarray, x: np.ndarray, y: np.ndarray, slope: np.ndarray, i: np.ndarray) -> np.ndarray:
    """Return the shares (K,) of the way from samples i to the next at which y has values (K,) between its samples."""
    h, first_value = x[i + 1] - x[i], y[i]
    rise, first, last = y[i + 1] - first_value, h * slope[i], h * slope[i + 1]
    target, cubic, square = values - first_value, first + last - 2 * rise, 3 * rise - 2 * first - last
    low, high = np.zeros(len(i)), np.ones(len(i))
    s = np.divide(target, rise, out=np.zeros(len(i)), where=rise != 0)
    for _ in range(_MOST_STEPS):
        off = s * (first + s * (square + s * cubic)) - target
        has_converged = np.abs(off) <= _DIGITS * np.abs(rise)  # then it stays, however many steps the others need
        if has_converged.all():
            break
        short = off * rise < 0
        low, high = np.where(short, s, low), np.where(short, high, s)
        with np.errstate(all="ignore"):
            step = s - off / (first + s * (2 * square + 3 * s * cubic))
        s = np.where(has_converged, s, np.where((step >= low) & (step <= high), step, (low + high) / 2))
    return np.asarray(s)


@dataclass(frozen=True)
class Samples:
    """A part of a motion.

    time: (N,), increasing. angles, speeds: of the leading body and n followers (1 + n, N). square, rate: of a distance, its
    square and the derivative of that (N,); zero if not needed. moments: increments of the weights of the bodies, the leading
    one first (1 + n, N); no rows where the weights do not change.
    """

    time: np.ndarray
    angles: np.ndarray
    speeds: np.ndarray
    square: np.ndarray
    rate: np.ndarray
    moments: np.ndarray

    @classmethod
    def of(cls, time: np.ndarray, *motions: tuple[np.ndarray, np.ndarray]) -> Self:
        """Combine angle and speed (N,) of the leading body and of the others."""
        zeros = np.zeros(len(time))
        angles, speeds = (np.array([motion[k] for motion in motions]) for k in (0, 1))
        return cls(time, angles, speeds, zeros, zeros, np.empty((0, len(time))))

    def relative_to(self, body: int) -> Self:
        """Return the samples with this body leading and the others in their order."""
        order = [body, *(i for i in range(len(self.angles)) if i != body)]
        moments = self.moments[order] if len(self.moments) else self.moments
        return self if body == 0 else replace(self, angles=self.angles[order], speeds=self.speeds[order], moments=moments)

    def only_body(self, body: int) -> Self:
        """Return the samples of one body alone."""
        one = slice(body, body + 1)
        return replace(self, angles=self.angles[one], speeds=self.speeds[one], moments=self.moments[one])

    def with_reference(self, angle: np.ndarray, speed: np.ndarray) -> Self:
        """Put a leading motion (N,) without weight first."""
        moments = np.vstack([np.zeros_like(angle), self.moments]) if len(self.moments) else self.moments
        return replace(self, angles=np.vstack([angle, self.angles]), speeds=np.vstack([speed, self.speeds]), moments=moments)

    def with_leading(self, angle: np.ndarray, speed: np.ndarray) -> Self:
        """Replace the motion (N,) of the leading body."""
        return replace(self, angles=np.vstack([angle, self.angles[1:]]), speeds=np.vstack([speed, self.speeds[1:]]))

    def part(self, selection: slice | np.ndarray) -> Self:
        """Return a selection of the samples."""
        return replace(self, **{name: values[..., selection] for name, values in vars(self).items()})

    def with_previous(self, before: Samples | None) -> Self:
        """Prepend previous samples; a common one counts once."""
        if before is None or not len(before.time):
            return self
        new = self.part(slice(int(np.searchsorted(self.time, before.time[-1], side="right")), None))
        joined_arrays = {name: np.concatenate([getattr(before, name), values], axis=-1) for name, values in vars(new).items()}
        return replace(self, **joined_arrays)


@dataclass(frozen=True)
class Turns:
    """Averages over one turn each, ``MARKS_PER_TURN`` of them a turn, at fixed angles of the leading body.

    time, angle, angles: at the end of each turn, (K,), of the leading body (K,) and the followers (n, K). speed: the mean of
    the leading one, 2 pi over the time of the turn, with its sign. advance: of the followers in that time (n, K).
    moments: averaged over the turn's angle (1 + n, K), or no rows.
    phases: exp(i (follower - leader)) averaged over the turn's angle (n, K), of modulus 1 for a body that turns synchronously.
    largest: the distance (K,). passage: the number of reversals of the leading body before (K,).
    """

    time: np.ndarray
    angle: np.ndarray
    angles: np.ndarray
    speed: np.ndarray
    advance: np.ndarray
    phases: np.ndarray
    largest: np.ndarray
    passage: np.ndarray
    moments: np.ndarray

    @classmethod
    def empty(cls, follower_count: int, weights: int = 0) -> Self:
        """Return no turns. weights: the number of those that change."""
        one, many = np.empty(0), np.empty((follower_count, 0))
        return cls(one, one, many, one, many, many.astype(complex), one, one.astype(int), np.empty((weights, 0)))

    @classmethod
    def join(cls, *parts: Turns) -> Self:
        """Concatenate turns."""
        return cls(*(np.concatenate([getattr(p, name) for p in parts], axis=-1) for name in vars(parts[0])))

    def part(self, selection: slice | np.ndarray) -> Self:
        """Return a selection of the turns."""
        return replace(self, **{name: values[..., selection] for name, values in vars(self).items()})

    @property
    def middle(self) -> np.ndarray:
        """Time in the middle of each turn (K,)."""
        return np.asarray(self.time - math.pi / np.abs(self.speed))

    @property
    def count(self) -> float:
        """Number of turns."""
        return len(self.time) / MARKS_PER_TURN


@dataclass(frozen=True)
class LargestTurn:
    """The turn in whose middle the largest distance of a motion lies.

    distance: the largest within a whole turn so far. speed: the mean of the leading body over that turn, with its sign; NaN
    before the first whole turn. later: the number of turns since the first one that has it, up to half of those that have it.
    """

    distance: float = 0.0
    speed: float = math.nan
    later: int = 0

    def update(self, turns: Turns) -> LargestTurn:
        """Return it after further turns."""
        if not len(turns.time):
            return self
        first, last, rest = int(turns.largest.argmax()), self, turns
        if turns.largest[first] > self.distance:
            last = LargestTurn(float(turns.largest[first]), float(turns.speed[first]))
            rest = turns.part(slice(first + 1, None))
        # Turns begin at each mark: of those that have the distance, the first has it at its end, the middle one in its middle.
        following = rest.part(slice(0, MARKS_PER_TURN // 2 - last.later))
        count = int(np.append(following.largest != last.distance, True).argmax())
        later = last.later + count if count == len(following.time) else MARKS_PER_TURN // 2
        return LargestTurn(last.distance, float(following.speed[count - 1]) if count else last.speed, later)


@dataclass(frozen=True)
class _Marks:
    """Marks at which the leading angle reaches a multiple of an eighth of a turn: the last ones, at each a turn begins.

    time (K,), angles of the followers (n, K), the square of the largest distance since the previous mark (K,), and moments.
    """

    time: np.ndarray
    angles: np.ndarray
    square: np.ndarray
    moments: np.ndarray

    def join(self, later: _Marks) -> _Marks:
        """Append later marks."""
        return _Marks(
            *(np.concatenate([a, b], axis=-1) for a, b in zip(vars(self).values(), vars(later).values(), strict=True))
        )

    def last(self, count: int) -> _Marks:
        """Return the last marks."""
        return _Marks(*(values[..., max(values.shape[-1] - count, 0) :] for values in vars(self).values()))


@dataclass(frozen=True)
class TurnObserver:
    """State of the averaging of a motion over turns.

    sample: the last one. marks: the last turn's. mark: the number of the last one, in the sense of turning. sense: +1, -1, or 0
    before the first rotation. passage: the number of reversals of the leading body. square: of the largest distance since the
    last mark.
    """

    sample: Samples | None = None
    marks: _Marks = field(default_factory=lambda: _no_marks(0, 0))
    mark: int = 0
    sense: int = 0
    passage: int = 0
    square: float = 0.0

    def update(self, samples: Samples) -> tuple[TurnObserver, Turns]:
        """Update the state by a part of the motion; return also the turns that were completed in it.

        The part may begin with the last sample of the previous part.
        """
        all_samples, counts = samples.with_previous(self.sample), (len(samples.angles) - 1, len(samples.moments))
        if len(all_samples.time) < 2:
            return replace(self, sample=all_samples if len(all_samples.time) else None), Turns.empty(*counts)
        senses = np.sign(np.diff(all_samples.angles[0])).astype(int)
        turning = np.flatnonzero(senses)
        if not len(turning):
            largest = float(interval_maxima(all_samples.time, all_samples.square, all_samples.rate).max())
            return replace(self, sample=all_samples.part(slice(-1, None)), square=max(self.square, largest)), Turns.empty(
                *counts
            )
        filled_senses = senses
        if len(turning) < len(senses):  # an interval in which nothing turns belongs to the stretch before it
            filled_senses = senses[turning[np.maximum(np.searchsorted(turning, np.arange(len(senses)), side="right") - 1, 0)]]
            filled_senses[: turning[0]] = self.sense or filled_senses[0]
        ends = [0, *(np.flatnonzero(np.diff(filled_senses)) + 1).tolist(), len(senses)]
        turn_angles = np.abs(np.diff(all_samples.angles[0, ends]))
        observer, turn_parts = self, [Turns.empty(*counts)]
        for k, (first, last) in enumerate(pairwise(ends)):
            sense = int(filled_senses[first])
            if sense != observer.sense:
                back = int(observer.sense != 0)
                observer = TurnObserver(marks=_no_marks(*counts), sense=sense, passage=observer.passage + back)
                observer = replace(observer, mark=int(_marks(sense * all_samples.angles[0, first])))
            if k in (0, len(turn_angles) - 1) or turn_angles[k] > 2 * math.pi:
                observer, turns = observer._advance(all_samples.part(slice(first, last + 1)))
                turn_parts.append(turns)
        return replace(observer, sample=all_samples.part(slice(-1, None))), Turns.join(*turn_parts)

    def _advance(self, s: Samples) -> tuple[TurnObserver, Turns]:
        """Advance by samples between which the leading body turns one way."""
        leader = self.sense * s.angles[0]
        mark_numbers = np.maximum(_marks(leader), self.mark)
        last = int(mark_numbers[-1])
        numbers = np.arange(self.mark + 1, last + 1)
        squares = interval_maxima(s.time, s.square, s.rate)
        if not len(numbers):
            return replace(self, square=max(self.square, float(squares.max()))), Turns.empty(len(s.angles) - 1, len(s.moments))
        i = np.repeat(np.arange(len(leader) - 1), np.diff(mark_numbers))
        share = shares_at_values(numbers * _STEP, s.time, leader, self.sense * s.speeds[0], i)
        time, angles = (
            s.time[i] + share * (s.time[i + 1] - s.time[i]),
            interpolate(share, s.time, s.angles[1:], s.speeds[1:], i),
        )
        begin = np.append(0, i[:-1])
        largest = np.maximum(np.maximum.reduceat(squares[: i[-1] + 1], begin), squares[i])
        largest[0] = max(largest[0], self.square)
        moments = s.moments[:, i] + share * (s.moments[:, i + 1] - s.moments[:, i])
        marks = self.marks.join(_Marks(time, angles, largest, moments))
        observer = replace(self, marks=marks.last(MARKS_PER_TURN), mark=last, square=float(squares[i[-1] :].max()))
        return observer, self._average(marks, last)

    def _average(self, marks: _Marks, last: int) -> Turns:
        """Return the averages over the turns between marks. last: the number of the last mark."""
        count = len(marks.time) - MARKS_PER_TURN
        if count < 1:
            return Turns.empty(len(marks.angles), len(marks.moments))
        begin, end = marks.time[:-MARKS_PER_TURN], marks.time[MARKS_PER_TURN:]
        leading = self.sense * _STEP * (last - len(marks.time) + 1 + np.arange(len(marks.time)))
        return Turns(
            time=end,
            angle=leading[MARKS_PER_TURN:],
            angles=marks.angles[:, MARKS_PER_TURN:],
            speed=self.sense * 2 * math.pi / (end - begin),
            advance=marks.angles[:, MARKS_PER_TURN:] - marks.angles[:, :-MARKS_PER_TURN],
            phases=_turn_means(np.exp(1j * (marks.angles - leading))),
            largest=np.sqrt(_turn_maxima(marks.square[1:])),
            passage=np.full(count, self.passage),
            moments=_turn_means(marks.moments),
        )


def _marks(angles: np.ndarray) -> np.ndarray:
    """Return the number of the last mark up to each angle."""
    return np.floor(angles / _STEP + _ROUNDING).astype(int)


def _no_marks(follower_count: int, weights: int) -> _Marks:
    return _Marks(np.empty(0), np.empty((follower_count, 0)), np.empty(0), np.empty((weights, 0)))


def _turn_means(signal: np.ndarray) -> np.ndarray:
    """Return the means (..., K) over each turn of a signal (..., K + MARKS_PER_TURN) at its marks, end points counting half."""
    total, width = signal, 1
    while width < MARKS_PER_TURN:
        total, width = total[..., :-width] + total[..., width:], 2 * width
    return np.asarray((total[..., :-1] + (signal[..., MARKS_PER_TURN:] - signal[..., :-MARKS_PER_TURN]) / 2) / MARKS_PER_TURN)


def _turn_maxima(signal: np.ndarray) -> np.ndarray:
    """Return the largest (K,) of each MARKS_PER_TURN neighbours (K + MARKS_PER_TURN - 1,)."""
    largest, width = signal, 1
    while width < MARKS_PER_TURN:
        largest, width = np.maximum(largest[:-width], largest[width:]), 2 * width
    return largest
