"""The table [speed]: what is said of a record, and what is refused."""

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.tables.speed import SpeedTable
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries

SPEED = FourierSeries.of(50.0, [0, 2.4, 1.0], [0, 1.0, -1.3])
T = np.linspace(0, 7.3 * 2 * np.pi / 50, 3000)
GIVEN = {"column": "speed", "orders": (2, 3)}


def write(path, values, heading, time=T):
    np.savetxt(path, np.column_stack([time, values]), delimiter=",", header=f"time [s],{heading}", comments="", fmt="%.12g")


def angle(t):
    j = np.arange(1, SPEED.count + 1)
    x = np.multiply.outer(t, j * SPEED.mean)
    return SPEED.mean * t + (np.sin(x) * SPEED.cosine - np.cos(x) * SPEED.sine) @ (1 / (j * SPEED.mean))


def fitted(folder, name="r.csv", **keys):
    table = SpeedTable(file=name, **(GIVEN | keys))
    fit = table.record_fit(folder)
    assert table.shaft(fit).mean == fit.speed.mean
    return fit


def is_right(fit):
    assert fit.speed.mean == pytest.approx(SPEED.mean, rel=1e-4)
    assert np.hypot(fit.cosine, fit.sine) == pytest.approx(SPEED.amplitudes[1:], rel=1e-3)


@pytest.mark.parametrize("heading", ["speed [rpm]", "speed"])
def test_a_shaft_that_turns_clockwise(tmp_path, heading):
    """Its numbers are negative; what is advised can be written into the file."""
    write(tmp_path / "r.csv", SPEED(50.0 * T) * -30 / np.pi, heading)
    unit = {} if "rpm" in heading else {"unit": "rpm"}
    with refused("r.csv: speed", "scale = -1", given=None, code="turns-back"):
        fitted(tmp_path, **unit)
    is_right(fitted(tmp_path, scale=-1, **unit))


def test_a_unit_that_the_heading_has_wrong(tmp_path):
    write(tmp_path / "r.csv", SPEED(50.0 * T) * 30 / np.pi, "speed [rad/s]")
    with refused("r.csv: speed", "unit = 'rpm'", given=None):
        fitted(tmp_path)
    is_right(fitted(tmp_path, unit="rpm"))
    is_right(fitted(tmp_path, unit="U/min"))
    is_right(fitted(tmp_path, scale="0.10471975512"))


def test_a_sound_file_that_holds_a_speed(tmp_path):
    from scipy.io import wavfile

    rate = 2000
    t = np.arange(int(7.3 * 2 * np.pi / 50 * rate)) / rate
    wavfile.write(tmp_path / "r.wav", rate, np.int16(SPEED(50.0 * t) / 100 * 2**15))
    keys = {"name": "r.wav", "column": "1", "quantity": "speed"}
    with refused("r.wav: 1", "scale = NUMBER", "unit = 'rad/s'", code="full-scale"):
        fitted(tmp_path, **keys)
    is_right(fitted(tmp_path, **keys, scale=100, unit="rad/s"))
    with refused("r.wav: 1", given=None, code="no-quantity"):
        fitted(tmp_path, **(keys | {"quantity": None}))


def test_the_hysteresis_of_pulses(tmp_path):
    t = np.linspace(0, 7.3 * 2 * np.pi / 50, 80_000)
    wave = np.cos(32 * angle(t))
    wave[np.flatnonzero(wave < -0.9)[::3000]] = 0.3  # glitches
    write(tmp_path / "r.csv", wave, "pulses [V]", t)
    keys = {"column": "pulses", "pulses_per_turn": 32}
    with refused("r.csv: pulses", "0.02", given=None, code="pulse-too-many"):
        fitted(tmp_path, **keys, hysteresis=0.02)
    is_right(fitted(tmp_path, **keys, hysteresis=0.4))


@pytest.mark.parametrize(
    ("keys", "where", "sentence"),
    [
        ({"unit": "mm"}, "speed.unit", "must be an angular speed"),
        ({"scale": 0}, "speed.scale", "must not be 0"),
        ({"scale": "2 rpm"}, "speed.scale", "must be a factor for the column's numbers, a number without unit"),
        ({"hysteresis": 0.5}, "speed.hysteresis", "must be a hysteresis of the pulses as a share of their swing less than 0.5"),
        ({"pulses_per_turn": 0}, "speed.pulses_per_turn", "must be a number of encoder pulses a turn of at least 1"),
        ({"orders": (2, 2)}, "speed.orders", "the orders must be different"),
    ],
)
def test_keys_that_are_refused(tmp_path, keys, where, sentence):
    write(tmp_path / "r.csv", SPEED(50.0 * T), "speed [rad/s]")
    with pytest.raises(InputError) as error:
        fitted(tmp_path, **keys)
    assert error.value.location == where
    assert sentence in error.value.explanation


@pytest.mark.parametrize("keys", [{"unit": "rpm"}, {"hysteresis": 0.3}])
def test_what_is_said_of_no_record(keys):
    ((key, value),) = keys.items()
    with refused(f"speed.{key}", "file", given=value):
        SpeedTable(mean=50, **keys)


def test_a_record_by_which_the_shaft_turns_back(tmp_path):
    """The sentence is of the record, not of coefficients that nobody gave."""
    write(tmp_path / "r.csv", 50 + 60 * np.cos(100 * T), "speed [rad/s]")
    with pytest.raises(InputError) as error:
        fitted(tmp_path)
    assert "with these orders the shaft would stand still or turn back: their speed falls to -10 rad/s" in str(error.value)
    assert "r.csv: speed" in error.value.location
    assert "coefficients" not in str(error.value)
