"""Counting of cycles after ASTM E1049-85: rainflow and range pairs with a policy for open ranges, level crossings, peaks."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from wucht.fatigue.counted_cycles import Cycles
from wucht.numerics.zeros_and_peaks import stretches

_OPEN = 2  # distinct samples that are still needed: the next sample shows if the last one is an extreme


def _none() -> np.ndarray:
    return np.empty(0)


@dataclass(frozen=True, eq=False)
class TurningPoints:
    """The turning points of a signal so far: its first sample, and all extremes.

    time, values (m,): of these points. open_time, open_values (2 at most): the last distinct samples, whose end is the end of
    the signal. Samples that repeat the one before count as one: a plateau is one extreme, at its begin.
    """

    time: np.ndarray = field(default_factory=_none)
    values: np.ndarray = field(default_factory=_none)
    open_time: np.ndarray = field(default_factory=_none)
    open_values: np.ndarray = field(default_factory=_none)

    def after(self, time: np.ndarray, values: np.ndarray, between: bool = False) -> TurningPoints:
        """Return the points after more samples (n,) of increasing time; those not later than the last known one are ignored.

        interpolate: extremes are those of the parabola through their sample and both neighbours: for a computed signal,
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
        """Return the same state of counting without the points so far."""
        return replace(self, time=_none(), values=_none())

    def closed(self) -> tuple[np.ndarray, np.ndarray]:
        """Return time and values (m,) of all turning points of a signal that ends here, its last sample among them."""
        ends = len(self.open_time) > 1
        time = np.append(self.time, self.open_time[-1:] if ends else _none())
        return time, np.append(self.values, self.open_values[-1:] if ends else _none())


def turning_points(values: np.ndarray) -> np.ndarray:
    """Return the first value, all extremes, and the last value of a signal (n,): successive points differ, and turn back."""
    return TurningPoints().after(np.arange(len(values), dtype=float), np.asarray(values, dtype=float)).closed()[1]


def _vertices(t: np.ndarray, y: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return place and height (m,) of the vertices of the parabolas through the samples ``at`` and their neighbours."""
    before, after = t[at] - t[at - 1], t[at + 1] - t[at]
    falls, rises = (y[at] - y[at - 1]) / before, (y[at + 1] - y[at]) / after
    curvature = (rises - falls) / (before + after)  # half the second derivative; not zero, for the slopes differ in sign
    slope = (falls * after + rises * before) / (before + after)
    return t[at] - slope / (2 * curvature), y[at] - slope**2 / (4 * curvature)


Residue = Literal["half-cycles", "repeat", "drop"]


def rainflow(values: np.ndarray, residue: Residue = "half-cycles") -> Cycles:
    """Count the rainflow cycles of a signal (n,), or of its turning points.

    residue: the treatment of the ranges that close no cycle. ``half-cycles``: each counts one half, ASTM E1049-85, 5.4.4.
    ``repeat``: the signal repeats, so that all cycles close, 5.4.5. ``drop``: they do not count.
    """
    points = turning_points(values)
    if residue == "repeat":
        return _of_repeated(points)
    cycles, rest = closed_cycles(points)
    return cycles if residue == "drop" else cycles.joined(half_cycles(rest))


def range_pairs(values: np.ndarray, residue: Residue = "half-cycles") -> Cycles:
    """Count the range pairs of a signal (n,), or of its turning points: ASTM E1049-85, 5.4.1.

    Inside of a larger range they are the rainflow cycles; of the ranges that remain each is paired with the next one, and a
    last single one counts as half a cycle (``half-cycles``). ``repeat``, ``drop``: see ``rainflow``.
    """
    if residue != "half-cycles":
        return rainflow(values, residue)
    cycles, rest = closed_cycles(turning_points(values))
    forward, rest = _paired(rest)
    backward, rest = _paired(rest[::-1])
    pairs = np.concatenate([forward, backward])
    cycles = cycles.joined(Cycles.between(pairs[:, 0], pairs[:, 1], np.ones(len(pairs))))
    return cycles.joined(half_cycles(rest))


def _paired(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ranges (k, 2) that are followed by one at least as large, and the points that remain without them."""
    pairs, kept = list[tuple[float, float]](), list[float]()
    for point in points.tolist():
        kept.append(point)
        while len(kept) > 2 and abs(kept[-1] - kept[-2]) >= abs(kept[-2] - kept[-3]):
            pairs.append((kept[-3], kept[-2]))
            del kept[-3:-1]
    return np.array(pairs).reshape(-1, 2), np.array(kept)


def closed_cycles(points: np.ndarray) -> tuple[Cycles, np.ndarray]:
    """Return the closed cycles of turning points (m,), and the points (k,) of the ranges that close none, in their order.

    Counting may continue from these: followed by later turning points they give the cycles that close then.

    A cycle closes where a range is no larger than that before and that after it: the four-point rule, which finds the cycles of
    ASTM's rule of three points, those at the begin of the history among them.
    """
    one, other, kept = list[float](), list[float](), list[float]()
    for point in points.tolist():
        while len(kept) > 2:
            inner, before = kept[-1], kept[-2]
            size = abs(inner - before)
            if size > abs(point - inner) or size > abs(before - kept[-3]):
                break
            one.append(before)
            other.append(inner)
            del kept[-2:]
        kept.append(point)
    return Cycles.between(np.array(one), np.array(other), np.ones(len(one))), np.array(kept)


def half_cycles(points: np.ndarray) -> Cycles:
    """Count the ranges between turning points (k,), one half each."""
    return Cycles.between(points[:-1], points[1:], np.full(max(len(points) - 1, 0), 0.5))


def _of_repeated(points: np.ndarray) -> Cycles:
    """Count all cycles of a repeated history from its largest value on: two halves remain, which are one cycle."""
    if len(points) < 2:
        return Cycles.none()
    top = int(points.argmax())
    cycles, halves = closed_cycles(turning_points(np.concatenate([points[top:], points[: top + 1]])))
    return cycles.joined(Cycles.between(halves[:1], halves[1:2], np.ones(1)))


def level_crossings(values: np.ndarray, levels: np.ndarray, reference: float | None = None) -> np.ndarray:
    """Count how often a signal (n,) crosses each of ascending levels (k,): ASTM E1049-85, 5.1.1.

    Rising slopes count at levels from the reference on, falling ones below it; without a reference rising ones everywhere. A
    slope crosses the levels above its begin, up to its end.
    """
    points = turning_points(values)
    upward = _crossed(points, levels)
    if reference is None:
        return upward
    downward = _crossed(-points, -levels[::-1])[::-1]
    return np.where(levels >= reference, upward, downward)


def cycles_of_levels(levels: np.ndarray, counts: np.ndarray) -> Cycles:
    """Return the most damaging cycles of the crossings (k,) of evenly spaced levels (k,): ASTM E1049-85, 5.1.3.

    The largest possible cycle first, then the next, until all crossings are used; each turns halfway between levels.
    """
    left, half = np.asarray(counts, dtype=float).copy(), float(levels[1] - levels[0]) / 2 if len(levels) > 1 else 0.0
    found = list[tuple[float, float, float]]()
    while left.any():
        part = slice(*max(stretches(left > 0), key=lambda each: each[1] - each[0]))
        often = float(left[part].min())
        left[part] -= often
        found.append((levels[part][0] - half, levels[part][-1] + half, often))
    low, high, often_each = np.array(found).reshape(-1, 3).T
    return Cycles.between(low, high, often_each)


def peaks_and_valleys(
    values: np.ndarray, reference: float | None = None, closed: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return the peaks and the valleys of a signal (n,), each descending: ASTM E1049-85, 5.2.1.

    With a reference only peaks above and valleys below it. Begin and end are neither, unless the signal ``is_repeated``.
    """
    points = turning_points(values)
    if closed and len(points) > 1:
        top = int(points.argmax())
        points = turning_points(np.concatenate([points[top:], points[: top + 1]]))
        points = np.append(points, points[1])  # the top is a peak between its neighbours
    inside, is_peak = points[1:-1], points[1:-1] > points[:-2]
    peaks, valleys = np.sort(inside[is_peak])[::-1], np.sort(inside[~is_peak])[::-1]
    if reference is None:
        return peaks, valleys
    return peaks[peaks >= reference], valleys[valleys < reference]


def cycles_of_peaks(peaks: np.ndarray, valleys: np.ndarray, reference: float = 0.0) -> Cycles:
    """Return the most damaging cycles of peaks and valleys: ASTM E1049-85, 5.2.3.

    The highest peak with the lowest valley, and so on; those left over are half cycles from the reference.
    """
    high, low = np.sort(peaks)[::-1], np.sort(valleys)
    both = min(len(high), len(low))
    single = np.concatenate([high[both:], low[both:]])
    pairs = Cycles.between(high[:both], low[:both], np.ones(both))
    return pairs.joined(Cycles.between(single, np.full(len(single), reference), np.full(len(single), 0.5)))


def _crossed(points: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Count how often each level (k,), ascending, is crossed by rising slopes."""
    begin, end = np.searchsorted(levels, points[:-1], side="right"), np.searchsorted(levels, points[1:], side="right")
    rising = end > begin
    steps = np.bincount(begin[rising], minlength=len(levels) + 1) - np.bincount(end[rising], minlength=len(levels) + 1)
    return np.asarray(np.cumsum(steps)[: len(levels)])
