"""Counting against pyLife, the rules of ASTM E1049-85 step by step, and its figures 2, 3, 5, 6, 7, read off as data."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pylife.stress.rainflow import FourPointDetector, LoopValueRecorder

from wucht.fatigue.counted_cycles import LoadCycles, RangeMeanMatrix
from wucht.fatigue.counting import (
    TurningPoints,
    cycles_of_levels,
    cycles_of_peaks,
    level_crossings,
    peaks_and_valleys,
    rainflow,
    range_pairs,
    turning_points,
)

LISTS = st.lists(st.integers(-20, 20), min_size=1, max_size=80)
HISTORIES = LISTS.map(lambda v: np.array(v, dtype=float))
MOVING = LISTS.filter(lambda v: len(set(v)) > 1).map(lambda v: np.array(v, dtype=float))  # pyLife counts a range of zero else
ANY = settings(max_examples=60, deadline=None)


def table(cycles):
    rows, _ = cycles.group_by_range()
    return dict(zip(np.round(rows.ranges, 6).tolist(), np.round(rows.counts, 9).tolist(), strict=True))


def by_pylife(values):
    recorder = LoopValueRecorder()
    detector = FourPointDetector(recorder=recorder).process(values)
    one, other = np.array(recorder.values_from), np.array(recorder.values_to)
    return LoadCycles.from_extremes(one, other, np.ones(len(one))), np.array(detector.residuals)


@ANY
@given(MOVING)
def test_closed_cycles_and_residue_are_those_of_pylife(values):
    closed, residue = by_pylife(turning_points(values))
    assert table(rainflow(values, "drop")) == table(closed)
    halves = LoadCycles.from_extremes(residue[:-1], residue[1:], np.full(max(len(residue) - 1, 0), 0.5))
    assert table(rainflow(values)) == table(closed.join(halves))


@ANY
@given(HISTORIES)
def test_every_range_is_counted_once(values):
    """The sum of the ranges, each as often as it counts, is half the way of the signal; repeated, with the way back."""
    way = float(np.abs(np.diff(values)).sum())
    found = rainflow(values)
    assert 2 * float((found.ranges * found.counts).sum()) == pytest.approx(way, abs=1e-9)
    closed = rainflow(values, "repeat")
    assert 2 * float((closed.ranges * closed.counts).sum()) == pytest.approx(way + abs(values[-1] - values[0]), abs=1e-9)
    assert (closed.counts == 1).all()
    assert closed.largest == np.ptp(values)


@ANY
@given(HISTORIES, st.floats(0.01, 1e3), st.floats(-1e3, 1e3))
def test_scale_shift_and_sign(values, factor, shift):
    for count in (rainflow, range_pairs):
        expected, moved = table(count(values)), table(count(factor * values + shift))
        assert list(moved.values()) == list(expected.values())
        assert list(moved) == pytest.approx([factor * size for size in expected], rel=1e-6, abs=1e-5)
        assert table(count(-values)) == expected


def by_the_rules_of_range_pairs(values):
    """ASTM E1049-85, 5.4.1.2, as it stands there: X is the range under consideration, Y the one before."""
    counted = []
    points = turning_points(values).tolist()
    for _ in range(2):  # forwards, then what remains backwards
        left = []
        for point in points:
            left.append(point)
            while len(left) >= 3:
                x, y = abs(left[-1] - left[-2]), abs(left[-2] - left[-3])
                if x < y:
                    break
                counted.append(y)
                last = left.pop()
                left.pop(), left.pop()
                left.append(last)
        points = left[::-1]
    sizes = [*((y, 1.0) for y in counted), *((abs(a - b), 0.5) for a, b in pairwise(points))]
    return {size: sum(n for s, n in sizes if s == size) for size in sorted({s for s, _ in sizes})}


@ANY
@given(HISTORIES)
def test_range_pairs_follow_the_rules(values):
    assert table(range_pairs(values)) == by_the_rules_of_range_pairs(values)


@ANY
@given(HISTORIES)
def test_crossings_and_peaks_against_counting_by_hand(values):
    levels = np.arange(-19.5, 20.0)
    counts = level_crossings(values, levels)
    assert counts.tolist() == [int(((values[:-1] < x) & (values[1:] > x)).sum()) for x in levels]
    of_levels = cycles_of_levels(levels, counts)
    assert float((of_levels.ranges * of_levels.counts).sum()) == counts.sum()  # each crossing is one level of one cycle
    peaks, valleys = peaks_and_valleys(values)
    points = turning_points(values)
    assert len(peaks) + len(valleys) == max(len(points) - 2, 0)
    assert cycles_of_peaks(peaks, valleys).total == (len(peaks) + len(valleys)) / 2


@ANY
@given(HISTORIES)
def test_classes_keep_the_sum(values):
    cycles = rainflow(values)
    for width in (None, 0.7, 3.0):
        rows, row = cycles.group_by_range(width)
        assert rows.total == pytest.approx(cycles.total)
        assert float((rows.ranges * rows.counts).sum()) == pytest.approx(float((cycles.ranges * cycles.counts).sum()))
        assert np.bincount(row, cycles.counts, minlength=len(rows.counts)).tolist() == pytest.approx(rows.counts.tolist())
    assert RangeMeanMatrix.of(cycles, 7).counts.sum() == pytest.approx(cycles.total)


VALUES = st.lists(st.integers(-9, 9), max_size=60).map(lambda v: np.array(v, dtype=float))


@settings(max_examples=60, deadline=None)
@given(VALUES, st.lists(st.integers(0, 60), max_size=5))
def test_pieces_give_what_the_whole_gives(values, cuts):
    time, whole = np.arange(len(values), dtype=float), turning_points(values)
    assert (np.sign(np.diff(whole))[1:] == -np.sign(np.diff(whole))[:-1]).all()
    found, kept, times = TurningPoints(), [], []
    for new in np.split(np.arange(len(values)), sorted(min(c, len(values)) for c in cuts)):
        part = np.concatenate([new[:1] - 1, new]) if len(new) and new[0] else new  # with the last sample of that before
        found = found.update(time[part], values[part])
        kept.append(found.values)
        times.append(found.time)
        found = found.without_points()
    end_time, end = found.points_to_end()
    assert np.concatenate([*kept, end]).tolist() == whole.tolist()
    assert (np.diff(np.concatenate([*times, end_time])) > 0).all()


def test_extremes_between_samples():
    """Of a vibration with 48 samples a period, not evenly spaced: right to h^4/32."""
    time = np.sort(np.random.default_rng(3).uniform(0.0, 60.0, int(60 * 48 / (2 * np.pi))))
    time = np.linspace(0, 60, len(time)) + 0.2 * (time - np.linspace(0, 60, len(time))).clip(-0.1, 0.1)
    found = TurningPoints().update(time, np.cos(time), interpolate=True)
    extremes = found.values[1:]
    step = np.diff(time).max()
    assert np.abs(np.abs(extremes) - 1).max() < step**4 / 32
    assert np.abs(found.time[1:] / np.pi - np.round(found.time[1:] / np.pi)).max() < step**2 / 10
    assert np.abs(np.abs(TurningPoints().update(time, np.cos(time)).values[1:]) - 1).max() > 20 * step**4 / 32


PRINTED = np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2], dtype=float)
FIGURE_2 = np.array([-0.8, 1.3, 0.7, 3.4, 0.7, 2.5, -1.4, -0.5, -2.3, -2.2, -2.6, -2.4, -3.3, 1.5, 0.6, 3.4, -0.5])
FIGURE_3 = np.array([0.0, 1.5, 0.5, 3.5, 0.5, 2.5, -1.5, -0.5, -2.5, -2.0, -2.7, -2.5, -3.5, 1.5, 0.5, 3.5, -0.5])


def test_rainflow():
    found = rainflow(PRINTED)
    assert table(found) == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}
    full = found.counts == 1
    assert (found.ranges[full].tolist(), found.means[full].tolist()) == ([4.0], [1.0])
    assert table(rainflow(PRINTED, "repeat")) == {3: 1, 4: 1, 7: 1, 9: 1}
    assert table(rainflow(PRINTED, "drop")) == {4: 1}
    assert table(range_pairs(PRINTED)) == {3: 1, 4: 1, 6: 1, 8: 1}
    assert table(range_pairs(PRINTED, "repeat")) == table(rainflow(PRINTED, "repeat"))


def test_level_crossings():
    levels = np.arange(-4.0, 5.0)
    counts = level_crossings(FIGURE_2, levels, reference=0.0)
    assert counts.tolist() == [0, 1, 1, 2, 2, 5, 3, 2, 0]
    assert table(cycles_of_levels(levels, counts)) == {7: 1, 5: 1, 2: 1, 1: 2}


@pytest.mark.parametrize(("signal", "counts"), [([-2.0, 2.0], [0, 1, 1]), ([2.0, -2.0], [1, 0, 0])])
def test_at_the_reference_itself_rising_slopes_count(signal, counts):
    """5.1.1: rising slopes at the reference and above, falling ones below it."""
    assert level_crossings(np.array(signal), np.array([-1.0, 0.0, 1.0]), reference=0.0).tolist() == counts


def test_peaks():
    peaks, valleys = peaks_and_valleys(FIGURE_3, reference=0.0)
    assert (peaks.tolist(), valleys.tolist()) == ([3.5, 3.5, 2.5, 1.5, 1.5], [-1.5, -2.5, -2.7, -3.5])
    assert table(cycles_of_peaks(peaks, valleys)) == {7.0: 1, 6.2: 1, 5.0: 1, 3.0: 1, 1.5: 0.5}


def test_all_peaks_without_a_reference():
    peaks, valleys = peaks_and_valleys(FIGURE_3)
    assert (len(peaks), len(valleys)) == (8, 7)
    closed = peaks_and_valleys(FIGURE_3, is_repeated=True)
    assert [len(part) for part in closed] == [8, 8]
    assert (closed[0][0], closed[1][-1]) == (3.5, -3.5)
