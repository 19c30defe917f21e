"""How densely a motion is stored, its limits where samples are too few, and its course sample by sample."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht import Machine, parts
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.motion_limits import amplitude_limits, speed_limits, stored_samples_per_turn
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.trajectory import Trajectory

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


TURN = 2 * math.pi


def test_sample_by_sample_the_amplitude_is_that_of_the_axis_about_its_rest_position_and_between_samples() -> None:
    """An ellipse with the half axes 3 and 2 mm about the sagged position, 7 samples a turn; the second rotor is clockwise."""
    rotors = [{"kind": "rotor", "name": n, "mass": 1.0, "unbalance": 1e-3, "inertia": 1.0} for n in "ab"]
    carrier = {"mass": 8.0, "stiffness": 1e3, "gravity": 9.81}
    machine = machine_from({"carrier": carrier, "bodies": rotors})
    sag = -9.81 * 10.0 / 1e3
    flow, time = compile_system(machine.system), np.linspace(0.3, 0.3 + TURN, 8)
    motion = {
        "carrier.x": 3e-3 * np.cos(time), "carrier.vx": -3e-3 * np.sin(time), "carrier.y": sag + 2e-3 * np.sin(time),
        "carrier.vy": 2e-3 * np.cos(time), "a.angle": time, "a.speed": 1.0 + 0 * time, "b.speed": -2.0 - time,
    }  # fmt: skip
    states = np.array([motion.get(n, 0 * time) for n in machine.state_names])
    values = np.array(machine.system.values(machine.values))

    def course(count: int) -> MotionCourse:
        trajectory = Trajectory(time[:count], states[:, :count], {}, values, 0.0, states[:, 0])
        return MotionCourse.from_samples(machine, flow, trajectory)

    whole, first = course(8), course(1)
    assert whole.speeds == pytest.approx(np.array([np.ones(8), -2.0 - time]))
    assert whole.amplitude.max() == pytest.approx(3e-3, rel=2e-3), "between the samples, none of which is beyond 2.9 mm"
    assert whole.amplitude.min() > 2.5e-3, "the larger of a sample and its neighbours, not the distance of the sample"
    assert first.amplitude == pytest.approx([1e-3 * math.hypot(3 * math.cos(0.3), 2 * math.sin(0.3))])
