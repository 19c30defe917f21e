"""Numbers that are not what they are said to be: the record repeats at another speed. And numbers that are."""

import re

import numpy as np
import pytest
from known_motion import OMEGA, ORDERS, PERIOD, TURN, angle_at, channel, pulse_record, speed_at, speed_record, times_of, uneven

from wucht.errors import InputError
from wucht.measurements.order_fit import fit_orders
from wucht.measurements.shaft_signal import angle_signal, pulse_signal, speed_signal
from wucht.numerics.fourier_series import FourierSeries

UNITS = {"rad/s": 1.0, "rpm": TURN / 60, "Hz": TURN, "deg/s": TURN / 360}
ANGLES = {"rad": 1.0, "deg": TURN / 360, "rev": TURN}


def refused(shaft, sentence, orders=ORDERS):
    with pytest.raises(InputError, match=re.escape(sentence)) as error:
        fit_orders(shaft, orders)
    assert error.value.location == shaft.location


def suspicions(fit):
    """The warnings that doubt what the numbers are."""
    return [w for w in fit.warnings if "fluctuation" in w or "the speed at which their orders" in w]


def record(t, unit, said, noise=0.2, motion=None, extra=0.0):
    """A speed in one unit under the heading of another."""
    values = (speed_record(t, noise).values if motion is None else speed_record(t, noise, motion=motion).values) + extra
    return speed_signal(channel(t, values / UNITS[unit], said))


@pytest.mark.parametrize("turns", [8, 60])
@pytest.mark.parametrize(("unit", "said"), [("rpm", "rad/s"), ("deg/s", "rpm"), ("rpm", "Hz")])
def test_another_unit_than_the_heading_says(turns, unit, said):
    t = uneven(turns, 100 * turns)
    sentence = (
        f"r.csv: speed: the numbers are stated in {said}, but they repeat as if they were in {unit}: give unit = '{unit}'"
    )
    refused(record(t, unit, said), sentence)
    assert suspicions(fit_orders(record(t, unit, unit), ORDERS)) == []


@pytest.mark.parametrize("unit", ["rpm", "deg/s"])
def test_numbers_without_unit_that_are_no_rad_per_second(unit):
    t = uneven(20, 4000)
    refused(
        record(t, unit, ""),
        f"the numbers have no unit and would be in rad/s, but they repeat as if they were in {unit}: write the unit into the "
        f"heading, as in speed [{unit}], or give unit = '{unit}'",
    )
    assert fit_orders(record(t, unit, unit), ORDERS).speed.mean == pytest.approx(OMEGA, rel=1e-3)


@pytest.mark.parametrize(("unit", "said"), [("deg", "rad"), ("rev", "rad")])
def test_an_angle_in_another_unit(unit, said):
    t = uneven(20, 4000)
    angles = angle_at(t) / ANGLES[unit]
    sentence = f"stated in {said}, but they repeat as if they were in {unit}: give unit = '{unit}'"
    refused(angle_signal(channel(t, angles, said, "angle")), sentence)
    assert suspicions(fit_orders(angle_signal(channel(t, angles, unit, "angle")), ORDERS)) == []


@pytest.mark.parametrize("wrong", [32])
def test_fewer_pulses_a_turn_than_there_are(wrong):
    times = pulse_record(20, 64, 1e-6).time
    sentence = f"the pulses repeat as if there were 64 a turn, not {wrong}: give pulses_per_turn = 64"
    refused(pulse_signal(channel(times, times, "s", "pulses"), wrong), sentence)


@pytest.mark.parametrize("wrong", [128])
def test_more_pulses_a_turn_than_there_are(wrong):
    """They may be right: then the shaft turns with even orders alone, of which some were left out."""
    times = pulse_record(20, 64, 1e-6).time
    (text,) = suspicions(fit_orders(pulse_signal(channel(times, times, "s", "pulses"), wrong), [1, 2, 3, 4, 5]))
    assert f"If the encoder gave 64 pulses a turn, not {wrong}, they would explain 100 %: check pulses_per_turn." in text


def test_pulses_a_turn_that_are_a_little_wrong():
    times = pulse_record(20, 64, 1e-6).time
    (text,) = suspicions(fit_orders(pulse_signal(channel(times, times, "s", "pulses"), 63), ORDERS))
    told = float(re.search(r"check pulses_per_turn, 63; ([\d.]+) of them", text)[1])
    assert told == pytest.approx(64, abs=0.01)
    assert suspicions(fit_orders(pulse_record(20, 64, 1e-6), ORDERS)) == []


@pytest.mark.parametrize("turns", [1.3, 40])
@pytest.mark.parametrize("left_out", [1, 8])
def test_orders_that_were_left_out_are_no_other_speed(turns, left_out):
    """They are nearly all of the fluctuation; told elsewhere."""
    amplitudes = np.array([0.0, 0.0, 0.3, 0.0, 0.3, 0.0, 0.0, 0.0])
    amplitudes[left_out - 1] = 4.0
    motion = FourierSeries.of(OMEGA, amplitudes)
    t = uneven(turns, int(200 * turns))
    fits = [fit_orders(record(t, "rpm", "rpm", 0.05, motion), [3, 4, 5])]
    fits.append(fit_orders(angle_signal(channel(t, angle_at(t, motion), "rad", "angle")), [3, 4, 5]))
    times = times_of(TURN / 64 * np.arange(1, int(64 * turns)), motion)
    fits.append(fit_orders(pulse_signal(channel(times, times, "s", "pulses"), 64), [3, 4, 5]))
    for fit in fits:
        assert suspicions(fit) == []
        assert max(fit.omitted_orders, key=lambda o: o.share).order == left_out


@pytest.mark.parametrize("teeth", [12, 19, 60])
def test_a_toothed_wheel_is_no_other_speed(teeth):
    """19 teeth are nearly two turns of a shaft whose rpm are read as rad/s, 12 and 24 of one whose deg/s are read as rpm."""
    t = np.linspace(0, 20 * PERIOD, 6000)
    for said in UNITS:
        shaft = record(t, said, said, 0.05, extra=6 * np.cos(teeth * OMEGA * t))
        assert fit_orders(shaft, [1, 2, 3, 4, 5]).speed.mean == pytest.approx(OMEGA, rel=1e-3)


@pytest.mark.parametrize("ratio", [0.98, 1.01])
@pytest.mark.parametrize("turns", [20, 300])
def test_a_sensor_of_wrong_scale(ratio, turns):
    t = uneven(turns, turns * 80)
    values = speed_record(t, 0.2).values
    (text,) = suspicions(fit_orders(speed_signal(channel(t, ratio * values)), ORDERS))
    told = float(re.search(r"numbers is ([\d.]+) times", text)[1])
    assert told == pytest.approx(ratio, rel=2e-4)
    assert f"multiply the numbers by {1 / told:.3g}"[:-1] in text
    factor = float(re.search(r"by ([\d.]+) \(key scale\)", text)[1])
    mended = fit_orders(speed_signal(channel(t, ratio * values).correct(scale=factor)), ORDERS)
    assert suspicions(mended) == []
    assert mended.cosine[1] == pytest.approx(2.4, rel=0.05)


@pytest.mark.parametrize("share", [0.005, 0.02])
@pytest.mark.parametrize("turns", [7.4, 60])
def test_a_drift_is_no_wrong_scale(turns, share):
    t = uneven(turns, int(400 * turns))
    fit = fit_orders(speed_signal(channel(t, speed_at(t) + share * OMEGA * (t / t[-1] - 0.5))), ORDERS)
    assert suspicions(fit) == []
    assert any("The speed drifts by +" in w for w in fit.warnings)


def test_a_belt_is_told():
    """It turns with no whole order: which is no other unit, but not what the cam can be made for, either."""
    t = np.linspace(0, 20 * PERIOD, 6000)
    shaft = record(t, "rpm", "rpm", 0.05, extra=6 * np.cos(0.37 * OMEGA * t))
    (text,) = suspicions(fit_orders(shaft, ORDERS))
    assert text.startswith(
        "The orders kept explain 19 % of the fluctuation, and the rest is neither noise from sample to sample"
    )
    assert "Check unit and scale" in text
