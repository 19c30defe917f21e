"""Orders from records of motions that are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from known_motion import (
    OMEGA,
    ORDERS,
    PERIOD,
    TURN,
    angle_at,
    angle_record,
    channel,
    coefficients,
    pulse_record,
    speed_at,
    speed_record,
    times_of,
    truth,
    uneven,
)
from tests.refusals import refused

from wucht.measurements.order_fit import fit_orders
from wucht.measurements.order_regression import (
    Mean,
    OrderModel,
    initial_fit,
)
from wucht.measurements.shaft_signal import ShaftSignal, speed_signal

TURNS = 7.37
RECORDS = {
    "speed": lambda noise=0.0, seed=1: speed_record(uneven(TURNS, 2000), 0.3 * noise, seed),
    "angle": lambda noise=0.0, seed=1: angle_record(uneven(TURNS, 2000), 0.002 * noise, seed),
    "pulses": lambda noise=0.0, seed=1: pulse_record(TURNS, 64, 5e-5 * noise, seed),
}


@pytest.mark.parametrize("kind", RECORDS)
def test_without_noise_the_orders_are_exact(kind):
    fit = fit_orders(RECORDS[kind](), ORDERS)
    assert coefficients(fit) == pytest.approx(truth(), abs=1e-9)
    assert fit.speed.cosine[3] == fit.speed.sine[3] == 0.0, "an order that is not fitted"
    assert fit.explained_share == pytest.approx(1, abs=1e-12)


@pytest.mark.slow
def test_scatter_of_two_hundred_records_is_the_standard_error():
    fits = [fit_orders(RECORDS["speed"](1.0, seed), ORDERS) for seed in range(200)]
    found = np.array([coefficients(f) for f in fits])
    assert found.std(axis=0) == pytest.approx(fits[0].standard_errors, rel=0.2)
    assert np.cov(found.T)[0, 5:] == pytest.approx(
        fits[0].covariance[0, 5:], abs=0.3 * found[:, 0].std() * found[:, 5:].std(0).max()
    )
    whitened = np.linalg.solve(np.linalg.cholesky(fits[0].covariance), (found - truth()).T)
    assert np.mean(whitened**2) == pytest.approx(1, abs=0.1), "correlations too"
    assert np.mean([f.residual_rms for f in fits]) == pytest.approx(0.3, rel=0.02)


def test_the_angle_is_the_integral_of_the_speed():
    t = np.linspace(0.02, 0.5, 50)
    of_angle = fit_orders(RECORDS["angle"](), ORDERS)
    assert of_angle.angle(t) == pytest.approx(angle_at(t), abs=1e-10)
    of_speed = fit_orders(RECORDS["speed"](), ORDERS)
    assert np.ptp(of_speed.angle(t) - angle_at(t)) < 1e-10
    moved = of_angle.with_origin(0.123)
    assert moved.angle(t) == pytest.approx(angle_at(t), abs=1e-10)


@pytest.mark.parametrize("kind", RECORDS)
def test_about_another_origin_is_a_fit_with_that_origin(kind):
    shaft = RECORDS[kind](1.0)
    moved, fitted = fit_orders(shaft, ORDERS).with_origin(0.35), fit_orders(shaft, ORDERS, origin=0.35)
    assert coefficients(moved) == pytest.approx(coefficients(fitted), abs=1e-9)
    assert moved.covariance == pytest.approx(fitted.covariance, rel=1e-6, abs=1e-12)
    assert moved.standard_errors[0] == fit_orders(shaft, ORDERS).standard_errors[0]
    far = moved.with_origin(100.0).standard_errors
    assert far[2] > 5 * moved.standard_errors[2], "phases far from the record are not known"


@settings(max_examples=25, deadline=None)
@given(shift=st.floats(-5, 5), factor=st.floats(0.05, 20))
def test_invariance_under_a_shift_and_the_unit_of_time(shift, factor):
    t = uneven(TURNS, 300)
    fit = fit_orders(speed_record(t, 0.3), ORDERS)
    values = speed_record(t, 0.3).values
    moved = fit_orders(speed_signal(channel(t + shift, values)), ORDERS, origin=shift)
    assert coefficients(moved) == pytest.approx(coefficients(fit), abs=1e-7)
    slower = fit_orders(speed_signal(channel(t * factor, values / factor)), ORDERS)
    assert coefficients(slower) * factor == pytest.approx(coefficients(fit), abs=1e-7)
    assert slower.covariance * factor**2 == pytest.approx(fit.covariance, rel=1e-4, abs=1e-9)


def test_what_is_left_and_explained():
    t = np.linspace(0, 8 * PERIOD, 4000, endpoint=False)
    fit = fit_orders(speed_record(t, 0.3), [2])
    kept, left = 2.4**2 / 2 + 1.1**2 / 2, (0.3**2 + 0.2**2 + 0.7**2 + 0.4**2 + 0.25**2 + 0.6**2) / 2 + 0.3**2
    assert fit.kept_rms == pytest.approx(np.sqrt(kept), rel=0.01)
    assert fit.residual_rms == pytest.approx(np.sqrt(left), rel=0.03)
    assert fit.explained_share == pytest.approx(kept / (kept + left), rel=0.01)
    assert fit.unit == "rad/s"
    assert [o.order for o in fit.notable(0.05)] == [1, 3, 5]
    assert [o.order for o in fit.notable(0.4)] == [3]
    third = fit.notable(0.4)[0]
    assert third.amplitude == pytest.approx(np.hypot(0.7, 0.4), abs=4 * third.error)
    assert third.share == pytest.approx(third.amplitude**2 / 2 / fit.residual_rms**2, rel=0.01)
    assert [o.order for o in fit.omitted_orders][-1] == 20
    assert [o.order for o in fit_orders(speed_record(t), [2], look_up_to=4).omitted_orders] == [1, 3, 4]


@pytest.mark.parametrize("kind", ["speed", "angle", "pulses"])
def test_an_index_pulse_is_the_zero(kind):
    """Where the shaft stands at 1.1 rad, that is now where phases and the angle begin."""
    shaft = RECORDS[kind]()
    index = times_of(1.1 + TURN * np.arange(7))
    fit = fit_orders(ShaftSignal(shaft.location, shaft.quantity, shaft.time, shaft.values, index), ORDERS)
    assert fit.origin == pytest.approx(index[0], abs=1e-10)
    assert fit.angle(index) == pytest.approx(TURN * np.arange(7), abs=1e-8)
    t = np.linspace(0.1, 0.7, 20)
    assert fit.speed(OMEGA * (t - fit.origin)) == pytest.approx(speed_at(t), abs=1e-7)
    assert fit.warnings == fit_orders(shaft, ORDERS).warnings
    chosen = fit_orders(ShaftSignal(shaft.location, shaft.quantity, shaft.time, shaft.values, index), ORDERS, origin=0.2)
    assert chosen.origin == 0.2
    assert chosen.angle(index) == pytest.approx(TURN * np.arange(7), abs=1e-8)


def test_a_second_index_pulse_in_a_turn():
    shaft = RECORDS["speed"]()
    index = times_of(TURN / 2 * np.arange(10))
    with refused("r.csv: speed: index", given=None):
        fit_orders(ShaftSignal(shaft.location, shaft.quantity, shaft.time, shaft.values, index), ORDERS)


@pytest.mark.parametrize("angle", [1.0, -2.0, 100.0])
def test_the_time_of_an_angle(angle):
    fit = fit_orders(RECORDS["angle"](), ORDERS)
    found = fit.time_of_angle(angle, after=0.3)
    assert 0.3 <= found <= 0.3 + 1.2 * PERIOD
    assert (angle_at(np.array([found]))[0] - angle) / TURN % 1 in (pytest.approx(0, abs=1e-9), pytest.approx(1, abs=1e-9))
    assert fit.time_of_angle(angle) == pytest.approx(fit.time_of_angle(angle, after=fit.origin))


@pytest.mark.parametrize("orders", [[], [0, 1], [1, 1], [1.5], [True]])
def test_orders_that_are_none(orders):
    with refused("orders"):
        fit_orders(RECORDS["speed"](), orders)


def test_orders_that_cannot_be_told_apart():
    """Samples of the same twentieth of each turn, in which orders look like straight lines."""
    t = np.linspace(0, 10 * PERIOD, 20000)
    seen = speed_record(t[(t / PERIOD) % 1 < 0.05])
    with refused("r.csv: speed: orders", "10", given=[1, 2, 3, 4, 5, 6, 7]):
        fit_orders(seen, range(1, 9))


def test_no_speed_at_which_orders_repeat():
    """Noise ten times as large as the speed."""
    t = np.linspace(0, 10, 40000)
    noise = np.random.default_rng(0).standard_normal(len(t))
    with refused("r.csv: speed", given=None):
        fit_orders(speed_signal(channel(t, 5 + 50 * noise)), [1, 2, 3])


def test_a_constant_speed_has_no_orders():
    t = np.linspace(0, 1, 1000)
    fit = fit_orders(speed_signal(channel(t, np.full(1000, OMEGA))), [1, 2])
    assert fit.speed.mean == pytest.approx(OMEGA, rel=1e-12)
    assert fit.speed.amplitudes == pytest.approx(0, abs=1e-12)
    assert fit.warnings == ()
    assert fit.residual_rms < 1e-12


@pytest.mark.parametrize("off", [0.97, 1.03])
@pytest.mark.parametrize("mean", list(Mean))
def test_a_start_far_out_of_phase(off, mean):
    """3 % of 30 turns are nearly a turn, and five of order 5."""
    t = uneven(30, 30 * 60) - 15 * PERIOD
    values = angle_at(t) if mean is Mean.ANGLE else speed_at(t)
    model = OrderModel(np.array(ORDERS), mean)
    theta = initial_fit(model, t, values, off * OMEGA).theta
    assert theta[0] == pytest.approx(OMEGA, rel=1e-6)
