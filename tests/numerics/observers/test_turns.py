"""Averages over turns remove the ripple within a turn and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from wucht.numerics.observers.turns import MARKS_PER_TURN, Samples, TurnObserver, interpolate, shares_at_values

CUBIC = np.polynomial.Polynomial([0.3, -1.2, 0.7, 2.5])
UNIT = np.array([0.0, 1.0])


def hermite(at, x, y, slope):
    """At points, by the samples around each, or by the outermost ones."""
    i = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    return interpolate((at - x[i]) / (x[i + 1] - x[i]), x, y, slope, i)


def test_cubics_are_exact_and_go_on_beyond_the_ends():
    x = np.array([-1.0, -0.4, 0.1, 0.15, 2.0])
    at = np.array([-1.3, -1.0, -0.7, -0.4, 0.0, 0.12, 1.0, 2.0, 2.2])
    both = np.array([CUBIC(x), -2 * CUBIC(x)]), np.array([CUBIC.deriv()(x), -2 * CUBIC.deriv()(x)])
    assert hermite(at, x, CUBIC(x), CUBIC.deriv()(x)) == pytest.approx(CUBIC(at), rel=1e-13, abs=1e-13)
    assert hermite(at, x, *both)[1] == pytest.approx(-2 * CUBIC(at), rel=1e-13, abs=1e-13)


# Of rise 1, and monotone between as long as both are at most 3 (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17, 1980).
SLOPES = [(a, b) for a in (0.0, 1e-9, 0.5, 1.0, 3.0) for b in (0.0, 1e-9, 0.5, 1.0, 3.0)]


@pytest.mark.parametrize(("first", "last"), SLOPES)
@pytest.mark.parametrize("rise", [-3e-4, 5e6])
def test_the_place_where_a_monotone_cubic_has_a_value(first, last, rise):
    wanted = np.array([0.0, 1e-12, 1e-7, 1e-3, 0.1, 1 / 3, 0.5, 0.9, 1 - 1e-3, 1 - 1e-7, 1 - 1e-12, 1.0])
    x, y, slope = np.array([2.0, 2.5]), rise * UNIT, 2 * rise * np.array([first, last])
    i = np.zeros(len(wanted), int)
    share = shares_at_values(rise * wanted, x, y, slope, i)
    assert ((share >= 0) & (share <= 1)).all()
    assert interpolate(share, x, y, slope, i) / rise == pytest.approx(wanted, rel=0, abs=2e-14)


def turns(time, *motions):
    return TurnObserver().update(Samples.of(time, *motions))[1]


def test_the_error_is_of_fourth_order_in_the_sampling_interval():
    errors = []
    for samples_a_turn in (12.382, 24.382, 48.382, 96.382):  # out of step, so that errors do not repeat and cancel
        t = np.arange(0, 1200, 2 * np.pi / samples_a_turn)
        averaged = turns(t, (t + 0.2 * np.sin(t), 1 + 0.2 * np.cos(t)))
        errors.append(np.abs(averaged.speed - 1.0).max())
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert order == pytest.approx(4.0, abs=0.2)


def test_a_sample_hardly_before_a_mark_is_at_it():
    """Within 1e-9 of the way from mark to mark: rounding of the angle must not decide whether a turn is over."""
    step = 2 * np.pi / MARKS_PER_TURN

    def count(last):
        t = np.linspace(-0.5 * step, last, 60)
        return len(turns(t, (t, np.ones_like(t))).time)

    assert count((MARKS_PER_TURN + 2 - 0.7e-9) * step) == count((MARKS_PER_TURN + 2.5) * step) == 3
    assert count((MARKS_PER_TURN + 2 - 1.4e-9) * step) == 2


def test_the_mean_phase_is_that_of_the_trapezoidal_rule():
    """exp(i (other - leading)) = exp(-i t/10) of 2 pi/N + 2 pi: its mean over a turn is known in closed form."""
    t = np.arange(0, 40, 2 * np.pi / 48)
    averaged = turns(t, (t, np.ones_like(t)), (0.9 * t, np.full_like(t, 0.9)))
    half = 0.1 * np.pi / MARKS_PER_TURN  # of what the phase turns from mark to mark
    exact = np.exp(-0.1j * averaged.middle) * np.sin(0.1 * np.pi) / (MARKS_PER_TURN * np.tan(half))
    assert np.abs(averaged.phases[0] - exact).max() < 1e-12


def test_a_body_that_turns_back_begins_anew():
    """phi = 40 sin(t/10): 40 rad on, 80 back, 80 on."""
    t = np.linspace(0, 25 * np.pi, 20_001)
    averaged = turns(t, (40 * np.sin(t / 10), 4 * np.cos(t / 10)))
    assert [int((averaged.passage == k).sum()) for k in range(3)] == [
        int(radians * MARKS_PER_TURN / (2 * np.pi)) - MARKS_PER_TURN for radians in (40, 80, 80)
    ]
    assert (np.sign(averaged.speed) == 1 - 2 * (averaged.passage % 2)).all()
    back = averaged.passage == 1
    assert averaged.time[back].min() > 5 * np.pi
    assert averaged.time[back].max() < 15 * np.pi
    assert np.array_equal(np.unique(averaged.passage), [0, 1, 2])


def with_distance(t, square, rate):
    samples = replace(Samples.of(t, (t, np.ones_like(t))), square=square, rate=rate)
    return TurnObserver().update(samples)[1]


def test_the_largest_distance_in_a_turn_is_of_fourth_order():
    """Of r^2 = 1 + cos(2.3 t)/2, which has maxima in every turn: off by h^4/384 of half of 2.3^4 at the most."""
    for samples_a_turn in (24.382, 48.382, 96.382):
        h = 2.3 * 2 * np.pi / samples_a_turn
        t = np.arange(0, 1200, 2 * np.pi / samples_a_turn)
        averaged = with_distance(t, 1 + 0.5 * np.cos(2.3 * t), -1.15 * np.sin(2.3 * t))
        error = np.abs(averaged.largest - np.sqrt(1.5)).max()
        assert error < h**4 / 384 / 2 / (2 * np.sqrt(1.5)) * 1.05
    assert error > 0.2 * h**4 / 384 / 2 / (2 * np.sqrt(1.5))


def test_a_peak_counts_in_the_turns_that_it_lies_in():
    """At t = 50.03 between two samples, far from a mark."""
    t = np.linspace(0, 100, 2001)
    peak = 8 * np.exp(-(((t - 50.03) / 0.05) ** 2))
    averaged = with_distance(t, 1 + peak, -800 * (t - 50.03) * peak)
    inside = (averaged.time > 50.03) & (averaged.time - 2 * np.pi / averaged.speed < 50.03)
    assert inside.sum() == MARKS_PER_TURN
    assert averaged.largest[inside] == pytest.approx(3.0, rel=0.02)
    assert averaged.largest[~inside].max() < 1.01
