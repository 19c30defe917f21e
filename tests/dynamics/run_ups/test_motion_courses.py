"""Courses of motions that are made by hand, over turns and sample by sample; joined, thinned, cut and shifted."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.trajectory import Trajectory

TURN = 2 * math.pi


def course_over_turns(angles: np.ndarray, time: np.ndarray, at: list[float], distance: list[float]) -> MotionCourse:
    """angles (r, N) of rotors at times (N,); at: times of the ends of the record's spans, with their largest distances."""
    rotors = [SimpleNamespace(coordinate=SimpleNamespace(position=k)) for k in range(len(angles))]
    machine: Any = SimpleNamespace(rotors=rotors, row=lambda position: position)
    spans = SimpleNamespace(time=np.array(at), greatest_distance=np.array(distance))
    seen: Any = SimpleNamespace(main=SimpleNamespace(last=lambda share: spans))
    trajectory: Any = SimpleNamespace(time=time, states=angles)
    return MotionCourse.from_turns(machine, trajectory, seen)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_span_is_a_turn_of_the_fastest_rotor(sense: float) -> None:
    """The second rotor makes 4 turns in 8 s; the first one half of them, faster in the second half of the time."""
    time = np.linspace(2.0, 10.0, 81)
    slow = np.where(time < 6.0, 0.5 * TURN * (time - 2.0) / 4, 0.5 * TURN + 1.5 * TURN * (time - 6.0) / 4)
    angles = sense * np.array([slow, TURN * (time - 2.0) / 2])
    record = [1e-3, 5e-3, 2e-3, 1e-3, 3e-3, 2e-3, 4e-3, 1e-3]
    course = course_over_turns(angles, time, [2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5], record)
    assert course.time.tolist() == pytest.approx([3.0, 5.0, 7.0, 9.0])
    assert course.speeds[1] == pytest.approx([sense * TURN / 2] * 4)
    assert course.speeds[0] == pytest.approx(sense * TURN / 8 * np.array([1.0, 1.0, 3.0, 3.0]))
    assert course.amplitude[0] == 5e-3, "the largest within each span"
    assert np.all(course.amplitude >= [5e-3, 2e-3, 3e-3, 4e-3])


def test_one_rotor_may_rest_while_another_turns_clockwise() -> None:
    time = np.linspace(0.0, 2.0, 21)
    course = course_over_turns(np.array([0.0 * time, -TURN * time]), time, [0.5, 1.5], [1e-3, 2e-3])
    assert (len(course.time), course.speeds[0].tolist()) == (2, [0.0, 0.0])
    assert course.speeds[1] == pytest.approx([-TURN] * 2)


def test_without_a_turn_or_a_time_there_is_one_moment_at_rest() -> None:
    still = course_over_turns(np.ones((2, 3)), np.array([0.0, 1.0, 2.0]), [1.0], [1e-3])
    begun = course_over_turns(np.ones((2, 1)), np.array([3.0]), [1.0], [1e-3])
    for course, time in ((still, 2.0), (begun, 3.0)):
        assert (course.time.tolist(), course.speeds.tolist(), course.amplitude.tolist()) == ([time], [[0.0], [0.0]], [0.0])


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


COURSE = MotionCourse(np.arange(7.0), np.array([np.arange(7.0), -10 * np.arange(7.0)]), np.array([1.0, 5, 2, 3, 2, 9, 4]))


def test_thinned_it_keeps_mean_times_and_speeds_and_the_largest_amplitudes() -> None:
    thin = COURSE.thin(3)
    assert (thin.time.tolist(), thin.amplitude.tolist()) == ([0.5, 2.5, 5.0], [5.0, 3.0, 9.0])
    assert thin.speeds.tolist() == [[0.5, 2.5, 5.0], [-5.0, -25.0, -50.0]]
    assert COURSE.thin(7) is COURSE


def test_joined_cut_and_shifted() -> None:
    part = COURSE.within(2.0, 4.0)
    assert (part.time.tolist(), part.speeds[1].tolist(), part.amplitude.tolist()) == (
        [2.0, 3.0, 4.0], [-20.0, -30.0, -40.0], [2.0, 3.0, 2.0],
    )  # fmt: skip
    both = MotionCourse.join([part, part.shift(10.0)])
    assert both.time.tolist() == [2.0, 3.0, 4.0, 12.0, 13.0, 14.0]
    assert (both.speeds[0].tolist(), both.amplitude.tolist()) == ([2.0, 3.0, 4.0] * 2, [2.0, 3.0, 2.0] * 2)
