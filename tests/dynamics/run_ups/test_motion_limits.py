"""How densely a motion is stored, and the limits of one whose samples are too few."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht import Machine, parts
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.motion_limits import amplitude_limits, speed_limits, stored_samples_per_turn
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.work import Work

SPEED = 60.0


def motion(speed: float = SPEED, stored_samples: int | None = None, until: float = 4.0) -> Motion:
    """Of a rotor that beats with a vibration of its carrier: within a turn its speed hardly changes."""
    carrier = parts.Carrier(directions="x", mass=1.0, stiffness=1e4, damping=20.0)
    rotor = parts.Rotor(name="drum", mass=1.0, unbalance=5e-3, inertia=2e-3)
    machine = Machine(carrier, [rotor], [parts.LinearDrive(slope=5e-3, no_load_speed=speed)])
    case = RunUpCase.of(machine, {"drum": {"speed": speed}}, RunSettings(until=until, stored_samples=stored_samples))
    *_, (last,) = run_up(case, Work())
    return last


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_samples_a_turn_where_they_are_fewest(speed: float) -> None:
    """Of evenly spaced samples: where the rotor is fastest, in either sense."""
    coarse = motion(speed, 150)
    time = coarse.machine_motion.time
    fastest = np.abs(coarse.rows["drum.speed"]).max()
    assert stored_samples_per_turn(coarse) == pytest.approx(2 * math.pi / fastest / np.diff(time).max(), rel=1e-9)
    assert stored_samples_per_turn(motion(speed)) > 8 > stored_samples_per_turn(coarse)


def test_the_limits_are_those_of_the_whole_motion_in_the_window() -> None:
    coarse, fine = motion(stored_samples=150), motion()
    begin, end = coarse.verdict.window
    inside = (fine.machine_motion.time >= begin) & (fine.machine_motion.time <= end)
    speed = fine.rows["drum.speed"][inside]
    assert speed_limits(coarse) == pytest.approx((speed.min(), speed.max()), rel=1e-3)
    mean, least, greatest = amplitude_limits(coarse)
    assert least <= mean <= greatest
    assert greatest == pytest.approx(np.abs(fine.rows["carrier.x"][inside]).max(), rel=0.02)


def test_without_a_whole_turn_the_distances_of_the_spans_are_the_limits() -> None:
    """A tenth of a second at 6 rad/s."""
    slow = motion(6.0, 20, 0.1)
    mean, least, greatest = amplitude_limits(slow)
    assert least <= mean <= greatest and greatest == pytest.approx(slow.observation.largest, rel=0.02)
