"""Turning points: what counting methods see of a signal, found piece by piece while it comes in."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

_OPEN = 2  # distinct samples that are still needed: whether the last one is an extreme shows the next


def _none() -> np.ndarray:
    return np.empty(0)


@dataclass(frozen=True, eq=False)
class TurningPoints:
    """The turning points of a signal so far: its first sample, and all extremes.

    time, values (m,): of those found. open_time, open_values (2 at most): the last distinct samples, whose end is the end of
    the signal. Samples that repeat the one before count as one: a plateau is one extreme, at its begin.
    """

    time: np.ndarray = field(default_factory=_none)
    values: np.ndarray = field(default_factory=_none)
    open_time: np.ndarray = field(default_factory=_none)
    open_values: np.ndarray = field(default_factory=_none)

    def after(self, time: np.ndarray, values: np.ndarray, between: bool = False) -> TurningPoints:
        """After more samples (n,) of increasing time; those not later than the last one known are passed over.

        between: whether an extreme is that of the parabola through its sample and both neighbours: for a computed signal,
        sampled so densely that this is better than the sample. A record counts as it was recorded.
        """
        new = time > self.open_time[-1] if len(self.open_time) else np.ones(len(time), bool)
        if not new.any():
            return self
        first = not len(self.open_time)
        t, y = np.concatenate([self.open_time, time[new]]), np.concatenate([self.open_values, values[new]])
        distinct = np.append(True, y[1:] != y[:-1])
        t, y = t[distinct], y[distinct]
        rising = y[1:] > y[:-1]
        at = 1 + np.flatnonzero(rising[1:] != rising[:-1])
        found_time, found = _vertices(t, y, at) if between else (t[at], y[at])
        begin = slice(0, int(first))
        return TurningPoints(
            np.concatenate([self.time, t[begin], found_time]),
            np.concatenate([self.values, y[begin], found]),
            t[-_OPEN:],
            y[-_OPEN:],
        )

    def forgotten(self) -> TurningPoints:
        """To go on from here without the points found so far."""
        return replace(self, time=_none(), values=_none())

    def closed(self) -> tuple[np.ndarray, np.ndarray]:
        """Time and values (m,) of all turning points of a signal that ends here, its last sample among them."""
        ends = len(self.open_time) > 1
        time = np.append(self.time, self.open_time[-1:] if ends else _none())
        return time, np.append(self.values, self.open_values[-1:] if ends else _none())


def turning_points(values: np.ndarray) -> np.ndarray:
    """The first value, all extremes, and the last value of a signal (n,): successive points differ, and turn back."""
    return TurningPoints().after(np.arange(len(values), dtype=float), np.asarray(values, dtype=float)).closed()[1]


def _vertices(t: np.ndarray, y: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place and height (m,) of the vertices of the parabolas through the samples ``at`` and their neighbours."""
    before, after = t[at] - t[at - 1], t[at + 1] - t[at]
    falls, rises = (y[at] - y[at - 1]) / before, (y[at + 1] - y[at]) / after
    curvature = (rises - falls) / (before + after)  # half the second derivative; not zero, for the slopes differ in sign
    slope = (falls * after + rises * before) / (before + after)
    return t[at] - slope / (2 * curvature), y[at] - slope**2 / (4 * curvature)
