"""When the members of an ensemble are looked at: in chunks of time, each as long as all before it together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wucht.numerics.observers.projection import WINDOWS

WINDOW = 16  # samples
SAMPLES = WINDOW * WINDOWS  # in each chunk, twice as many in the first one: its halves are as those to come
PARTS = 2 * SAMPLES  # of the time, in which the course is kept
# Times as many of the amplitude in each part of the first chunk: vibrations of the start die out, resonances are passed.
FINER = np.repeat((4, 2), SAMPLES)
# Samples that are shifted a little, alike in all windows: a motion of one period can not be taken for rest.
_SHIFTS = np.append(0.5 * (np.arange(1, WINDOW) * (math.sqrt(5) - 1) / 2 % 1 - 0.5), 0.0)


@dataclass(frozen=True)
class DoublingPace:
    """Each chunk is as long as all before it together. first: the end of the first one; chunks: how many."""

    first: float
    chunks: int

    @classmethod
    def until(cls, end: float, first: float) -> DoublingPace:
        """That ends at a time, with a first chunk of about this length."""
        doublings = max(0, math.ceil(math.log2(end / first)))
        return cls(end / 2**doublings, doublings + 1)

    @property
    def end(self) -> float:
        """The limit of time."""
        return self.first * 2.0 ** (self.chunks - 1)

    def times(self, index: int) -> np.ndarray:
        """See ``Pace``."""
        return _times(self.first, index)


@lru_cache(maxsize=64)  # every tile asks
def _times(first: float, index: int) -> np.ndarray:
    """See ``Pace``; not to be written to."""
    end = first * 2.0**index
    begin, ends = (end / 2, np.arange(1, SAMPLES + 1)) if index else (0.0, np.arange(1, PARTS + 1))
    ends = ends + np.tile(_SHIFTS, len(ends) // WINDOW)
    parts = np.append(0.0, ends) / len(ends)
    if not index:
        each = zip(parts[:-1], parts[1:], FINER, strict=True)
        parts = np.append(0.0, np.concatenate([b + (e - b) * np.arange(1, n + 1) / n for b, e, n in each]))
    times = begin + (end - begin) * parts
    times[-1] = end
    times.setflags(write=False)
    return np.asarray(times)
