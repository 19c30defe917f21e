"""Zeros on a grid: all of them, to the last bit, in few evaluations."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from wucht.numerics.zeros_and_peaks import (
    crossings,
    envelope,
    fewest_where,
    first_where,
    interval_maxima,
    interval_peaks,
)


def test_crossings() -> None:
    grid = np.linspace(0.0, 10.0, 41)
    assert crossings(np.sin, grid) == pytest.approx([math.pi, 2 * math.pi, 3 * math.pi], rel=1e-15)
    assert crossings(np.sin, grid, -1) == pytest.approx([math.pi, 3 * math.pi], rel=1e-15)
    assert crossings(np.sin, grid, 1) == pytest.approx([2 * math.pi], rel=1e-15)
    assert crossings(lambda x: x - 2.5, grid) == pytest.approx([2.5])  # a point of the grid
    assert len(crossings(np.zeros_like, grid)) == len(crossings(np.ones_like, grid)) == 0
    assert len(crossings(lambda x: (x - 2.5) ** 2, grid)) == 0


@pytest.mark.parametrize(
    ("function", "zero"),
    [
        (lambda x: x**3 - 2, 2 ** (1 / 3)),
        (lambda x: np.exp(-x) - 1e-3, math.log(1e3)),
        (lambda x: 1e-300 * (x - 2.2), 2.2),
        (lambda x: (x - 3.3) ** 5, 3.3),
        (lambda x: 1 / (x - 3.3), 3.3),  # a pole
        (lambda x: np.sign(x - 1.2345), 1.2345),
        (lambda x: np.where(x < 2.1, -1e-20, 1e20), 2.1),
    ],
)
def test_to_the_last_bit(function, zero) -> None:
    assert crossings(function, np.linspace(0.05, 12.1, 37)) == pytest.approx([zero], rel=5e-16)


@pytest.mark.parametrize("samples_a_period", [12, 48])
def test_peaks_between_samples_of_a_vibration(samples_a_period):
    """cos^2 with its slope: the cubic misses the peak by (dt)^4/384 of the fourth derivative 8 w^4, the samples by far more."""
    step = 2 * np.pi / samples_a_period
    t = np.arange(0, 40, step) + 0.4 * step
    largest = interval_peaks(t, np.cos(t) ** 2, -np.sin(2 * t))[2:-2].max()
    assert abs(largest - 1) <= 8 * step**4 / 384 * 1.05
    assert abs(largest - 1) < abs((np.cos(t) ** 2).max() - 1)


def test_the_largest_between_any_two_samples_is_that_of_their_cubic():
    """However values and slopes lie to each other: looked for at five hundred places of each of a thousand intervals."""
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.2, 2.0, 1001))
    signal, slope = rng.normal(size=(2, 1001))
    places = time[:-1] + np.linspace(0.0, 1.0, 501)[:, None] * np.diff(time)
    expected = CubicHermiteSpline(time, signal, slope)(places).max(axis=0)
    assert interval_maxima(time, signal, slope) == pytest.approx(expected, abs=1e-4)


def test_the_envelope_of_a_modulated_vibration():
    """|A(t) cos(w t)|, A = 1 + 0.3 sin(w t/40): valleys of half a period are filled, the modulation stays."""
    w = 50.0
    t = np.linspace(0, 40, 80_001)
    slow = 1 + 0.3 * np.sin(w / 40 * t)
    line = envelope(t, np.abs(slow * np.cos(w * t)), np.full_like(t, np.pi / w))
    inside = slice(200, -200)
    assert np.abs(line - slow)[inside].max() < 0.3 / 40 * np.pi  # what A changes within half a period
    assert line[inside].min() == pytest.approx(0.7, abs=2e-3)
    assert line[inside].max() == pytest.approx(1.3, abs=2e-3)
    assert (line >= np.abs(slow * np.cos(w * t)) - 1e-15).all()


@pytest.mark.parametrize("phase", [0.0, 1.0, np.pi / 2])
def test_the_envelope_is_right_to_both_ends_wherever_they_cut_the_vibration(phase):
    t = np.linspace(0, 10, 2001)
    line = envelope(t, np.abs(np.cos(30 * t + phase)), np.full_like(t, np.pi / 30))
    assert line.min() > 1 - (30 * 0.005) ** 2 / 8


@pytest.mark.parametrize("turned", [1, -1])
def test_the_envelope_of_a_growing_or_decaying_vibration_goes_on_as_high_as_its_outermost_peak(turned):
    t, step = np.linspace(0, 10, 2001), np.pi / 30
    slow = np.exp(turned * 0.05 * t)
    line = envelope(t, slow * np.abs(np.cos(30 * t + 1)), np.full_like(t, step))
    assert np.abs(line / slow - 1).max() < 0.05 * 2 * step + (30 * 0.005) ** 2 / 8


def test_the_envelope_against_a_direct_search():
    draw = np.random.default_rng(3)
    t = np.linspace(0, 1, 200)
    radius, window = draw.random(200), draw.uniform(0, 0.2, 200)
    half = np.ceil(window / 2 / (t[1] - t[0])).astype(int)

    def reach(i):
        return slice(max(i - half[i], 0), min(i + half[i], 199) + 1)

    highest = np.array([radius[reach(i)].max() for i in range(200)])
    lowest = np.array([highest[reach(i)].min() for i in range(200)])
    inside = slice(2 * half.max(), -2 * half.max())  # beyond it the ends are seen
    assert np.array_equal(envelope(t, radius, window)[inside], lowest[inside])


@pytest.mark.parametrize("border", [0.3, 1.0, 7.25])
def test_the_first_number_from_which_a_condition_holds(border: float) -> None:
    assert first_where(lambda x: x >= border, 0.0, 10.0) == border
    assert first_where(lambda x: x > border, 0.0, 10.0) == np.nextafter(border, 10.0)
    assert [fewest_where(lambda n, least=least: n >= least, 0, 9) for least in (1, 2, 5, 9)] == [1, 2, 5, 9]
