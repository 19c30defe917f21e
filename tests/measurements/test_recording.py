"""Channels and recordings, and what they refuse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.refusals import refused

from wucht.measurements.recording import ANGLE_UNIT, FULL_SCALE, SPEED_UNIT, Channel, Recording
from wucht.schema import Unit

T = np.array([0.0, 0.1, 0.3])


def channel(unit="", values=(1.0, 2.0, 4.0), time=T):
    return Channel("r.csv", "x", unit, np.asarray(time), np.asarray(values))


@pytest.mark.parametrize(
    ("given", "unit", "first"),
    [
        ("rpm", SPEED_UNIT, np.pi / 30),
        ("Hz", SPEED_UNIT, 2 * np.pi),
        ("", SPEED_UNIT, 1.0),
        ("°", ANGLE_UNIT, np.pi / 180),
        ("g", Unit("m/s^2", "acceleration"), 9.80665),
        ("g", Unit("kg", "mass"), 1e-3),
    ],
)
def test_units(given, unit, first):
    found = channel(given).to_si(unit)
    assert found.values == pytest.approx(first * np.array([1, 2, 4]), rel=1e-12)
    assert (found.unit, found.location) == (unit.si, "r.csv: x")


@pytest.mark.parametrize(
    ("given", "unit", "refusal"),
    [
        ("deg", SPEED_UNIT, refused("r.csv: x", given="deg", code="dimension")),
        ("rpm", ANGLE_UNIT, refused("r.csv: x", given="rpm", code="dimension")),
        (
            "blorps",
            ANGLE_UNIT,
            refused("r.csv: x", "unit = 'rad'", code="unknown-unit"),
        ),
        (FULL_SCALE, SPEED_UNIT, refused("r.csv: x", "scale = NUMBER", "unit = 'rad/s'", code="full-scale")),
    ],
)
def test_units_of_another_kind(given, unit, refusal):
    with refusal:
        channel(given).to_si(unit)


@given(factor=st.floats(-1e6, 1e6))
def test_scaled(factor):
    found = channel(FULL_SCALE).with_scale(factor, "rpm")
    assert found.unit == "rpm"
    assert found.to_si(SPEED_UNIT).values == pytest.approx(factor * np.pi / 30 * np.array([1, 2, 4]), rel=1e-12, abs=1e-300)


def test_what_is_said_of_a_channel_counts():
    assert channel("rad/s").correct().unit == "rad/s"
    assert channel("rad/s").correct("rpm").to_si(SPEED_UNIT).values == pytest.approx(np.pi / 30 * np.array([1, 2, 4]))
    turned = channel("rpm").correct(scale=-2)
    assert (turned.unit, turned.values.tolist()) == ("rpm", [-2, -4, -8])
    assert channel(FULL_SCALE).correct("rpm", 600).to_si(SPEED_UNIT).values[0] == pytest.approx(20 * np.pi)
    for said in ({"unit": "rpm"}, {"scale": 600}):
        with refused("r.csv: x", "scale = NUMBER", code="full-scale"):
            channel(FULL_SCALE).correct(**said).to_si(SPEED_UNIT)


@pytest.mark.parametrize(
    ("time", "values", "refusal"),
    [
        (T, [1.0, 2.0], refused("r.csv: x", "at each time", given=None, code="count")),
        ([0.0], [1.0], refused("r.csv: x", "two samples", "1", given=None, code="too-few")),
        ([0, 1, 1], [1, 2, 3], refused("r.csv: x", "1 s", given=None, code="not-increasing")),
        (T, [1, np.nan, np.inf], refused("r.csv: x", code="not-finite")),
        ([0, np.nan, 1], [1, 2, 3], refused("r.csv: x", code="not-finite")),
        (T, [1, 1e308, -1e308], refused("r.csv: x", "1e+30", "1e+308", given=None)),
        ([0, 1, 1e306], [1, 2, 3], refused("r.csv: x", "1e+30", "1e+306", given=None)),
        (T, [[1], [2], [3]], refused("r.csv: x", code="no-numbers")),
        (T, [None, 2, 3], refused("r.csv: x", code="no-numbers")),
    ],
)
def test_what_is_no_channel(time, values, refusal):
    with refusal:
        channel("", values, time)


def test_a_recording_of_arrays():
    recording = Recording.of("made", T, {"speed": np.array([1.0, 2, 3]), "angle": np.array([1.0, 2])}, {"speed": "rpm"})
    assert recording.names == ("speed", "angle")
    assert recording.channel("speed").unit == "rpm"
    assert recording.channel("speed", SPEED_UNIT).values[0] == pytest.approx(np.pi / 30)
    with refused("made: angle", given=None, code="count"):
        recording.channel("angle")
    with refused("made", "speed", given="sped"):
        recording.channel("sped")
