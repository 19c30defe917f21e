"""Sentences about orders that a sensor may fake."""

import numpy as np
import pytest
from known_motion import OMEGA, PERIOD, channel, speed_record, uneven

from wucht.measurements.order_fit import fit_orders
from wucht.measurements.order_residual import LeftOutOrder
from wucht.measurements.order_warnings import unexplained_warning, warnings_of
from wucht.measurements.shaft_signal import speed_signal
from wucht.numerics.harmonics import Harmonics

QUIET = (0.0, 0.0)
FIRST = Harmonics.of(100.0, [0.6], [0.8])  # 1 % of order 1


def test_order_one_is_kept():
    (text,) = warnings_of(FIRST, (1,), np.array([0.1]), (), QUIET)
    assert text == (
        "Order 1 is 1 % of the speed and is kept. An encoder off centre by 1 % of its radius shows the same: check its "
        "run-out, or read it with two heads opposite each other, before it is corrected for."
    )


@pytest.mark.parametrize(("error", "count"), [(0.3, 1), (0.4, 0)])
def test_only_above_three_standard_errors(error, count):
    assert len(warnings_of(FIRST, (1,), np.array([error]), (), QUIET)) == count
    left = (LeftOutOrder(1, 1.0, error, 0.5),)
    assert len(warnings_of(Harmonics.of(100.0, [0, 0, 1]), (3,), np.array([0.1]), left, QUIET)) == count


def test_rounding_is_no_order():
    assert warnings_of(Harmonics.of(100.0, [1e-10]), (1,), np.array([0.0]), (), QUIET) == ()
    assert len(warnings_of(Harmonics.of(100.0, [1e-6]), (1,), np.array([0.0]), (), QUIET)) == 1


def test_order_two_is_kept():
    """The output of a cardan joint bent by beta has order 2 of about beta^2/2 of the speed."""
    beta, x = np.radians(10), 2 * np.pi * np.arange(64) / 64
    ratio = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.cos(x) ** 2)
    speed = Harmonics.sampled(100 * ratio)
    (text,) = warnings_of(Harmonics(100.0, speed.cosine[:2], speed.sine[:2]), (2,), np.array([1e-3]), (), QUIET)
    assert text == (
        "Order 2 is 1.5 % of the speed and is kept. A cardan (universal) joint bent by 10 deg between shaft and encoder shows "
        "the same: check how the encoder is coupled, before it is corrected for."
    )


def test_an_eccentric_encoder_shows_what_is_said():
    """Read at one place, a disk of radius R off centre by e shows an angle that is wrong by (e/R) sin of it."""
    t = np.linspace(0, 8 * PERIOD, 4000)
    read = OMEGA * (1 + 0.02 * np.cos(OMEGA * t))  # e/R = 0.02
    fit = fit_orders(speed_signal(channel(t, read)), [1])
    assert "off centre by 2 % of its radius" in fit.warnings[0]


def test_order_one_is_left_out():
    left = (LeftOutOrder(1, 1.0, 0.1, 0.5),)
    (text,) = warnings_of(Harmonics.of(100.0, [0, 3]), (), np.array([]), left, QUIET)[:1]
    assert text.startswith(
        "Order 1 is left out, but the record holds 1 % of the speed in it. If the shaft does turn so, a correction without it "
        "leaves about 9 % of the motion as it was. An encoder off centre by 1 %"
    )
    assert text.endswith("before it is left out.")
    small = (LeftOutOrder(1, 0.05, 0.01, 0.5), LeftOutOrder(2, 0.05, 0.01, 0.5))
    assert warnings_of(Harmonics.of(100.0, [0, 0, 3]), (3,), np.array([0.1]), small, QUIET) == ()


def test_of_records():
    """Orders 1 (0.7 %) and 2 (5 %) of the known motion."""
    shaft = speed_record(uneven(7.37, 3000), 0.1)
    kept = fit_orders(shaft, [1, 2, 3, 5]).warnings
    assert [w[:22] for w in kept] == ["Order 1 is 0.68 % of t", "Order 2 is 5 % of the "]
    without = fit_orders(shaft, [2, 3, 5]).warnings
    assert without[0].startswith("Order 1 is left out, but the record holds 0.6")
    assert fit_orders(speed_record(uneven(7.37, 3000), 0.1, motion=Harmonics.of(OMEGA, [0, 0, 2])), [3]).warnings == ()


def test_a_drift_is_told():
    assert "The speed drifts by -2 rad/s" in warnings_of(FIRST, (1,), np.array([9.0]), (), (-2.0, 0.1))[0]
    assert warnings_of(FIRST, (1,), np.array([9.0]), (), (-2.0, 0.04)) == ()
    assert warnings_of(FIRST, (1,), np.array([9.0]), (), (0.09, 0.9)) == ()
    t = np.linspace(0, 20 * PERIOD, 4000)
    fit = fit_orders(speed_signal(channel(t, speed_record(t, 0.1).values + 0.5 * (t / t[-1] - 0.5))), [1, 2, 3, 5])
    assert "drifts by +0.50" in fit.warnings[-1]


SMOOTH, ROUGH = (0.1, 0.01), (2.0, 2.0)


@pytest.mark.parametrize(
    ("explained", "rough", "left", "drifted", "count"),
    [
        (0.02, SMOOTH, (), 0.0, 1),
        (0.02, (1.5, 0.1), (), 0.0, 1),
        (0.6, SMOOTH, (), 0.0, 0),
        (0.02, ROUGH, (), 0.0, 0),
        (0.02, SMOOTH, (LeftOutOrder(1, 1.0, 0.1, 0.3), LeftOutOrder(7, 1.0, 0.1, 0.3)), 0.0, 0),
        (0.02, SMOOTH, (LeftOutOrder(1, 1.0, 0.5, 0.6),), 0.0, 1),
        (0.02, SMOOTH, (), 0.6, 0),
    ],
)
def test_a_fluctuation_that_nothing_explains(explained, rough, left, drifted, count):
    texts = unexplained_warning(explained, rough, left, drifted)
    assert len(texts) == count
    assert all(t.startswith("The orders kept explain 2 % of the fluctuation") for t in texts)
