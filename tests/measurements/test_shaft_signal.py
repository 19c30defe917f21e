"""Speed, angle and pulses of one shaft."""

import re

import numpy as np
import pytest
from known_motion import OMEGA, PERIOD, TURN, angle_at, channel, pulse_record, speed_at, speed_record, times_of
from tests.refusals import refused

from wucht.errors import InputError
from wucht.measurements.order_fit import fit_orders
from wucht.measurements.recording import Recording
from wucht.measurements.shaft_signal import (
    angle_signal,
    check_even,
    mean_direction,
    pulse_signal,
    pulse_times,
    shaft_signal,
    speed_signal,
)

SECOND = np.linspace(0, 1, 4001)


@pytest.mark.parametrize("noise", [0.15])
def test_noise_makes_no_pulses(noise):
    x = np.sin(TURN * 10 * SECOND + 1) + noise * np.random.default_rng(0).uniform(-1, 1, len(SECOND))
    found = pulse_times(channel(SECOND, x, "V"))
    assert len(found) == 10
    assert found == pytest.approx((np.arange(1, 11) - 1 / TURN) / 10, abs=noise * 0.05)
    assert len(pulse_times(channel(SECOND, x, "V"), hysteresis=0.0)) > 15, "without hysteresis it does"


@pytest.mark.parametrize(
    ("values", "refusal"),
    [
        (np.full(5, 3.3), refused("r.csv: p", "3.3", given=None, code="constant")),
        ([0, 0, 1, 1, 1], refused("r.csv: p", "1 times", given=None, code="too-few")),
        ([1, 1, 0, 0, 0], refused("r.csv: p", "0 times", given=None, code="too-few")),
    ],
)
def test_no_pulses(values, refusal):
    with refusal:
        pulse_times(channel(np.arange(5.0), np.asarray(values, float), "V", "p"))


@pytest.mark.parametrize("missing", [[20, 21], [3]])
def test_missing_pulses(missing):
    times = np.delete(np.arange(64) / 10, missing)
    before = (missing[0] - 1) / 10
    sentence = (
        f"w: pulses are missing between {before:.6g} s and {(missing[-1] + 1) / 10:.6g} s: the interval is {len(missing) + 1}"
    )
    with pytest.raises(InputError, match=re.escape(sentence)):
        check_even(times, "w")


def test_uneven_turning_is_no_missing_pulse():
    x = TURN / 32 * np.arange(300)
    check_even(x + 0.35 * np.sin(x), "w")  # the speed varies by more than a factor of two
    check_even(np.array([0.0, 1.0, 5.0]), "w")  # too few to tell
    check_even(np.sqrt(np.arange(20.0, 200)), "w")


T = np.linspace(0, 7.37 * PERIOD, 3000)


def test_a_speed():
    shaft = speed_signal(channel(T, speed_at(T) * 30 / np.pi, "rpm"))
    assert shaft.values == pytest.approx(speed_at(T))
    assert (shaft.quantity, shaft.location, shaft.unit) == ("speed", "r.csv: speed", "rpm")
    assert speed_signal(channel(T, speed_at(T), "")).unit == ""
    assert (shaft.format_speed(TURN), speed_signal(channel(T, speed_at(T), "")).format_speed(TURN)) == (
        "60 rpm",
        "6.2832 rad/s",
    )
    assert shaft.speed()[1] is shaft.values
    with refused("r.csv: speed", given="mm", code="dimension"):
        speed_signal(channel(T, speed_at(T), "mm"))


@pytest.mark.parametrize("wraps", [0, 1, 2])
@pytest.mark.parametrize("offset", [0.0, -4.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_an_angle_wrapped_or_not(wraps, offset, sign):
    """Also after two turns each, as four-stroke engines are measured, from 0 or symmetric to it, in both directions."""
    angle = sign * angle_at(T) + 0.3
    given = (angle - offset) % (wraps * TURN) + offset if wraps else angle
    shaft = angle_signal(channel(T, np.degrees(given), "deg", "angle"))
    assert shaft.values - shaft.values[0] == pytest.approx(angle - angle[0], abs=1e-9)
    t, speed = shaft.speed()
    assert t == pytest.approx((T[1:] + T[:-1]) / 2)
    assert speed == pytest.approx(sign * speed_at(t), abs=1e-2)


def test_angles_that_are_refused():
    with refused("r.csv: speed", code="constant"):
        angle_signal(channel(T, np.full(len(T), 2.0), "deg"))
    with refused("r.csv: speed", given="rpm", code="dimension"):
        angle_signal(channel(T, angle_at(T), "rpm"))
    there = (T < 2 * PERIOD) | (T > 2.45 * PERIOD)
    with refused("r.csv: speed", "0.45 turns", "0.239752 s", code="wraps-unclear"):
        angle_signal(channel(T[there], angle_at(T[there]) % TURN, "rad"))


def test_pulses():
    shaft = pulse_record(3, 16)
    assert np.diff(shaft.values) == pytest.approx(TURN / 16)
    assert (shaft.quantity, shaft.values[0]) == ("angle", 0.0)
    assert np.ptp(angle_at(shaft.time) - shaft.values) < 1e-9
    for per_turn in (0, -3, 2.5, True):
        with refused("r.csv: pulses", "pulses per turn"):
            pulse_signal(channel(T, T, "s", "pulses"), per_turn)
    with refused("r.csv: pulses", "missing", given=None, code="pulses-missing"):
        pulse_signal(channel(np.delete(T, 50), np.delete(T, 50), "s", "pulses"), 16)


def test_the_angle_is_zero_at_the_index():
    index = channel(T, np.where((angle_at(T) - 1.0) % TURN < 0.2, 5.0, 0.0), "V", "index")
    for shaft in (
        speed_signal(channel(T, speed_at(T)), index),
        angle_signal(channel(T, angle_at(T), "rad"), index),
        pulse_signal(channel(times_of(TURN / 16 * np.arange(1, 110)), times_of(TURN / 16 * np.arange(1, 110)), "s"), 16, index),
    ):
        assert shaft.index == pytest.approx(times_of(1.0 + TURN * np.arange(len(shaft.index))), abs=T[1])
        t, angle = shaft.angle()
        off = np.array([mean_direction(np.array([a])) for a in angle - angle_at(t) + 1.0])
        assert off == pytest.approx(0, abs=OMEGA * T[1])
        assert np.ptp(angle - angle_at(t)) < 2e-3


RECORD = Recording.of(
    "f.csv",
    T,
    {
        "speed 1": speed_at(T), "Angle": angle_at(T), "pulses": np.sin(16 * angle_at(T)), "index": np.cos(angle_at(T)),
        "n": 30 / np.pi * speed_at(T), "phi": np.degrees(angle_at(T)), "x": T + 1, "drive/speed": speed_at(T),
    },
    {"n": "rpm", "phi": "deg", "x": "mm", "pulses": "V"},
)  # fmt: skip


@pytest.mark.parametrize(
    ("column", "quantity"),
    [("speed 1", "speed"), ("Angle", "angle"), ("n", "speed"), ("phi", "angle"), ("drive/speed", "speed"), ("pulses", "angle")],
)
def test_what_a_column_holds(column, quantity):
    shaft = shaft_signal(RECORD, column, per_turn=16)
    assert (shaft.quantity, shaft.location) == (quantity, f"f.csv: {column}")
    assert shaft.speed()[1].mean() == pytest.approx(OMEGA, rel=0.02)


@pytest.mark.parametrize(
    ("asked", "refusal"),
    [
        (("x",), refused("f.csv: x", "key quantity", "speed", "angle", "pulses", given=None, code="no-quantity")),
        (("pulses",), refused("f.csv: pulses", "pulses_per_turn", given=None, code="missing")),
        (("sped",), refused("f.csv", "did you mean 'speed 1'", given="sped")),
        (("n", None, None, "indx"), refused("f.csv", "index", given="indx")),
        (("n", "angle"), refused("f.csv: n", given="rpm", code="dimension")),
    ],
)
def test_columns_that_are_refused(asked, refusal):
    with refusal:
        shaft_signal(RECORD, *asked)


@pytest.mark.parametrize("unit", ["1/s", "1/sec"])
def test_what_a_second_counts_is_told(unit):
    shaft = shaft_signal(Recording.of("f.csv", T, {"n": speed_at(T) / TURN}, {"n": unit}), "n", "speed")
    assert shaft.values == pytest.approx(speed_at(T))
    (text,) = shaft.warnings
    assert f"{unit!r} does not say whether turns or radians, and is read as turns per second" in text
    assert 'give unit = "rad/s"' in text
    assert text in fit_orders(shaft, [1, 2, 3, 5]).warnings
    radians = shaft_signal(Recording.of("f.csv", T, {"n": speed_at(T)}, {"n": unit}), "n", "speed")
    with refused("f.csv: n", "unit = 'rad/s'", given=None):
        fit_orders(radians, [1, 2, 3, 5])


def test_a_pulse_too_many_and_what_to_do():
    t = np.linspace(0, 2, 4001)
    wave = np.where((8 * t) % 1 < 0.5, 5.0, 0.0)
    wave[1001:1003] = 1.6, 3.2  # a glitch in the middle of a low half
    with refused("r.csv: pulses", "0.1", given=None, code="pulse-too-many"):
        pulse_signal(channel(t, wave, "V", "pulses"), 8, hysteresis=0.1)
    assert len(pulse_signal(channel(t, wave, "V", "pulses"), 8).time) == 16
    times = np.append(np.arange(30) / 10, 1.04)
    times.sort()
    with refused("r.csv: pulses", "1.04 s", given=None, code="pulse-too-many"):
        pulse_signal(channel(times, times, "s", "pulses"), 8)


def test_without_an_index_the_angle_is_as_measured_and_one_of_another_time_is_refused():
    assert angle_signal(channel(T, angle_at(T), "rad")).angle()[1].tolist() == angle_at(T).tolist()
    angle = speed_record(T).angle()[1]
    assert angle[0] == 0 and angle == pytest.approx(angle_at(T) - angle_at(0.0), abs=1e-7)
    with refused("r.csv: speed", code="no-index"):
        speed_signal(channel(T, speed_at(T)), channel(T + 100, np.cos(angle_at(T)), "V", "index")).angle()
