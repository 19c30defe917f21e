"""Cycles, their classes by range and by mean, and the distance of two spectra: small cases by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.fatigue.counted_cycles import LoadCycles, RangeMeanMatrix, frequency_distance


def cycles(*rows: tuple[float, float, float]) -> LoadCycles:
    """Range, mean and number of each."""
    return LoadCycles(*np.array(rows, float).reshape(-1, 3).T)


def test_no_cycles_are_none_everywhere() -> None:
    none = LoadCycles.empty()
    rows, row = none.group_by_range(1.0)
    assert (none.total, none.largest, len(rows.ranges), len(row)) == (0.0, 0.0, 0, 0)
    assert none.cumulative_frequency(np.array([0.0, 1.0])).tolist() == [0.0, 0.0]
    matrix = RangeMeanMatrix.of(none, 4)
    assert matrix.range_edges.tolist() == matrix.mean_edges.tolist() == [0, 0.25, 0.5, 0.75, 1]
    assert not matrix.counts.any()


def test_ranges_of_one_class_are_one_cycle_of_their_mean() -> None:
    """Classes of width 2: 0 to 2, 2 to 4, 6 to 8; the one from 4 to 6 is empty. A range on an edge is in the class above it."""
    some = cycles((7.0, 5.0, 1.0), (1.0, 2.0, 3.0), (2.0, 1.0, 1.0), (1.8, 6.0, 1.0), (3.0, 4.0, 3.0))
    rows, row = some.group_by_range(2.0)
    assert row.tolist() == [2, 0, 1, 0, 1]
    assert rows.ranges.tolist() == pytest.approx([(3 * 1.0 + 1.8) / 4, (2.0 + 3 * 3.0) / 4, 7.0])
    assert rows.means.tolist() == pytest.approx([(3 * 2.0 + 6.0) / 4, (1.0 + 3 * 4.0) / 4, 5.0])
    assert rows.counts.tolist() == [4.0, 4.0, 1.0]


def test_a_matrix_of_ranges_and_means() -> None:
    """Ranges in classes from 0 to the largest, 8; means from the lowest, -1, to the highest, 3; outer edges belong to it."""
    some = cycles((8.0, -1.0, 1.0), (0.5, 3.0, 2.0), (5.0, 0.5, 4.0), (2.0, -0.2, 8.0), (7.9, 2.5, 0.5))
    matrix = RangeMeanMatrix.of(some, 4)
    assert matrix.range_edges.tolist() == [0, 2, 4, 6, 8]
    assert matrix.mean_edges.tolist() == [-1, 0, 1, 2, 3]
    assert matrix.counts.tolist() == [[0, 0, 0, 2], [8, 0, 0, 0], [0, 4, 0, 0], [1, 0, 0, 0.5]]


@pytest.mark.parametrize("mean", [4.0, -4.0, 0.0])
def test_a_matrix_of_one_mean_has_classes_above_it(mean: float) -> None:
    """As wide as those of ranges: a scale of rounding errors would tell nothing."""
    matrix = RangeMeanMatrix.of(cycles((2.0, mean, 3.0), (1.0, mean, 1.0)), 2)
    assert matrix.counts.tolist() == [[0, 0], [4, 0]]
    assert matrix.mean_edges[0] == mean
    assert np.diff(matrix.mean_edges) == pytest.approx(np.diff(matrix.range_edges))


@pytest.mark.parametrize(("mean", "noise"), [(0.1, 2e-6), (1e4, 1e-5)])
def test_means_that_differ_by_noise_alone_are_of_one_class(mean: float, noise: float) -> None:
    """A millionth of the largest range, 2, or a billionth of the mean."""
    same, different = (
        RangeMeanMatrix.of(cycles((2.0, mean, 3.0), (1.0, mean + share * noise, 1.0)), 2) for share in (0.9, 1.1)
    )
    assert same.counts.tolist() == [[0, 0], [4, 0]]
    assert different.counts.tolist() == [[0, 0], [3, 1]]


def test_the_distance_of_spectra_is_a_share_of_the_reference() -> None:
    """At 2 and above: 6 against 1; at 4: 1 against 1. As a share of the 4 of the one and of the 8 of the other."""
    one, other = cycles((4.0, 0.0, 1.0), (1.0, 0.0, 3.0)), cycles((4.0, 0.0, 1.0), (2.0, 0.0, 5.0), (1.0, 0.0, 2.0))
    assert frequency_distance(other, one) == pytest.approx(5 / 4)
    assert frequency_distance(one, other) == pytest.approx(5 / 8)
    assert frequency_distance(one, other, times=2.0) == pytest.approx(4 / 8)


def test_the_distance_from_no_cycles() -> None:
    one, none = cycles((4.0, 0.0, 1.0)), LoadCycles.empty()
    assert frequency_distance(none, none) == 0
    assert frequency_distance(one, none) == math.inf
    assert frequency_distance(none, one) == 1
