"""Records that cannot hold orders, what is left beside these, and what is to be checked before they are believed."""

import re

import numpy as np
import pytest
from known_motion import OMEGA, ORDERS, PERIOD, TURN, angle_at, channel, pulse_record, speed_at, speed_record, truth, uneven

from wucht.errors import InputError
from wucht.measurements import order_checks
from wucht.measurements.order_checks import (
    OmittedOrder,
    check_outliers,
    drift,
    fit_omitted_orders,
    roughness,
    unexplained_warning,
    warnings_of,
)
from wucht.measurements.order_fit import fit_orders
from wucht.measurements.order_regression import Mean, OrderModel
from wucht.measurements.shaft_signal import angle_signal, speed_signal
from wucht.numerics.fourier_series import FourierSeries


def refused(shaft, sentence, orders=(1, 2)):
    with pytest.raises(InputError, match=re.escape(sentence)) as error:
        fit_orders(shaft, orders)
    assert error.value.location.startswith(shaft.location)


def test_a_record_shorter_than_a_turn():
    t = np.linspace(0, 0.9 * PERIOD, 500)
    refused(speed_record(t), "the record is shorter than a turn (0.9")
    refused(angle_signal(channel(t, angle_at(t), "rad", "angle")), "the record is shorter than a turn (0.9")


def test_a_shaft_that_turns_backwards_or_stands():
    t = np.linspace(0, 1, 500)
    refused(speed_signal(channel(t, -speed_at(t))), "turns backwards (-52.3")
    refused(speed_signal(channel(t, -speed_at(t))), "reverse the sign with the key scale, as in scale = -1")
    refused(angle_signal(channel(t, -angle_at(t), "rad", "angle")), "scale = -1")
    refused(
        speed_signal(channel(t, np.zeros(500))),
        "the shaft stands still: 0 rad/s on average, 0 turns in 1 s; are column and unit",
    )
    back = speed_signal(channel(t, -speed_at(t)).with_scale(-1, "rad/s"))
    assert fit_orders(back, ORDERS).speed.mean == pytest.approx(OMEGA)


def test_a_gap_of_turns():
    t = np.linspace(0, 1, 2000)
    there = (t < 0.3) | (t > 0.3 + 1.2 * PERIOD)
    refused(speed_record(t[there]), "there is a gap of 0.1446 s, 1.2 turns, after 0.29965 s: cut")


def test_a_gap_within_a_turn_is_none():
    t = np.linspace(0, 1, 2000)
    there = (t < 0.3) | (t > 0.3 + 0.8 * PERIOD)
    fit = fit_orders(speed_record(t[there]), ORDERS)
    assert np.concatenate([[fit.speed.mean], fit.cosine, fit.sine]) == pytest.approx(truth(), abs=1e-9)


def test_too_few_samples_a_turn():
    refused(pulse_record(20, 10), "there are 10 samples a turn, and order 5 needs more than 10", [5])
    assert fit_orders(pulse_record(20, 12), ORDERS).cosine[1] == pytest.approx(2.4, abs=1e-9)
    refused(speed_record(np.linspace(0, 20 * PERIOD, 41)), "needs more than 10; are the units of time and speed right?", [5])
    t = np.linspace(0, 1.2 * PERIOD, 8)
    refused(speed_record(t), "and these orders need 9 samples in all", [1, 2, 3])


@pytest.mark.parametrize("unit", ["rad/s", "rpm", ""])
def test_a_sample_that_sticks_out(unit):
    t = np.linspace(0, 7 * PERIOD, 4000)
    factor = TURN / 60 if unit == "rpm" else 1.0
    values = speed_record(t, 0.2).values / factor
    values[1000] = 99999.0
    refused(speed_signal(channel(t, values, unit)), f"sample 1001, at {t[1000]:.6g} s, is an outlier: it is 99999")
    values[2000] = 0.0
    refused(speed_signal(channel(t, values, unit)), "further outliers: 1; take such samples out")
    values[500] = 0.0
    refused(speed_signal(channel(t, values, unit)), "sample 1001, ")  # the farthest, not the first


@pytest.mark.parametrize("noise", [0.0, 0.5, 20.0])
def test_noise_does_not_stick_out(noise):
    for seed in range(5):
        check_outliers(speed_record(uneven(7, 4000), noise, seed))
    check_outliers(speed_signal(channel(np.linspace(0, 1, 1000), np.where(np.arange(1000) == 5, 50.1, 50.0))))


def residual_of(values, t, orders=(1,), mean=Mean.SPEED):
    model = OrderModel(np.array(orders), mean)
    theta = np.zeros(model.size)
    theta[0] = OMEGA
    return model, model.normal_equations(t, values, theta)


def test_each_order_alone():
    t = uneven(9, 4000) - 4.5 * PERIOD
    rest = 0.5 * np.cos(3 * OMEGA * t) - 1.2 * np.sin(3 * OMEGA * t)
    model, fit = residual_of(OMEGA + rest, t)
    second, third = fit_omitted_orders(model, fit, t, OMEGA + rest, np.array([2, 3]), len(t))
    assert (second.order, third.order) == (2, 3)
    assert third.amplitude == pytest.approx(1.3, rel=1e-9)
    assert third.share == pytest.approx(1, rel=2e-3)
    assert second.share < 1e-3
    assert third.error == pytest.approx((2 * fit.variance / len(t)) ** 0.5)


def test_of_an_angle_in_speed():
    t = uneven(9, 4000) - 4.5 * PERIOD
    angles = OMEGA * t + 0.01 * np.sin(3 * OMEGA * t)
    model, fit = residual_of(angles, t, mean=Mean.ANGLE)
    (third,) = fit_omitted_orders(model, fit, t, angles, np.array([3]), len(t))
    assert third.amplitude == pytest.approx(0.01 * 3 * OMEGA, rel=1e-9)
    assert third.error == pytest.approx(3 * OMEGA * (2 * fit.variance / len(t)) ** 0.5)


def test_white_noise_holds_no_order():
    t = uneven(9, 20000) - 4.5 * PERIOD
    values = OMEGA + np.random.default_rng(0).standard_normal(len(t))
    model, fit = residual_of(values, t)
    found = fit_omitted_orders(model, fit, t, values, np.arange(2, 40), len(t))
    assert max(o.share for o in found) < 1e-3
    assert np.mean([(o.amplitude / o.error) ** 2 for o in found]) == pytest.approx(2, abs=1.2)


def test_nothing_left():
    t = uneven(3, 100)
    model, fit = residual_of(np.full(100, OMEGA), t)
    assert fit_omitted_orders(model, fit, t, np.full(100, OMEGA), np.array([2]), 100) == ()
    assert fit_omitted_orders(model, fit, t, np.full(100, OMEGA), np.array([], int), 100) == ()
    assert drift(model, fit, t, np.full(100, OMEGA)) == (0.0, 0.0)


@pytest.mark.parametrize("mean", [Mean.SPEED, Mean.ANGLE])
def test_a_drift(mean):
    t = uneven(20, 20000) - 10 * PERIOD
    rise = 1.5 / np.ptp(t)
    values = OMEGA + rise * t if mean is Mean.SPEED else OMEGA * t + rise * t**2 / 2 - np.mean(rise * t**2 / 2)
    model, fit = residual_of(values, t, mean=mean)
    found, share = drift(model, fit, t, values)
    assert found == pytest.approx(1.5, rel=1e-3)
    assert share == pytest.approx(1, rel=1e-2)


def test_roughness():
    t = uneven(20, 4000) - 10 * PERIOD
    noise = np.random.default_rng(0).standard_normal(len(t))
    for rest, expected in ((noise, 2.0), (np.cos(0.4 * OMEGA * t), 0.0), (np.zeros(len(t)), 2.0)):
        model, fit = residual_of(OMEGA + rest, t)
        assert roughness(model, fit, t, OMEGA + rest) == pytest.approx(expected, abs=0.1)


QUIET = (0.0, 0.0)
FIRST = FourierSeries.of(100.0, [0.6], [0.8])  # 1 % of order 1


def test_order_one_is_kept():
    (text,) = warnings_of(FIRST, (1,), np.array([0.1]), (), QUIET)
    assert text == (
        "Order 1 is 1 % of the speed and is kept. An encoder off centre by 1 % of its radius shows the same: check its "
        "run-out, or read it with two heads opposite each other, before it is corrected for."
    )


@pytest.mark.parametrize(("error", "count"), [(0.3, 1), (0.4, 0)])
def test_only_above_three_standard_errors(error, count):
    assert len(warnings_of(FIRST, (1,), np.array([error]), (), QUIET)) == count
    left = (OmittedOrder(1, 1.0, error, 0.5),)
    assert len(warnings_of(FourierSeries.of(100.0, [0, 0, 1]), (3,), np.array([0.1]), left, QUIET)) == count


def test_rounding_is_no_order():
    assert warnings_of(FourierSeries.of(100.0, [1e-10]), (1,), np.array([0.0]), (), QUIET) == ()
    assert len(warnings_of(FourierSeries.of(100.0, [1e-6]), (1,), np.array([0.0]), (), QUIET)) == 1


def test_order_two_is_kept():
    """The output of a cardan joint bent by beta has order 2 of about beta^2/2 of the speed."""
    beta, x = np.radians(10), 2 * np.pi * np.arange(64) / 64
    ratio = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.cos(x) ** 2)
    speed = FourierSeries.from_samples(100 * ratio)
    (text,) = warnings_of(FourierSeries(100.0, speed.cosine[:2], speed.sine[:2]), (2,), np.array([1e-3]), (), QUIET)
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
    left = (OmittedOrder(1, 1.0, 0.1, 0.5),)
    (text,) = warnings_of(FourierSeries.of(100.0, [0, 3]), (), np.array([]), left, QUIET)[:1]
    assert text.startswith(
        "Order 1 is left out, but the record holds 1 % of the speed in it. If the shaft really turns like this, a correction "
        "without it leaves about 9 % of the motion as it was. An encoder off centre by 1 %"
    )
    assert text.endswith("before it is left out.")
    small = (OmittedOrder(1, 0.05, 0.01, 0.5), OmittedOrder(2, 0.05, 0.01, 0.5))
    assert warnings_of(FourierSeries.of(100.0, [0, 0, 3]), (3,), np.array([0.1]), small, QUIET) == ()


def test_of_records():
    """Orders 1 (0.7 %) and 2 (5 %) of the known motion."""
    shaft = speed_record(uneven(7.37, 3000), 0.1)
    kept = fit_orders(shaft, [1, 2, 3, 5]).warnings
    assert [w[:22] for w in kept] == ["Order 1 is 0.68 % of t", "Order 2 is 5 % of the "]
    without = fit_orders(shaft, [2, 3, 5]).warnings
    assert without[0].startswith("Order 1 is left out, but the record holds 0.6")
    assert fit_orders(speed_record(uneven(7.37, 3000), 0.1, motion=FourierSeries.of(OMEGA, [0, 0, 2])), [3]).warnings == ()


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
        (0.02, SMOOTH, (OmittedOrder(1, 1.0, 0.1, 0.3), OmittedOrder(7, 1.0, 0.1, 0.3)), 0.0, 0),
        (0.02, SMOOTH, (OmittedOrder(1, 1.0, 0.5, 0.6),), 0.0, 1),
        (0.02, SMOOTH, (), 0.6, 0),
    ],
)
def test_a_fluctuation_that_nothing_explains(explained, rough, left, drifted, count):
    texts = unexplained_warning(explained, rough, left, drifted)
    assert len(texts) == count
    assert all(t.startswith("The orders kept explain 2 % of the fluctuation") for t in texts)


def test_the_mean_of_a_residual_is_no_roughness(monkeypatch):
    """Of +1, -1, +1, -1, +1, -1 the differences have the mean square 4, the values 1, whatever is added to them."""
    for mean in (0.0, 7.0):
        rest = mean + np.array([1.0, -1.0] * 3)
        monkeypatch.setattr(order_checks, "_rest", lambda *_, rest=rest: rest)
        assert roughness(None, None, None, None) == pytest.approx(4.0)
