"""Averages over turns remove the ripple within a turn and nothing else."""

import numpy as np
import pytest

from wucht.numerics.turns import PER_TURN, turns


def rippled(w, a, samples_a_turn, count=20, k=1):
    """phi = w t + a sin(k w t): whatever a, a turn takes 2 pi/w."""
    t = np.arange(0, count * samples_a_turn + 1) * 2 * np.pi / w / samples_a_turn
    return t, w * t + a * np.sin(k * w * t), w + a * k * w * np.cos(k * w * t)


@pytest.mark.parametrize("w", [0.7, 200.0])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_the_mean_speed_of_a_rippled_turn_is_exact(w, k):
    t, phi, speed = rippled(w, 0.2, 200, k=k)
    averaged = turns(t, phi, speed, {})
    assert averaged.speed == pytest.approx(np.full(len(averaged.speed), w), rel=1e-7)
    assert averaged.count == pytest.approx(19, abs=0.1)
    assert np.diff(averaged.angle) == pytest.approx(2 * np.pi / PER_TURN, rel=1e-12)


def test_the_error_is_of_fourth_order_in_the_sampling_interval():
    errors = []
    for samples_a_turn in (12.382, 24.382, 48.382, 96.382):  # out of step, so that errors do not repeat and cancel
        t = np.arange(0, 600, 2 * np.pi / samples_a_turn)
        averaged = turns(t, t + 0.2 * np.sin(t), 1 + 0.2 * np.cos(t), {})
        errors.append(np.abs(averaged.speed - 1.0).max())
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert order == pytest.approx(4.0, abs=0.2)


def test_a_slow_change_is_kept():
    """phi = t + t^2/2000: the mean speed over a turn that takes T around the middle t is 1 + t/1000."""
    t = np.linspace(0, 300, 6001)
    averaged = turns(t, t + t**2 / 2000, 1 + t / 1000, {})
    begin_to_end = 1 + averaged.time / 1000
    assert np.abs(averaged.speed - begin_to_end).max() < 5e-6  # the middle of the angle is not quite that of the time


def test_followers_their_speed_and_phase():
    t, phi, speed = rippled(3.0, 0.1, 100)
    locked = (phi + 2.0, speed)
    slipping = (2.7 * t, np.full_like(t, 2.7))
    averaged = turns(t, phi, speed, {"locked": locked, "slipping": slipping})
    assert np.abs(averaged.phases[0] - np.exp(2j)).max() < 1e-6
    assert averaged.followers[0] == pytest.approx(np.full(len(averaged.time), 3.0), rel=1e-6)
    assert averaged.followers[1] == pytest.approx(np.full(len(averaged.time), 2.7), rel=1e-6)
    # A slip of a tenth of the speed turns the phase by 36 degrees a turn: the mean of exp(i a) over that has modulus sinc.
    assert np.abs(averaged.phases[1]).mean() == pytest.approx(np.sin(0.1 * np.pi) / (0.1 * np.pi), abs=2e-2)


def test_turning_backward():
    t, phi, speed = rippled(3.0, 0.1, 100)
    forward = turns(t, phi, speed, {"p": (phi + 2.0, speed)})
    backward = turns(t, -phi, -speed, {"p": (-phi - 2.0, -speed)})
    assert backward.speed == pytest.approx(-forward.speed, rel=1e-12)
    assert backward.angle == pytest.approx(-forward.angle, rel=1e-12)
    assert np.abs(backward.phases - forward.phases.conj()).max() < 1e-9


def test_only_the_last_part_that_turns_one_way_counts():
    """A body that swings at first: speed 1 - 2 exp(-t/5), negative until t = 5 ln 2."""
    t = np.linspace(0, 100, 4001)
    averaged = turns(t, t + 10 * (np.exp(-t / 5) - 1), 1 - 2 * np.exp(-t / 5), {})
    assert (averaged.speed > 0).all()
    assert averaged.time[0] > 5 * np.log(2)
    assert averaged.speed[-1] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("until", [0.0, 0.1, 6.0])
def test_less_than_a_turn_is_an_empty_record(until):
    t = np.linspace(0, until, 30)
    averaged = turns(t, t, np.ones_like(t), {"a": (t, np.ones_like(t))})
    assert averaged.count == 0
    assert averaged.phases.shape == (1, 0)


def test_the_last_share():
    t, phi, speed = rippled(1.0, 0.0, 100)
    averaged = turns(t, phi, speed, {})
    assert len(averaged.time[averaged.last(0.1)]) == round(0.1 * len(averaged.time))
    assert len(averaged.time[averaged.last(0.0)]) == 1
