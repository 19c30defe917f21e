"""What is left when orders are taken out."""

import numpy as np
import pytest
from known_motion import OMEGA, PERIOD, uneven

from wucht.measurements.order_regression import Mean, OrderModel
from wucht.measurements.order_residual import drift, left_out_orders, roughness


def residual_of(values, t, orders=(1,), mean=Mean.SPEED):
    model = OrderModel(np.array(orders), mean)
    theta = np.zeros(model.size)
    theta[0] = OMEGA
    return model, model.at(t, values, theta)


def test_each_order_alone():
    t = uneven(9, 4000) - 4.5 * PERIOD
    rest = 0.5 * np.cos(3 * OMEGA * t) - 1.2 * np.sin(3 * OMEGA * t)
    model, fit = residual_of(OMEGA + rest, t)
    second, third = left_out_orders(model, fit, t, OMEGA + rest, np.array([2, 3]), len(t))
    assert (second.order, third.order) == (2, 3)
    assert third.amplitude == pytest.approx(1.3, rel=1e-9)
    assert third.share == pytest.approx(1, rel=2e-3)
    assert second.share < 1e-3
    assert third.error == pytest.approx((2 * fit.variance / len(t)) ** 0.5)


def test_of_an_angle_in_speed():
    t = uneven(9, 4000) - 4.5 * PERIOD
    angles = OMEGA * t + 0.01 * np.sin(3 * OMEGA * t)
    model, fit = residual_of(angles, t, mean=Mean.ANGLE)
    (third,) = left_out_orders(model, fit, t, angles, np.array([3]), len(t))
    assert third.amplitude == pytest.approx(0.01 * 3 * OMEGA, rel=1e-9)
    assert third.error == pytest.approx(3 * OMEGA * (2 * fit.variance / len(t)) ** 0.5)


def test_white_noise_holds_no_order():
    t = uneven(9, 20000) - 4.5 * PERIOD
    values = OMEGA + np.random.default_rng(0).standard_normal(len(t))
    model, fit = residual_of(values, t)
    found = left_out_orders(model, fit, t, values, np.arange(2, 40), len(t))
    assert max(o.share for o in found) < 1e-3
    assert np.mean([(o.amplitude / o.error) ** 2 for o in found]) == pytest.approx(2, abs=1.2)


def test_nothing_left():
    t = uneven(3, 100)
    model, fit = residual_of(np.full(100, OMEGA), t)
    assert left_out_orders(model, fit, t, np.full(100, OMEGA), np.array([2]), 100) == ()
    assert left_out_orders(model, fit, t, np.full(100, OMEGA), np.array([], int), 100) == ()
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
