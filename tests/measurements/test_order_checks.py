"""Records that cannot hold orders: each in its sentence."""

import re

import numpy as np
import pytest
from known_motion import OMEGA, ORDERS, PERIOD, TURN, angle_at, channel, pulse_record, speed_at, speed_record, truth, uneven

from wucht.errors import InputError
from wucht.measurements.order_fit import fit_orders
from wucht.measurements.shaft_signal import angle_signal, speed_signal


def refused(shaft, sentence, orders=(1, 2)):
    with pytest.raises(InputError, match=re.escape(sentence)) as error:
        fit_orders(shaft, orders)
    assert error.value.where.startswith(shaft.where)


def test_a_record_shorter_than_a_turn():
    t = np.linspace(0, 0.9 * PERIOD, 500)
    refused(speed_record(t), "the record is shorter than a turn (0.9")
    refused(angle_signal(channel(t, angle_at(t), "rad", "angle")), "the record is shorter than a turn (0.9")


def test_a_shaft_that_turns_backwards_or_stands():
    t = np.linspace(0, 1, 500)
    refused(speed_signal(channel(t, -speed_at(t))), "turns backwards (-52.3")
    refused(speed_signal(channel(t, np.zeros(500))), "the shaft stands")
    back = speed_signal(channel(t, -speed_at(t)).scaled(-1, "rad/s"))
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
    t = np.linspace(0, 1.2 * PERIOD, 8)
    refused(speed_record(t), "and these need 9 in all", [1, 2, 3])


@pytest.mark.parametrize(("unit", "factor"), [("rpm", 60 / TURN), ("Hz", 1 / TURN), ("deg/s", 180 / np.pi)])
def test_numbers_without_unit_that_are_no_rad_per_second(unit, factor):
    t = uneven(20, 4000)
    values = speed_record(t, 0.2).values * factor
    refused(
        speed_signal(channel(t, values, "")),
        f"they repeat as if they were {unit}: write the unit into the heading, as in speed [{unit}]",
    )
    assert fit_orders(speed_signal(channel(t, values, unit)), ORDERS).speed.mean == pytest.approx(OMEGA, rel=1e-3)


@pytest.mark.parametrize("noise", [0.0, 0.2, 20.0])
def test_rad_per_second_without_unit(noise):
    t = uneven(20, 4000)
    fit = fit_orders(speed_signal(channel(t, speed_record(t, noise).values, "")), ORDERS)
    assert fit.speed.mean == pytest.approx(OMEGA, abs=max(1e-9, 4 * fit.standard_errors[0]))


def test_a_constant_without_unit():
    t = np.linspace(0, 1, 1000)
    assert fit_orders(speed_signal(channel(t, np.full(1000, OMEGA), "")), [1]).speed.mean == pytest.approx(OMEGA)


@pytest.mark.parametrize("ratio", [0.98, 1.01])
@pytest.mark.parametrize("turns", [20, 300])
def test_a_sensor_of_wrong_scale(ratio, turns):
    t = uneven(turns, turns * 80)
    values = speed_record(t, 0.2).values
    fit = fit_orders(speed_signal(channel(t, ratio * values)), ORDERS)
    (text,) = [w for w in fit.warnings if "scale" in w]
    told = float(re.search(r"numbers is ([\d.]+) times", text)[1])
    assert told == pytest.approx(ratio, rel=2e-4)
    assert f"divide the numbers by {told:.5g}." in text
    mended = fit_orders(speed_signal(channel(t, ratio * values / told)), ORDERS)
    assert not [w for w in mended.warnings if "scale" in w]
    assert mended.cosine[1] == pytest.approx(2.4, rel=0.05)
