"""Channels and recordings, and what they refuse."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wucht.errors import InputError
from wucht.measurements.recording import ANGLE, FULL_SCALE, SPEED, Channel, Recording
from wucht.quantities import Unit

T = np.array([0.0, 0.1, 0.3])


def channel(unit="", values=(1.0, 2.0, 4.0), time=T):
    return Channel("r.csv", "x", unit, np.asarray(time), np.asarray(values))


@pytest.mark.parametrize(
    ("given", "unit", "first"),
    [
        ("rpm", SPEED, np.pi / 30),
        ("Hz", SPEED, 2 * np.pi),
        ("deg/s", SPEED, np.pi / 180),
        ("", SPEED, 1.0),
        ("deg", ANGLE, np.pi / 180),
        ("°", ANGLE, np.pi / 180),
        ("mm/s^2", Unit("m/s^2", "acceleration"), 1e-3),
        ("g", Unit("m/s^2", "acceleration"), 9.80665),
        ("g", Unit("kg", "mass"), 1e-3),
        ("kN", Unit("N", "force"), 1e3),
    ],
)
def test_units(given, unit, first):
    found = channel(given).in_si(unit)
    assert found.values == pytest.approx(first * np.array([1, 2, 4]), rel=1e-12)
    assert (found.unit, found.where) == (unit.si, "r.csv: x")


@pytest.mark.parametrize(
    ("given", "unit", "sentence"),
    [
        ("deg", SPEED, "r.csv: x: given 'deg'; must be an angular speed"),
        ("rpm", ANGLE, "given 'rpm'; must be an angle"),
        (
            "blorps",
            ANGLE,
            "'blorps' is no known unit; if the file is wrong, say what its numbers are with the key unit, as in unit = 'rad'",
        ),
        (FULL_SCALE, SPEED, "say of how many rad/s full scale is with the keys scale = NUMBER and unit = 'rad/s'"),
    ],
)
def test_units_of_another_kind(given, unit, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)):
        channel(given).in_si(unit)


@given(factor=st.floats(-1e6, 1e6))
def test_scaled(factor):
    found = channel(FULL_SCALE).scaled(factor, "rpm")
    assert found.unit == "rpm"
    assert found.in_si(SPEED).values == pytest.approx(factor * np.pi / 30 * np.array([1, 2, 4]), rel=1e-12, abs=1e-300)


def test_what_is_said_of_a_channel_counts():
    assert channel("rad/s").corrected().unit == "rad/s"
    assert channel("rad/s").corrected("rpm").in_si(SPEED).values == pytest.approx(np.pi / 30 * np.array([1, 2, 4]))
    turned = channel("rpm").corrected(scale=-2)
    assert (turned.unit, turned.values.tolist()) == ("rpm", [-2, -4, -8])
    assert channel(FULL_SCALE).corrected("rpm", 600).in_si(SPEED).values[0] == pytest.approx(20 * np.pi)
    for said in ({"unit": "rpm"}, {"scale": 600}):
        with pytest.raises(InputError, match=r"a sound file has no units; say of how many .* scale = NUMBER and unit = "):
            channel(FULL_SCALE).corrected(**said).in_si(SPEED)


@pytest.mark.parametrize(
    ("time", "values", "sentence"),
    [
        (T, [1.0, 2.0], "r.csv: x: there must be one value at each time; there are 2 values and 3 times"),
        ([0.0], [1.0], "there must be at least two samples; found 1"),
        ([], [], "there must be at least two samples; found 0"),
        ([0, 1, 1], [1, 2, 3], "the time must increase: sample 3 is at 1 s, the one before it at 1 s"),
        ([0, 2, 1], [1, 2, 3], "the time must increase: sample 3 is at 1 s, the one before it at 2 s; sort the samples"),
        (T, [1, np.nan, np.inf], "the values must be finite numbers: sample 2 is nan, and 1 others are none"),
        ([0, np.nan, 1], [1, 2, 3], "the time must be finite numbers: sample 2 is nan; take"),
        (T, [1, 1e308, -1e308], "the values must be of at most 1e+30, of either sign: sample 2 is 1e+308"),
        ([0, 1, 1e306], [1, 2, 3], "the time must be of at most 1e+30, of either sign: sample 3 is 1e+306"),
        (T, [1j, 2, 3], "the values must be a list of real numbers; this is complex"),
        (T, ["a", "b", "c"], "the values must be a list of real numbers; this is text"),
        (T, [[1], [2], [3]], "the values must be a list of real numbers; this is a table of 2 dimensions"),
        (T, [None, 2, 3], "this is of type object"),
    ],
)
def test_what_is_no_channel(time, values, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)):
        channel("", values, time)


def test_whole_numbers_become_floats():
    assert channel(values=np.array([1, 2, 3], np.int16)).values.dtype == float


def test_a_recording_of_arrays():
    recording = Recording.of("made", T, {"speed": np.array([1.0, 2, 3]), "angle": np.array([1.0, 2])}, {"speed": "rpm"})
    assert recording.names == ("speed", "angle")
    assert recording.channel("speed").unit == "rpm"
    assert recording.channel("speed", SPEED).values[0] == pytest.approx(np.pi / 30)
    with pytest.raises(InputError, match="made: angle: there must be one value at each time"):
        recording.channel("angle")
    with pytest.raises(
        InputError, match=r"made: given 'sped'; there is no such column; did you mean 'speed'[?] known: angle, speed"
    ):
        recording.channel("sped")
