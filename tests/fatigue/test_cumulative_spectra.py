"""Spectra that are wanted, against distributions in closed form; the distance of amplitudes against hand-made spectra."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from wucht.fatigue.counted_cycles import LoadCycles, RangeMeanMatrix, frequency_distance
from wucht.fatigue.counting import rainflow
from wucht.fatigue.cumulative_spectra import (
    EXPONENTS,
    amplitude_distance,
    amplitudes_at,
    cycle_shares,
    shift_spectrum,
    standard_spectrum,
    tabulated_spectrum,
)

COUNT, LARGEST = 1e6, 3.0


def of(amplitudes: list[float], counts: list[float]) -> LoadCycles:
    return LoadCycles(2 * np.array(amplitudes, float), np.zeros(len(amplitudes)), np.array(counts, float))


def test_the_normal_shape_is_rayleighs_and_the_straight_line_exponential() -> None:
    """H/H_0 = exp(-S^2/(2 s^2)), s = S_max/sqrt(2 ln H_0); H/H_0 = exp(-S/s), s = S_max/ln H_0."""
    at = np.linspace(0.1, 0.95, 12) * LARGEST
    rayleigh = stats.rayleigh(scale=LARGEST / math.sqrt(2 * math.log(COUNT)))
    exponential = stats.expon(scale=LARGEST / math.log(COUNT))
    for shape, law in (("normal", rayleigh), ("straight-line", exponential)):
        cycles = standard_spectrum(LARGEST, COUNT, EXPONENTS[shape])
        assert cycles.total == pytest.approx(COUNT)
        assert cycles.largest == pytest.approx(2 * LARGEST)
        assert cycles.cumulative_frequency(2 * at) == pytest.approx(
            COUNT * law.sf(at), rel=0.06
        )  # parts of a twentieth of a decade
        assert np.average(cycles.ranges / 2, weights=cycles.counts) == pytest.approx(law.mean(), rel=1e-4)


def test_narrow_band_noise_has_the_normal_shape() -> None:
    """Rainflow cycles of a sum of 400 waves with random phases, in a band of 4 %."""
    random = np.random.default_rng(3)
    t, frequency, phase = np.arange(0.0, 2000.0, 0.04), 1 + 0.04 * (random.random(400) - 0.5), 2 * np.pi * random.random(400)
    z = np.zeros(len(t))
    for f, p in zip(frequency, phase, strict=True):
        z += np.cos(2 * np.pi * f * t + p)
    counted = rainflow(z)
    largest = math.sqrt(2 * math.log(counted.total)) * z.std()
    assert amplitude_distance(counted, standard_spectrum(largest, counted.total, EXPONENTS["normal"])) < 0.02


def test_a_table_is_met_at_its_rows_and_between_them_by_the_logarithm() -> None:
    amplitudes, cumulative = np.array([1.0, 2.0, 4.0]), np.array([1e5, 1e3, 10.0])
    cycles = tabulated_spectrum(amplitudes, cumulative)
    assert cycles.total == pytest.approx(1e5)
    assert amplitudes_at(cycles, cumulative / 1e5 * (1 - 1e-9)) == pytest.approx(amplitudes, rel=0.03)
    assert amplitudes_at(cycles, np.array([0.1]))[0] == pytest.approx(1.5, rel=0.01)  # half the decades
    assert cycles.largest == 8.0


def test_the_distance_of_amplitudes() -> None:
    """All larger by a tenth of the largest: 0.1; one of four cycles larger by 2 of 4: 0.125; twice as many of all: 0."""
    one = of([1.0, 2.0, 4.0], [1.0, 2.0, 1.0])
    assert amplitude_distance(of([1.4, 2.4, 4.4], [1.0, 2.0, 1.0]), one) == pytest.approx(0.1)
    assert amplitude_distance(of([1.0, 2.0, 4.0, 4.0], [1.0, 1.0, 1.0, 1.0]), one) == pytest.approx(0.125)
    assert amplitude_distance(of([1.0, 2.0, 4.0], [5.0, 10.0, 5.0]), one) == pytest.approx(0.0, abs=1e-12)
    assert amplitude_distance(LoadCycles.empty(), one) == math.inf


def test_a_shifted_spectrum_makes_up_for_a_difference() -> None:
    """What is 0.5 too small at each share is asked for 0.5 larger; amplitudes do not fall below zero."""
    target, asked, got = of([2.0, 1.0], [1.0, 3.0]), of([3.0, 1.0], [1.0, 3.0]), of([2.5, 0.5], [2.0, 6.0])
    assert shift_spectrum(target, asked, got).ranges.tolist() == [5.0, 3.0]
    assert shift_spectrum(of([0.2], [4.0]), got, asked).ranges.tolist() == [0.0]
    # Two cycles each stand for half of all: at a quarter and three quarters of them the others differ by 3 and by 1.
    apart = of([5.0, 2.0], [0.3, 0.7]), of([2.0, 1.0], [0.3, 0.7])
    assert shift_spectrum(of([2.0, 1.0], [2.0, 2.0]), *apart).ranges.tolist() == [10.0, 4.0]


def test_shares_of_the_cycles_are_even_and_those_of_few_cycles_by_their_logarithm() -> None:
    shares = cycle_shares(COUNT)
    assert shares[0] == pytest.approx(1e-6, rel=1e-12) and shares[-1] == 1.0 and (np.diff(shares) > 0).all()
    assert np.abs(shares[:, None] - np.arange(1, 401) / 400).min(axis=0).max() < 1e-12
    assert np.diff(shares).max() == pytest.approx(1 / 400, rel=1e-9)
    few = shares[shares < 1 / 400]
    assert few[1:] / few[:-1] == pytest.approx(np.full(len(few) - 1, 1e6 ** (1 / 119)), rel=1e-9)


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
