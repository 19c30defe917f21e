"""Counting of cycles after ASTM E1049-85: rainflow and range pairs with a policy for open ranges, level crossings, peaks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from wucht.fatigue.counted_cycles import LoadCycles
from wucht.numerics.zeros_and_peaks import stretches

_OPEN = 2  # distinct samples that are still needed: the next sample shows if the last one is an extreme


def _no_points() -> np.ndarray:
    return np.empty(0)


@dataclass(frozen=True, eq=False)
class TurningPoints:
    """The turning points of a signal so far: its first sample, and all extremes.

    Samples may come in parts: ``TurningPoints().update(time, values).update(...)``. Samples that repeat the one before count
    as one: a plateau is one extreme, at its begin.

    Attributes
    ----------
    time, values : numpy.ndarray, (m,)
        Of these points, in s and in the unit of the signal.
    open_time, open_values : numpy.ndarray, 2 at most
        The last distinct samples, whose end is the end of the signal.

    Examples
    --------
    >>> import numpy as np
    >>> from wucht.fatigue import TurningPoints
    >>> points = TurningPoints().update(np.array([0.0, 1, 2]), np.array([0.0, 4, 1]))
    >>> points.update(np.array([3.0, 4]), np.array([-2.0, 0])).points_to_end()[1].tolist()
    [0.0, 4.0, -2.0, 0.0]
    """

    time: np.ndarray = field(default_factory=_no_points)
    values: np.ndarray = field(default_factory=_no_points)
    open_time: np.ndarray = field(default_factory=_no_points)
    open_values: np.ndarray = field(default_factory=_no_points)

    def update(self, time: np.ndarray, values: np.ndarray, interpolate: bool = False) -> TurningPoints:
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
        extreme_times, extreme_values = _vertices(t, y, at) if interpolate else (t[at], y[at])
        begin = slice(0, int(first))
        return TurningPoints(
            np.concatenate([self.time, t[begin], extreme_times]),
            np.concatenate([self.values, y[begin], extreme_values]),
            t[-_OPEN:],
            y[-_OPEN:],
        )

    def without_points(self) -> TurningPoints:
        """Return the same state of counting without the points so far."""
        return replace(self, time=_no_points(), values=_no_points())

    def points_to_end(self) -> tuple[np.ndarray, np.ndarray]:
        """Return time and values (m,) of all turning points of a signal that ends here, its last sample among them."""
        ends = len(self.open_time) > 1
        time = np.append(self.time, self.open_time[-1:] if ends else _no_points())
        return time, np.append(self.values, self.open_values[-1:] if ends else _no_points())


def turning_points(values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the first value, all extremes, and the last value of a signal.

    Parameters
    ----------
    values : numpy.ndarray, (n,)

    Returns
    -------
    numpy.ndarray, (m,)
        Successive points differ, and turn back.

    Examples
    --------
    >>> from wucht.fatigue import turning_points
    >>> turning_points([0, 1, 3, 3, 2, 4]).tolist()
    [0.0, 3.0, 2.0, 4.0]
    """
    return TurningPoints().update(np.arange(len(values), dtype=float), np.asarray(values, dtype=float)).points_to_end()[1]


def _vertices(t: np.ndarray, y: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return place and height (m,) of the vertices of the parabolas through the samples ``at`` and their neighbours."""
    before, after = t[at] - t[at - 1], t[at + 1] - t[at]
    falls, rises = (y[at] - y[at - 1]) / before, (y[at + 1] - y[at]) / after
    curvature = (rises - falls) / (before + after)  # half the second derivative; not zero, for the slopes differ in sign
    slope = (falls * after + rises * before) / (before + after)
    return t[at] - slope / (2 * curvature), y[at] - slope**2 / (4 * curvature)


Residue = Literal["half-cycles", "repeat", "drop"]


def rainflow(values: Sequence[float] | np.ndarray, residue: Residue = "half-cycles") -> LoadCycles:
    """Count the rainflow cycles of a signal, or of its turning points: ASTM E1049-85, 5.4.4 and 5.4.5.

    Parameters
    ----------
    values : numpy.ndarray, (n,)
    residue : {"half-cycles", "repeat", "drop"}, optional
        The treatment of the ranges that close no cycle. ``half-cycles``: each counts one half, 5.4.4. ``repeat``: the signal
        repeats, so that all cycles close, 5.4.5. ``drop``: they do not count.

    Returns
    -------
    LoadCycles
        In the order in which the cycles close; half cycles last.

    Examples
    --------
    >>> from wucht.fatigue import rainflow
    >>> cycles = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    >>> cycles.ranges.tolist(), cycles.counts.tolist()
    ([4.0, 3.0, 4.0, 8.0, 9.0, 8.0, 6.0], [1.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5])
    """
    points = turning_points(values)
    if residue == "repeat":
        return _repeated_cycles(points)
    cycles, rest = closed_cycles(points)
    return cycles if residue == "drop" else cycles.join(half_cycles(rest))


def range_pairs(values: Sequence[float] | np.ndarray, residue: Residue = "half-cycles") -> LoadCycles:
    """Count the range pairs of a signal, or of its turning points: ASTM E1049-85, 5.4.1.

    Inside of a larger range they are the rainflow cycles; of the ranges that remain each is paired with the next one that is
    at least as large, and a last single one counts as half a cycle.

    Parameters
    ----------
    values : numpy.ndarray, (n,)
    residue : {"half-cycles", "repeat", "drop"}, optional
        ``half-cycles``: as above. ``repeat``, ``drop``: see ``rainflow``, which then counts the same cycles.

    Returns
    -------
    LoadCycles
    """
    if residue != "half-cycles":
        return rainflow(values, residue)
    cycles, rest = closed_cycles(turning_points(values))
    forward, rest = _pair_ranges(rest)
    backward, rest = _pair_ranges(rest[::-1])
    pairs = np.concatenate([forward, backward])
    cycles = cycles.join(LoadCycles.from_extremes(pairs[:, 0], pairs[:, 1], np.ones(len(pairs))))
    return cycles.join(half_cycles(rest))


def _pair_ranges(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ranges (k, 2) that are followed by one at least as large, and the points that remain without them."""
    pairs, stack = list[tuple[float, float]](), list[float]()
    for point in points.tolist():
        stack.append(point)
        while len(stack) > 2 and abs(stack[-1] - stack[-2]) >= abs(stack[-2] - stack[-3]):
            pairs.append((stack[-3], stack[-2]))
            del stack[-3:-1]
    return np.array(pairs).reshape(-1, 2), np.array(stack)


def closed_cycles(points: np.ndarray) -> tuple[LoadCycles, np.ndarray]:
    """Return the closed cycles of turning points, and the points of the ranges that close none.

    Counting may continue from these: followed by later turning points they give the cycles that close then.

    A cycle closes where a range is no larger than that before and that after it: the four-point rule, which finds the cycles of
    ASTM's rule of three points, those at the begin of the history among them.

    Parameters
    ----------
    points : numpy.ndarray, (m,)
        Turning points, as ``turning_points`` returns them.

    Returns
    -------
    cycles : LoadCycles
    open_points : numpy.ndarray, (k,)
        In their order.
    """
    begins, ends, stack = list[float](), list[float](), list[float]()
    for point in points.tolist():
        while len(stack) > 2:
            inner, before = stack[-1], stack[-2]
            size = abs(inner - before)
            if size > abs(point - inner) or size > abs(before - stack[-3]):
                break
            begins.append(before)
            ends.append(inner)
            del stack[-2:]
        stack.append(point)
    return LoadCycles.from_extremes(np.array(begins), np.array(ends), np.ones(len(begins))), np.array(stack)


def half_cycles(points: np.ndarray) -> LoadCycles:
    """Count the ranges between turning points, one half each.

    Parameters
    ----------
    points : numpy.ndarray, (k,)

    Returns
    -------
    LoadCycles
    """
    return LoadCycles.from_extremes(points[:-1], points[1:], np.full(max(len(points) - 1, 0), 0.5))


def _repeated_cycles(points: np.ndarray) -> LoadCycles:
    """Count all cycles of a repeated history from its largest value on: two halves remain, which are one cycle."""
    if len(points) < 2:
        return LoadCycles.empty()
    top = int(points.argmax())
    cycles, halves = closed_cycles(turning_points(np.concatenate([points[top:], points[: top + 1]])))
    return cycles.join(LoadCycles.from_extremes(halves[:1], halves[1:2], np.ones(1)))


def level_crossings(values: Sequence[float] | np.ndarray, levels: np.ndarray, reference: float | None = None) -> np.ndarray:
    """Count how often a signal crosses each of some levels: ASTM E1049-85, 5.1.1.

    A slope crosses the levels above its begin, up to its end.

    Parameters
    ----------
    values : numpy.ndarray, (n,)
    levels : numpy.ndarray, (k,)
        Ascending, in the unit of the signal.
    reference : float, optional
        Rising slopes count at levels from the reference on, falling ones below it; without a reference rising ones everywhere.

    Returns
    -------
    numpy.ndarray of int, (k,)
    """
    points = turning_points(values)
    upward = _upward_counts(points, levels)
    if reference is None:
        return upward
    downward = _upward_counts(-points, -levels[::-1])[::-1]
    return np.where(levels >= reference, upward, downward)


def cycles_of_levels(levels: np.ndarray, counts: np.ndarray) -> LoadCycles:
    """Return the most damaging cycles of the crossings of evenly spaced levels: ASTM E1049-85, 5.1.3.

    The largest possible cycle first, then the next, until all crossings are used; each turns halfway between levels.

    Parameters
    ----------
    levels : numpy.ndarray, (k,)
        Ascending.
    counts : numpy.ndarray, (k,)
        Of their crossings, as ``level_crossings`` returns them.

    Returns
    -------
    LoadCycles
    """
    remaining, half = np.asarray(counts, dtype=float).copy(), float(levels[1] - levels[0]) / 2 if len(levels) > 1 else 0.0
    cycles = list[tuple[float, float, float]]()
    while remaining.any():
        part = slice(*max(stretches(remaining > 0), key=lambda stretch: stretch[1] - stretch[0]))
        cycle_count = float(remaining[part].min())
        remaining[part] -= cycle_count
        cycles.append((levels[part][0] - half, levels[part][-1] + half, cycle_count))
    low, high, cycle_counts = np.array(cycles).reshape(-1, 3).T
    return LoadCycles.from_extremes(low, high, cycle_counts)


def peaks_and_valleys(
    values: Sequence[float] | np.ndarray, reference: float | None = None, is_repeated: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return the peaks and the valleys of a signal: ASTM E1049-85, 5.2.1.

    Parameters
    ----------
    values : numpy.ndarray, (n,)
    reference : float, optional
        Only peaks above and valleys below it count.
    is_repeated : bool, optional
        The signal repeats. Else its begin and its end are neither peak nor valley.

    Returns
    -------
    peaks, valleys : numpy.ndarray, (p,) and (v,)
        Each descending.
    """
    points = turning_points(values)
    if is_repeated and len(points) > 1:
        top = int(points.argmax())
        points = turning_points(np.concatenate([points[top:], points[: top + 1]]))
        points = np.append(points, points[1])  # the top is a peak between its neighbours
    inside, is_peak = points[1:-1], points[1:-1] > points[:-2]
    peaks, valleys = np.sort(inside[is_peak])[::-1], np.sort(inside[~is_peak])[::-1]
    if reference is None:
        return peaks, valleys
    return peaks[peaks >= reference], valleys[valleys < reference]


def cycles_of_peaks(peaks: np.ndarray, valleys: np.ndarray, reference: float = 0.0) -> LoadCycles:
    """Return the most damaging cycles of peaks and valleys: ASTM E1049-85, 5.2.3.

    The highest peak with the lowest valley, and so on; those left over are half cycles from the reference.

    Parameters
    ----------
    peaks, valleys : numpy.ndarray, (p,) and (v,)
        In any order.
    reference : float, optional

    Returns
    -------
    LoadCycles
    """
    high, low = np.sort(peaks)[::-1], np.sort(valleys)
    pair_count = min(len(high), len(low))
    single = np.concatenate([high[pair_count:], low[pair_count:]])
    pairs = LoadCycles.from_extremes(high[:pair_count], low[:pair_count], np.ones(pair_count))
    return pairs.join(LoadCycles.from_extremes(single, np.full(len(single), reference), np.full(len(single), 0.5)))


def _upward_counts(points: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Count how often each level (k,), ascending, is crossed by rising slopes."""
    begin, end = np.searchsorted(levels, points[:-1], side="right"), np.searchsorted(levels, points[1:], side="right")
    rising = end > begin
    steps = np.bincount(begin[rising], minlength=len(levels) + 1) - np.bincount(end[rising], minlength=len(levels) + 1)
    return np.asarray(np.cumsum(steps)[: len(levels)])
