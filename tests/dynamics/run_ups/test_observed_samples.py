"""How densely a motion is looked at that is watched: counted where its speed is known."""

import numpy as np
import pytest
from tests.dynamics.verdicts.motions import FIXED, ROTOR, W, machine

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.observed_integration import ObservedIntegration
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver
from wucht.numerics.flow.compiled_system import compile_system


def looks(at, speed, step, vibration=0.0):
    """How often it is looked at within one step of what is stored."""
    flow = compile_system(at.system)
    watched = ObservedIntegration(MotionObserver(at, 1.0, Noise.of()), flow, lambda motion: motion, vibration, 1.0)
    leg = watched.begin(initial_state(at, {"d": {"speed": speed}}), at.system.values(at.values))
    return len(watched.leg(leg, np.array([0.0, step])).pending[-1].time) - 1


def idle():
    return machine(FIXED, [ROTOR])


def test_a_turn_is_looked_at_twenty_four_times():
    assert looks(idle(), W, 3.0) == 72


def test_a_rotor_at_rest_is_looked_at_as_if_it_made_a_quarter_turn_a_span():
    assert looks(idle(), 0.0, 10.0) == 60


@pytest.mark.parametrize(("times", "count"), [(10.0, 240), (19.0, 456), (21.0, 480), (1000.0, 480)])
def test_vibrations_are_followed_up_to_twenty_times_the_speed(times, count):
    assert looks(idle(), W, 1.0, vibration=times * W) == count


@pytest.mark.parametrize(("step", "count"), [(0.9, 22), (1.1, 61)])
def test_a_rotor_that_has_become_more_than_twice_as_fast_is_looked_at_again(step, count):
    """It gains a turn a second in a second: with the samples for its first speed a turn is seen twelve times at least."""
    driven = machine(FIXED, [ROTOR], {"kind": "constant-torque", "torque": ROTOR["inertia"] * W})
    assert looks(driven, W, step) == pytest.approx(count, abs=6)
