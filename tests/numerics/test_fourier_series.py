"""Finite Fourier series: derivatives, extrema, samples, shifts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.numerics.fourier_series import FourierSeries, differentiation, even_angles

X = np.linspace(0, 2 * math.pi, 20001)

coefficient = st.floats(-1, 1)
series = st.integers(1, 9).flatmap(
    lambda n: st.builds(
        FourierSeries.of,
        coefficient,
        st.lists(coefficient, min_size=n, max_size=n),
        st.lists(coefficient, min_size=n, max_size=n),
    )
)


@settings(max_examples=60, deadline=None)
@given(series)
def test_bounds_are_those_of_a_fine_grid_and_lie_on_the_curve(f):
    low, high = f.bounds
    values = f(X)
    curvature = np.abs(f(X, 2)).max() * (X[1] - X[0]) ** 2 / 8
    assert low <= values.min() + 1e-9
    assert high >= values.max() - 1e-9
    assert values.min() - low <= curvature + 1e-9
    assert high - values.max() <= curvature + 1e-9


@settings(max_examples=30, deadline=None)
@given(series, st.floats(-7, 7))
def test_a_shift_moves_the_function(f, by):
    assert np.abs(f.shift(by)(X) - f(X - by)).max() < 1e-9


@pytest.mark.parametrize("count", [19, 20])
def test_samples_give_all_harmonics_below_half_their_number(count):
    f = FourierSeries.of(0.5, np.arange(1.0, 10), np.arange(3.0, 12))
    found = FourierSeries.from_samples(f(2 * math.pi * np.arange(count) / count))
    assert found.count == 9
    assert found.mean == pytest.approx(0.5)
    assert found.cosine == pytest.approx(f.cosine)
    assert found.sine == pytest.approx(f.sine)


@pytest.mark.parametrize("count", [63, 66])
def test_bounds_of_many_harmonics(count):
    """On both sides of where the companion matrix gives way to changes of sign."""
    rng = np.random.default_rng(count)
    f = FourierSeries.of(0.3, rng.normal(size=count), rng.normal(size=count))
    low, high = f.bounds
    values = f(np.linspace(0, 2 * math.pi, 100_001))
    assert 0 <= values.min() - low < 1e-3
    assert 0 <= high - values.max() < 1e-3


def test_extrema_of_a_flat_dwell_are_found_although_its_zeros_are_many_fold():
    """sin^10(x/2): its derivative has a ninefold zero at 0, which a companion matrix scatters."""
    flat = FourierSeries.of(252 / 1024, np.array([-420, 240, -90, 20, -2]) / 1024)
    low, high = flat.bounds
    assert high == pytest.approx(1.0, abs=1e-14)
    assert 0 <= low + 1e-15 < 1e-11


@pytest.mark.parametrize("count", [8, 10])
def test_the_matrix_differentiates_all_waves_below_half_of_its_points(count):
    at, matrix = even_angles(count), differentiation(count)
    for k in range(count // 2):
        assert matrix @ np.cos(k * at) == pytest.approx(-k * np.sin(k * at), abs=1e-13 * count**2)
        assert matrix @ np.sin(k * at) == pytest.approx(k * np.cos(k * at), abs=1e-13 * count**2)
    k = count // 2 + 1  # is taken for that of k = count/2 - 1
    assert np.abs(matrix @ np.cos(k * at) + k * np.sin(k * at)).max() > 1
    assert differentiation(count, 2) @ np.cos((count // 2 - 1) * at) == pytest.approx(
        -((count // 2 - 1) ** 2) * np.cos((count // 2 - 1) * at), abs=1e-13 * count**3
    )


def test_highest_harmonics_that_are_all_small_are_dropped():
    """Below a share of the largest value, the mean included; a small one below a large one stays."""
    f = FourierSeries.of(1.0, [0.5, 1e-9, 0.25, 1e-4, 2e-6], [0.0, 0.0, 0.0, 0.0, 0.0])
    assert [f.without_rounding(share).count for share in (1e-7, 1e-5, 1e-3, 0.3, 0.6)] == [5, 4, 3, 1, 0]
    kept = f.without_rounding(1e-3)
    assert kept.mean == 1.0 and kept.cosine.tolist() == [0.5, 1e-9, 0.25] and kept.sine.tolist() == [0.0] * 3
    small = FourierSeries.of(1e-3, [0.5, 0.0, 1e-4], [0.0, 1e-4, 0.0])
    assert small.without_rounding(1e-3).count == 1 and small.without_rounding(1e-4).count == 3
    for mean in (1000.0, -1000.0):
        assert FourierSeries.of(mean, [0.5], [0.5]).without_rounding(1e-3).count == 0
