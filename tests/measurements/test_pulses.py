"""Instants of pulses, from lists and signals."""

import re

import numpy as np
import pytest
from known_motion import OMEGA, TURN, angle_at, channel, times_of
from tests.refusals import refused

from wucht.errors import InputError
from wucht.measurements.pulses import check_even, pulse_times, rising_crossings

T = np.linspace(0, 1, 4001)


def test_a_list_of_instants():
    assert pulse_times(channel(np.arange(3.0), np.array([1, 2, 4]), "ms", "p")).tolist() == [0.001, 0.002, 0.004]
    with refused("r.csv: p", "sample 3", given=None, code="not-increasing"):
        pulse_times(channel(np.arange(3.0), np.array([1, 3, 2]), "s", "p"))


def test_crossings_are_between_samples():
    found = rising_crossings(channel(np.array([0.0, 1, 2, 3, 5]), np.array([0.0, 4, 4, 0, 4])))
    assert found.tolist() == [0.5, 4.0]
    assert rising_crossings(channel(np.array([0.0, 1, 2, 3]), np.array([0.0, 4, 0, 4])), level=3.0).tolist() == [0.75, 2.75]


def test_a_wave_of_a_turning_shaft():
    """Of third order in the step: interpolated on a line where the wave is steepest."""
    wanted = times_of(TURN / 8 * np.arange(1, 60))
    found = rising_crossings(channel(T, np.sin(8 * angle_at(T)), "V"))[: len(wanted)]
    shift = found[0] - wanted[0]
    assert abs(shift) < TURN / 8 / OMEGA
    start = np.searchsorted(wanted, found[0] - 1e-4)
    assert found[: len(wanted) - start] == pytest.approx(wanted[start:][: len(found)], abs=3e-5)


def test_a_square_wave():
    square = np.where(np.sin(TURN * 10 * T + 1) > 0, 5.0, 0.0)
    wanted = (np.arange(1, 11) - 1 / TURN) / 10
    assert rising_crossings(channel(T, square, "V")) == pytest.approx(wanted, abs=1.3e-4), "it begins high: that is no rise"


@pytest.mark.parametrize("noise", [0.05, 0.15])
def test_noise_makes_no_pulses(noise):
    x = np.sin(TURN * 10 * T + 1) + noise * np.random.default_rng(0).uniform(-1, 1, len(T))
    found = pulse_times(channel(T, x, "V"))
    assert len(found) == 10
    assert found == pytest.approx((np.arange(1, 11) - 1 / TURN) / 10, abs=noise * 0.05)
    assert len(pulse_times(channel(T, x, "V"), hysteresis=0.0)) > 15, "without hysteresis it does"


def test_a_dip_is_no_pulse():
    """It must have been below the middle by the hysteresis."""
    x = np.array([0.0, 1, 0.45, 1, 0, 1])
    assert rising_crossings(channel(np.arange(6.0), x)).tolist() == [0.5, 4.5]


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


def test_one_pulse_may_be_enough():
    assert pulse_times(channel(np.arange(4.0), np.array([0.0, 0, 1, 1]), "V"), least=1).tolist() == [1.5]


@pytest.mark.parametrize("missing", [[20], [20, 21], [3], [60]])
def test_missing_pulses(missing):
    times = np.delete(np.arange(64) / 10, missing)
    before = (missing[0] - 1) / 10
    sentence = (
        f"w: pulses are missing between {before:.6g} s and {(missing[-1] + 1) / 10:.6g} s: the interval is {len(missing) + 1}"
    )
    with pytest.raises(InputError, match=re.escape(sentence)):
        check_even(times, "w")


@pytest.mark.parametrize("at", [0.24, 3.05, 6.27])
def test_a_pulse_too_many(at):
    with refused("w", "too many", given=None, code="pulse-too-many"):
        check_even(np.sort(np.append(np.arange(64) / 10, at)), "w")


def test_uneven_turning_is_no_missing_pulse():
    x = TURN / 32 * np.arange(300)
    check_even(x + 0.35 * np.sin(x), "w")  # the speed varies by more than a factor of two
    check_even(np.array([0.0, 1.0, 5.0]), "w")  # too few to tell
    check_even(np.sqrt(np.arange(20.0, 200)), "w")
