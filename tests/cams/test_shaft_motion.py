"""The angle of a shaft over the time of a turn: against quadrature, its inverse, and the equation of the paper."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from tests import refusals

from wucht.cams.shaft_motion import ShaftMotion, shaft_motion_over_time, with_period
from wucht.numerics.fourier_series import FourierSeries

OMEGA = 500 * math.pi / 30
TAU = np.linspace(-1, 8, 300)


def shaft(scale=1.0):
    """Orders 2 to 5, a fluctuation of 15 %."""
    return ShaftMotion(FourierSeries.of(OMEGA, [0, 2.4 * scale, scale, 0.5, 0.3], [0, scale, -1.3 * scale, 0.2, 0.4]))


def test_the_angle_is_the_integral_of_the_speed():
    of = shaft()
    for tau in (0.3, 2.0, 5.0):
        assert of.angle(tau) == pytest.approx(quad(lambda x: float(of.speed(x)) / OMEGA, 0, tau, epsabs=1e-13)[0], abs=1e-11)
    assert of.angle(TAU, 1) == pytest.approx(of.speed(TAU) / OMEGA)
    assert of.angle(TAU, 2) == pytest.approx(of.speed(TAU, 1) / OMEGA)
    assert of.angle(0.0) == pytest.approx(0.0, abs=1e-15)
    assert of.angle(TAU + 2 * math.pi) == pytest.approx(of.angle(TAU) + 2 * math.pi)


def test_time_is_the_inverse_of_the_angle_with_its_derivatives():
    of = shaft()
    phi = np.linspace(-10, 10, 500)
    tau, first, second, third = of.time_derivatives(phi)
    assert of.angle(tau) == pytest.approx(phi, abs=4e-15)
    h = 1e-4
    differences = [(of.time_derivatives(phi + h)[k] - of.time_derivatives(phi - h)[k]) / (2 * h) for k in range(3)]
    for found, difference in zip((first, second, third), differences, strict=True):
        assert found == pytest.approx(difference, abs=2e-6)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(-1, 1), min_size=1, max_size=8),
    st.lists(st.floats(-1, 1), min_size=1, max_size=8),
    st.floats(0.02, 0.999),
)
def test_the_inverse_is_found_however_unevenly_the_shaft_turns(a, b, deep):
    """Down to a thousandth of the mean speed."""
    fluctuation = FourierSeries.of(0.0, a, b)
    depth = -fluctuation.bounds[0]
    if depth < 1e-6:
        return
    of = ShaftMotion(FourierSeries.of(1.0, np.array(a) * deep / depth, np.array(b) * deep / depth))
    phi = np.linspace(0, 2 * math.pi, 101)
    assert of.angle(of.time(phi)) == pytest.approx(phi, abs=1e-13)


@pytest.mark.parametrize(("depth", "refused"), [(0.999, False), (1.001, True)])
def test_a_shaft_that_stands_still_or_turns_back_is_refused(depth, refused):
    speed = FourierSeries.of(10.0, [0.0, 10.0 * depth])
    if refused:
        with refusals.refused("speed", "-0.01 rad/s", given=None):
            ShaftMotion(speed)
    else:
        assert ShaftMotion(speed).fluctuation == pytest.approx(2 * depth)


def test_scaled_and_without_an_order():
    of = shaft()
    assert of.with_scaled_fluctuation(1.1).fluctuation == pytest.approx(1.1 * of.fluctuation)
    assert of.without_order(2).speed.amplitudes == pytest.approx(np.where(np.arange(1, 6) == 2, 0, of.speed.amplitudes))


def test_a_speed_over_angle_is_another_one_over_time():
    """The same at each instant; its orders differ in second order: a sixteenth for a quarter of the fluctuation."""
    differences = []
    for scale in (1.0, 0.25):
        over_angle = FourierSeries.of(OMEGA, [0, 2.4 * scale], [0, 0, scale])
        of = shaft_motion_over_time(over_angle, 40)
        assert of.speed(TAU) == pytest.approx(over_angle(of.angle(TAU)), rel=1e-10)
        differences.append(abs(of.speed.cosine[3] + 0j) + abs(of.mean - OMEGA))
    assert differences[1] == pytest.approx(differences[0] / 16, rel=0.1)
    assert shaft_motion_over_time(FourierSeries.of(OMEGA), 3).speed.bounds == pytest.approx((OMEGA, OMEGA))


def test_the_period_of_the_cases():
    """cases.md: J = 2 (1 + 0.3 cos 2 phi), E = 15300: the period of the eigenmotion phi' = sqrt(2 E/J)."""
    phi = 2 * math.pi * np.arange(256) / 256
    over_angle = FourierSeries.from_samples(np.sqrt(2 * 15300 / (2 * (1 + 0.3 * np.cos(2 * phi)))))
    assert 2 * math.pi / shaft_motion_over_time(over_angle, 20).mean == pytest.approx(0.0505045348634485, rel=1e-12)


@pytest.mark.parametrize("mean", [0.1, 300.0])
def test_order_0_is_that_of_the_period_to_a_billionth(mean: float) -> None:
    for off, right in ((0.9e-9, True), (-0.9e-9, True), (1.1e-9, False), (-1.1e-9, False)):
        speed = FourierSeries.of(mean * (1 + off), [0.01 * mean])
        if right:
            assert with_period(speed, 2 * math.pi / mean).mean == speed.mean
        else:
            with refusals.refused("speed.mean", given=speed.mean):
                with_period(speed, 2 * math.pi / mean)
