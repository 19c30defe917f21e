"""Steady, modulated or in transition: on signals whose future is known."""

import math

import numpy as np
import pytest

from wucht.numerics.steadiness import modulation, trend


def approach(time_constant, height=1.0, n=2000, until=1.0):
    t = np.linspace(0, until, n, endpoint=False)
    return (height * np.exp(-t / time_constant))[None, :].astype(complex)


@pytest.mark.parametrize("time_constant", [0.05, 0.1, 0.2, 0.5, 1.0, 3.0])
def test_what_an_exponential_approach_still_adds(time_constant):
    """The mean over the last window is what it is at the end times (exp(h/T) - 1) T/h; all that will still go."""
    signal, h = approach(time_constant), 0.1
    left = math.exp(-1 / time_constant) * (math.exp(h / time_constant) - 1) * time_constant / h
    estimate = trend(signal, 1e-9)
    assert estimate.remaining == pytest.approx(left, rel=1e-2)
    assert estimate.change == pytest.approx(left * (math.exp(h / time_constant) - 1), rel=1e-2)


def test_how_many_more_windows_are_needed():
    """After that many windows change and rest together are at the tolerance."""
    time_constant, tolerance = 0.2, 1e-6
    estimate = trend(approach(time_constant), tolerance)
    more = estimate.windows_needed * 0.1
    later = (estimate.change + estimate.remaining) * math.exp(-more / time_constant)
    assert later == pytest.approx(tolerance, rel=1e-2)
    assert not estimate.steady(tolerance)
    assert trend(approach(time_constant, height=1e-6), tolerance).steady(tolerance)
    assert trend(approach(time_constant, height=1e-6), tolerance).windows_needed == 0.0


def test_the_slowest_of_several_signals_counts():
    both = np.concatenate([approach(0.05), approach(0.5)])
    assert trend(both, 1e-3).remaining == pytest.approx(trend(approach(0.5), 1e-3).remaining, rel=1e-9)


def test_a_rotating_signal_is_not_steady():
    """A phase that keeps turning does not contract, however small its modulus of change between samples."""
    t = np.linspace(0, 1, 2000)
    estimate = trend(np.exp(2j * np.pi * t)[None, :], 1e-3)
    assert estimate.remaining > 1e6
    assert not estimate.steady(0.1)


def test_a_constant_is_steady_and_rounding_does_not_matter():
    draw = np.random.default_rng(1)
    noise = 1.0 + 1e-12 * draw.standard_normal((1, 1000))
    estimate = trend(noise, 1e-6)
    assert estimate.steady(1e-6)
    assert estimate.windows_needed == 0.0


@pytest.mark.parametrize("signal", [np.exp(np.linspace(0, 3, 100)), np.linspace(0, 1, 100)], ids=["growth", "ramp"])
def test_growth_and_ramps_have_no_end(signal):
    estimate = trend(signal[None, :], 1e-3)
    assert estimate.remaining > 1e6
    assert not estimate.steady(1e-3)


def test_too_short_a_record_is_unknown():
    assert trend(np.ones((1, 9)), 1e-3).remaining == math.inf


PERIOD = 7.3


def modulated(shape, n=8000, until=100.0, w=3.0):
    """A speed around w with the modulation ``shape(2 pi t/PERIOD)``; the angle is its integral."""
    t = np.linspace(0, until, n)
    signal = w + shape(2 * np.pi * t / PERIOD, t)
    angle = np.concatenate([[0.0], np.cumsum((signal[1:] + signal[:-1]) / 2 * np.diff(t))])
    return t, angle, signal


@pytest.mark.parametrize(
    "shape",
    [
        lambda p, t: 0.5 * np.sin(p),
        lambda p, t: 0.5 * np.sin(p) + 0.2 * np.sin(2 * p + 1) + 0.05 * np.sin(9 * p),
        lambda p, t: 0.5 * np.exp(-4 * (1 - np.cos(p))),
    ],
    ids=["sine", "harmonics", "pulses"],
)
def test_period_range_and_angle_of_a_modulation(shape):
    t, angle, signal = modulated(shape)
    observed = modulation(t, angle, signal, 0.01)
    one_period = modulated(shape, 100_000, PERIOD)[2]
    assert observed.period == pytest.approx(PERIOD, rel=1e-4)
    assert observed.period_angle == pytest.approx(one_period[:-1].mean() * PERIOD, rel=1e-4)
    assert (observed.low, observed.high) == pytest.approx((one_period.min(), one_period.max()), abs=1e-4)
    assert observed.sustained
    assert (t[observed.end - 1] - t[observed.begin]) / PERIOD == pytest.approx(3, abs=0.01)
    assert observed.end <= len(t)


@pytest.mark.parametrize("time_constant", [30, 100, 300])
def test_a_decaying_modulation_is_not_sustained(time_constant):
    observed = modulation(*modulated(lambda p, t: 0.5 * np.exp(-t / time_constant) * np.sin(p)), 0.01)
    assert observed.period == pytest.approx(PERIOD, rel=1e-2)
    assert not observed.sustained


@pytest.mark.parametrize("time_constant", [100, 300])
def test_a_growing_modulation_is_not_sustained(time_constant):
    assert not modulation(*modulated(lambda p, t: 0.1 * np.exp(t / time_constant) * np.sin(p)), 0.01).sustained


def test_a_modulation_that_settles_to_its_range_is_sustained():
    observed = modulation(*modulated(lambda p, t: (0.5 + 0.4 * np.exp(-t / 10)) * np.sin(p)), 0.01)
    assert observed.sustained


def test_no_modulation():
    """Below the threshold, a single oscillation, an approach without one, hardly any samples."""
    assert modulation(*modulated(lambda p, t: 0.004 * np.sin(p)), 0.01) is None
    assert modulation(*modulated(lambda p, t: 0.5 * np.sin(p), until=2 * PERIOD), 0.01) is None
    assert modulation(*modulated(lambda p, t: np.exp(-t / 30)), 0.01) is None
    assert modulation(*modulated(lambda p, t: np.sin(p), n=10), 0.01) is None


def test_small_ripple_does_not_break_the_count():
    """Hysteresis: a ripple of a tenth crosses the middle many times within each period."""
    observed = modulation(*modulated(lambda p, t: 0.5 * np.sin(p) + 0.05 * np.sin(37 * p)), 0.01)
    assert observed.period == pytest.approx(PERIOD, rel=0.02)
