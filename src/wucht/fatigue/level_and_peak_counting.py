"""Level-crossing and peak counting after ASTM E1049-85, and the most damaging cycles that such counts may stand for."""

from __future__ import annotations

import numpy as np

from wucht.fatigue.counted_cycles import Cycles
from wucht.fatigue.turning_points import turning_points


def level_crossings(values: np.ndarray, levels: np.ndarray, reference: float | None = None) -> np.ndarray:
    """How often a signal (n,) crosses each level (k,), which increase: ASTM E1049-85, 5.1.1.

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
    """The most damaging cycles of the crossings (k,) of evenly spaced levels (k,): ASTM E1049-85, 5.1.3.

    The largest possible cycle first, then the next, until all crossings are used; each turns halfway between levels.
    """
    left, half = np.asarray(counts, dtype=float).copy(), float(levels[1] - levels[0]) / 2 if len(levels) > 1 else 0.0
    found = list[tuple[float, float, float]]()
    while left.any():
        edges = np.flatnonzero(np.diff(np.concatenate([[0], left > 0, [0]])))
        begins, ends = edges[::2], edges[1::2]
        longest = int((ends - begins).argmax())
        part = slice(begins[longest], ends[longest])
        often = float(left[part].min())
        left[part] -= often
        found.append((levels[part][0] - half, levels[part][-1] + half, often))
    low, high, often_each = np.array(found).reshape(-1, 3).T
    return Cycles.between(low, high, often_each)


def peaks_and_valleys(
    values: np.ndarray, reference: float | None = None, closed: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """The peaks and the valleys of a signal (n,), each descending: ASTM E1049-85, 5.2.1.

    With a reference only peaks above and valleys below it. Begin and end are neither, unless the signal repeats (``closed``).
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
    """The most damaging cycles of peaks and valleys: ASTM E1049-85, 5.2.3.

    The highest peak with the lowest valley, and so on; those left over are half cycles from the reference.
    """
    high, low = np.sort(peaks)[::-1], np.sort(valleys)
    both = min(len(high), len(low))
    single = np.concatenate([high[both:], low[both:]])
    pairs = Cycles.between(high[:both], low[:both], np.ones(both))
    return pairs.joined(Cycles.between(single, np.full(len(single), reference), np.full(len(single), 0.5)))


def _crossed(points: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """How often each level (k,), ascending, is crossed by rising slopes."""
    begin, end = np.searchsorted(levels, points[:-1], side="right"), np.searchsorted(levels, points[1:], side="right")
    rising = end > begin
    steps = np.bincount(begin[rising], minlength=len(levels) + 1) - np.bincount(end[rising], minlength=len(levels) + 1)
    return np.asarray(np.cumsum(steps)[: len(levels)])
