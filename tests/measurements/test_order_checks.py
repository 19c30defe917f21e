"""Records that cannot hold orders, what is left beside these, and what is to be checked before they are believed."""

import re

import numpy as np
import pytest
from known_motion import OMEGA, ORDERS, PERIOD, TURN, angle_at, channel, pulse_record, speed_at, speed_record, truth, uneven

from wucht.errors import InputError
from wucht.measurements.order_checks import (
    check_outliers,
)
from wucht.measurements.order_fit import fit_orders
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


def test_an_eccentric_encoder_shows_what_is_said():
    """Read at one place, a disk of radius R off centre by e shows an angle that is wrong by (e/R) sin of it."""
    t = np.linspace(0, 8 * PERIOD, 4000)
    read = OMEGA * (1 + 0.02 * np.cos(OMEGA * t))  # e/R = 0.02
    fit = fit_orders(speed_signal(channel(t, read)), [1])
    assert "off centre by 2 % of its radius" in fit.warnings[0]


def test_of_records():
    """Orders 1 (0.7 %) and 2 (5 %) of the known motion."""
    shaft = speed_record(uneven(7.37, 3000), 0.1)
    kept = fit_orders(shaft, [1, 2, 3, 5]).warnings
    assert [w[:22] for w in kept] == ["Order 1 is 0.68 % of t", "Order 2 is 5 % of the "]
    without = fit_orders(shaft, [2, 3, 5]).warnings
    assert without[0].startswith("Order 1 is left out, but the record holds 0.6")
    assert fit_orders(speed_record(uneven(7.37, 3000), 0.1, motion=FourierSeries.of(OMEGA, [0, 0, 2])), [3]).warnings == ()


def test_a_bent_cardan_joint_shows_what_is_said():
    """Its output has order 2 of about beta^2/2 of the speed."""
    beta, t = np.radians(10), np.linspace(0, 8 * PERIOD, 4000)
    read = OMEGA * np.cos(beta) / (1 - np.sin(beta) ** 2 * np.cos(OMEGA * t) ** 2)
    assert "(universal) joint bent by 10 deg" in fit_orders(speed_signal(channel(t, read)), [2]).warnings[0]
