"""The normal equations, by finite differences."""

import numpy as np
import pytest
from known_motion import OMEGA, ORDERS, angle_at, speed_at, uneven

from wucht.measurements.order_regression import Mean, OrderModel, powers, scaled_gram, solved

T = uneven(3.3, 3000) - 0.2


def some_theta(model):
    return np.concatenate([[OMEGA], np.full(model.fixed - 1, 0.4), np.linspace(-1, 2, 2 * len(model.orders))])


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
    rows, found = model.rows(T, values, theta), model.at(T, values, theta)
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
    assert fit.converged
    assert fit.theta[0] == pytest.approx(OMEGA, rel=1e-11)
    assert fit.squares < 1e-20 * len(T) * np.abs(values).max() ** 2


def test_few_steps_do_not_converge():
    model = OrderModel(np.array(ORDERS), Mean.SPEED)
    theta = np.append(1.02 * OMEGA, np.zeros(8))
    assert not model.fit(T, speed_at(T), theta, most=1).converged
    assert model.fit(T, speed_at(T), theta).converged


def test_powers():
    phase = np.linspace(-30, 30, 100)
    orders = np.array([1, 2, 5, 6, 20])
    for order, wave in zip(orders, powers(phase, orders), strict=True):
        assert wave == pytest.approx(np.exp(1j * order * phase), abs=1e-13)


def test_columns_of_any_length_are_solved_alike():
    rows = np.random.default_rng(0).standard_normal((3, 50)) * np.array([[1e-9], [1.0], [1e9]])
    wanted = np.array([2e9, -1.0, 3e-9])
    assert solved(rows @ rows.T, rows @ (wanted @ rows)) == pytest.approx(wanted, rel=1e-10)
    correlations, lengths = scaled_gram(np.diag([4.0, 0.0]))
    assert (correlations.tolist(), lengths.tolist()) == ([[1, 0], [0, 0]], [2, 1])
