"""The normal equations, by finite differences; and from where they are solved."""

import numpy as np
import pytest
from known_motion import OMEGA, ORDERS, PERIOD, angle_at, speed_at, uneven

from wucht.measurements.order_regression import (
    Mean,
    OrderModel,
    block_means,
    initial_fit,
    least_squares_step,
    mean_speed,
    middle,
    powers,
    scaled_gram,
)

T = uneven(3.3, 3000) - 0.2


def some_theta(model):
    return np.concatenate([[OMEGA], np.full(model.fixed_count - 1, 0.4), np.linspace(-1, 2, 2 * len(model.orders))])


@pytest.mark.parametrize("mean", list(Mean))
def test_the_rows_are_the_derivatives(mean):
    model = OrderModel(np.array(ORDERS), mean)
    theta, values = some_theta(model), np.cos(T)
    rows = model.rows(T, values, theta)
    for i, step in enumerate(1e-6 * np.eye(model.size)):
        slope = (model.rows(T, values, theta - step)[-1] - model.rows(T, values, theta + step)[-1]) / 2e-6
        assert rows[i] == pytest.approx(slope, abs=1e-5)


def test_what_each_mean_is():
    zero = np.zeros(len(T))
    waves = sum(a * np.cos(j * OMEGA * T) for a, j in zip([1.0, 2.0], [1, 3], strict=True))
    linear = [1.0, 2.0, 0.0, 0.0]
    for mean, head, level in (
        (Mean.SPEED, [OMEGA], OMEGA),
        (Mean.ANGLE, [OMEGA, 0.3], OMEGA * T + 0.3),
        (Mean.FREE, [OMEGA, 0.3], 0.3),
    ):
        rest = OrderModel(np.array([1, 3]), mean).rows(T, zero, np.array([*head, *linear]))[-1]
        assert -rest == pytest.approx(level + waves, abs=1e-12)


def test_the_normal_equations_are_those_of_all_rows():
    """However the samples are taken in parts."""
    model = OrderModel(np.array(ORDERS), Mean.ANGLE)
    theta, values = some_theta(model), np.sin(3 * T)
    rows, found = model.rows(T, values, theta), model.normal_equations(T, values, theta)
    assert found.gram == pytest.approx(rows[:-1] @ rows[:-1].T, rel=1e-12, abs=1e-9)
    assert found.gradient == pytest.approx(rows[:-1] @ rows[-1], rel=1e-12, abs=1e-9)
    assert found.squares == pytest.approx(rows[-1] @ rows[-1], rel=1e-12)


@pytest.mark.parametrize("mean", list(Mean))
def test_a_fit_from_near_by(mean):
    model = OrderModel(np.array(ORDERS), mean)
    values = angle_at(T) if mean is Mean.ANGLE else speed_at(T)
    theta = np.zeros(model.size)
    theta[:2] = OMEGA * 1.004, OMEGA if mean is Mean.FREE else 0.0
    fit = model.fit(T, values, theta)
    assert fit.has_converged
    assert fit.theta[0] == pytest.approx(OMEGA, rel=1e-11)
    assert fit.squares < 1e-20 * len(T) * np.abs(values).max() ** 2


def test_few_steps_do_not_converge():
    model = OrderModel(np.array(ORDERS), Mean.SPEED)
    theta = np.append(1.02 * OMEGA, np.zeros(8))
    assert not model.fit(T, speed_at(T), theta, most=1).has_converged
    assert model.fit(T, speed_at(T), theta).has_converged


def test_powers():
    phase = np.linspace(-30, 30, 100)
    orders = np.array([1, 2, 5, 6, 20])
    for order, wave in zip(orders, powers(phase, orders), strict=True):
        assert wave == pytest.approx(np.exp(1j * order * phase), abs=1e-13)


def test_columns_of_any_length_are_solved_alike():
    rows = np.random.default_rng(0).standard_normal((3, 50)) * np.array([[1e-9], [1.0], [1e9]])
    wanted = np.array([2e9, -1.0, 3e-9])
    assert least_squares_step(rows @ rows.T, rows @ (wanted @ rows)) == pytest.approx(wanted, rel=1e-10)
    correlations, lengths = scaled_gram(np.diag([4.0, 0.0]))
    assert (correlations.tolist(), lengths.tolist()) == ([[1, 0], [0, 0]], [2, 1])


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
    theta = initial_fit(model, t, values, off * OMEGA).theta
    assert theta[0] == pytest.approx(OMEGA, rel=1e-6)
