"""The motion of one body in equal spans of time, in bounded memory: for one that swings or stops, and makes no turns."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from wucht.numerics.observers.pyramid import HIGH, LAST, LOW, Pyramid
from wucht.numerics.observers.turns import Samples
from wucht.numerics.peaks import between_samples

_PER_SPAN = 12  # samples are enough: more are left out
_KINDS = (LAST, LAST, LOW, HIGH, LOW, HIGH, LOW, HIGH)
_EXTREMES = {LOW: np.minimum, HIGH: np.maximum}


@dataclass(frozen=True)
class Spans:
    """K spans of time: time and angle (K,) at their ends, the least and the greatest angle, speed and distance within
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
    """span: how long one is; motions are to be sampled several times in it. sample: the last one. open: the span that is not
    yet over, (8, 1)."""

    span: float
    sample: Samples | None = None
    open: np.ndarray = field(default_factory=lambda: np.empty((len(_KINDS), 0)))
    kept: Pyramid = field(default_factory=lambda: Pyramid(_KINDS))

    def after(self, samples: Samples) -> SpanRecord:
        """The record after a part of the motion, which may begin with the last sample of the part before."""
        s = _sparse(samples.after(self.sample), self.span / _PER_SPAN)
        if len(s.time) < 2:
            return replace(self, sample=s if len(s.time) else None)
        angle, speed, end = s.angles[0], s.speeds[0], s.time[1:]
        columns = np.array([
            end, angle[1:], -between_samples(s.time, -angle, -speed), between_samples(s.time, angle, speed),
            np.minimum(speed[:-1], speed[1:]), np.maximum(speed[:-1], speed[1:]),
            _root(-between_samples(s.time, -s.square, -s.rate)), _root(between_samples(s.time, s.square, s.rate)),
        ])  # fmt: skip
        columns = np.concatenate([self.open, columns], axis=1)
        number = np.ceil(columns[0] / self.span)
        first = np.append(0, np.flatnonzero(np.diff(number)) + 1)
        last = np.append(first[1:], columns.shape[1]) - 1
        blocks = columns[:, last]
        for row, kind in enumerate(_KINDS):
            if kind in _EXTREMES:
                blocks[row] = _EXTREMES[kind].reduceat(columns[row], first)
        return replace(self, sample=s.part(slice(-1, None)), open=blocks[:, -1:], kept=self.kept.after(blocks[:, :-1]))

    def last(self, share: float) -> Spans:
        """The last share of the time, in the shortest spans that reach back so far, with the one that is not yet over."""
        values, _ = self.kept.last(share)
        return Spans(*np.concatenate([values, self.open], axis=1))


def _root(square: np.ndarray) -> np.ndarray:
    """The root of a square, which may be negative by rounding."""
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def _sparse(s: Samples, every: float) -> Samples:
    """The first sample in each of such spans of time."""
    number = np.floor(s.time / every)
    first = np.append(0, np.flatnonzero(number[1:] != number[:-1]) + 1)
    return s if len(first) >= len(number) else s.part(first)
