"""Means over blocks, the mean speed, and where the fit starts."""

import numpy as np
import pytest
from known_motion import OMEGA, ORDERS, PERIOD, angle_at, speed_at, uneven

from wucht.measurements.order_regression import Mean, OrderModel
from wucht.measurements.order_start import block_means, mean_speed, middle, start


def test_block_means():
    t = np.arange(10.0)
    times, values = block_means(t, t**2, 3.0)
    assert times.tolist() == [1, 4, 7]
    assert values.tolist() == [5 / 3, 50 / 3, 149 / 3]
    times, values = block_means(t, t**2, 2.0)
    assert (times.tolist(), values.tolist()) == ([0.5, 2.5, 4.5, 6.5, 8.5], [0.5, 6.5, 20.5, 42.5, 72.5])
    same = block_means(t, t**2, 1.5)
    assert same[0] is t, "one sample a block"


def test_no_block_over_a_gap():
    t = np.concatenate([np.arange(10.0), 100 + np.arange(10.0)])
    times, _ = block_means(t, t, 23.0)
    assert times.tolist() == [1.5, 5.5, 103.5, 107.5]


@pytest.mark.parametrize(("turns", "within"), [(2.3, 3e-2), (7.37, 3e-4), (40.4, 1e-5)])
@pytest.mark.parametrize("kind", ["speed", "angle"])
def test_the_mean_speed_hardly_feels_orders(turns, within, kind):
    t = uneven(turns, 4000)
    if kind == "speed":
        found, plain = mean_speed(t, speed_at(t), Mean.SPEED), speed_at(t).mean()
        assert abs(found - OMEGA) < abs(plain - OMEGA)
    else:
        found = mean_speed(t, angle_at(t), Mean.ANGLE)
    assert found == pytest.approx(OMEGA, rel=within)


def test_the_middle():
    t = np.linspace(-1, 1, 21)
    inside, values = middle(t, 2 * t, 0.5)
    assert inside == pytest.approx([-0.2, -0.1, 0, 0.1, 0.2])
    assert (values == 2 * inside).all()


@pytest.mark.parametrize("off", [0.97, 0.995, 1.0, 1.005, 1.03])
@pytest.mark.parametrize("mean", list(Mean))
def test_a_start_far_out_of_phase(off, mean):
    """3 % of 30 turns are nearly a turn, and five of order 5."""
    t = uneven(30, 30 * 60) - 15 * PERIOD
    values = angle_at(t) if mean is Mean.ANGLE else speed_at(t)
    model = OrderModel(np.array(ORDERS), mean)
    theta = start(model, t, values, off * OMEGA).theta
    assert theta[0] == pytest.approx(OMEGA, rel=1e-6)
