"""Distances of the axis, what adds to the unbalance, works and phases as they are observed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from motions import END, W, machine, stands, with_balls

from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import (
    AxisMotion,
    MotionObserver,
    advance_balance,
)
from wucht.files.building import machine_from
from wucht.machines.machine import DISSIPATED_WORK, SUPPLIED_WORK
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance

CARRIER = {"mass": 5.0, "stiffness": 1e3, "damping": 1.0}


def observer(of: Any) -> MotionObserver:
    return MotionObserver(of, 1.0, Noise.of())


def test_the_distance_of_the_axis_and_its_rate() -> None:
    """On an ellipse with the half axes 3 and 2."""
    time = np.linspace(0.07, 2 * math.pi + 0.07, 41)
    offset = np.array([3 * np.cos(time), 2 * np.sin(time)])
    axis = AxisMotion(time, offset, np.array([-3 * np.sin(time), 2 * np.cos(time)]))
    square = 9 * np.cos(time) ** 2 + 4 * np.sin(time) ** 2
    assert axis.square == pytest.approx(square) and axis.distance == pytest.approx(np.sqrt(square))
    assert axis.square_rate == pytest.approx(-5 * np.sin(2 * time))
    assert axis.peaks[1:3] == pytest.approx(axis.distance[:2], abs=1e-4), "of a fall the sample before"
    assert axis.distance.max() < 2.997
    assert axis.peaks.max() == pytest.approx(3.0, abs=1e-4), "between samples"


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(("angle", "share"), [(0.0, 1.3), (math.pi, 0.7)])
def test_a_mass_in_a_guide_adds_to_the_unbalance_of_its_rotor_as_it_moves_out(sense: float, angle: float, share: float) -> None:
    """0.02 kg m, and 0.2 kg that is 3 cm further out than where it is balanced; the second rotor has nothing of it."""
    rotors = [{"kind": "rotor", "name": n, "mass": 2.0, "unbalance": 0.02, "inertia": 1.0} for n in "ab"]
    pendulum = {"kind": "switchable-pendulum", "name": "p", "about": "a", "mass": 0.3, "damping": 0.02, "moving_mass": 0.2}
    pendulum |= {"inner_stop": 0.05, "outer_stop": 0.09, "stiffness": 300.0, "preload": 20.0}
    of = machine_from({"carrier": CARRIER, "bodies": [*rotors, pendulum]})
    time = np.linspace(0.0, 10.0, 241)
    motion = {f"{n}.speed": sense * W + 0 * time for n in "abp"} | {f"{n}.angle": sense * W * time for n in "ab"}
    motion |= {"p.angle": sense * W * time + angle, "p.displacement": 0.03 + 0 * time}
    states = np.array([motion.get(name, 0 * time) for name in of.state_names])
    values = np.array(of.system.values(of.values))
    watch = observer(of)
    found = watch.update(watch.begin(), Trajectory(time, states, {}, values, 10.0, states[:, -1]))
    of_first, of_second = (found.rotors[n].last(1.0).greatest_sum for n in "ab")
    assert of_first == pytest.approx(share) and of_second == pytest.approx(1.0)


def test_the_work_of_a_schedule_is_supplied() -> None:
    """1 J stored, 5 J supplied, 2 J by a schedule, 6 J lost; without the schedule 2 J are missing."""
    works = {SUPPLIED_WORK: np.array([0.0, 5.0]), DISSIPATED_WORK: np.array([0.0, 6.0]), SCHEDULE_WORK: np.array([0.0, 2.0])}
    begun = EnergyBalance()
    _, residual = advance_balance(begun, np.array([0.0, 1.0]), works)
    assert residual == pytest.approx([0.0, 0.0])
    del works[SCHEDULE_WORK]
    assert abs(advance_balance(begun, np.array([0.0, 1.0]), works)[1][-1]) > 0.1


@pytest.mark.parametrize("angle", [0.1, 1e-3])
def test_bounds_no_wider_than_twice_the_noise_are_widened(angle: float) -> None:
    noise = Noise(1e-9, angle)
    for share, widened in ((1.99, True), (2.01, False)):
        width = share * angle
        expected = [0.5 - width, 0.5 + 2 * width] if widened else [0.5, 0.5 + width]
        assert noise.widen(np.array([0.5, 0.5 + width])) == pytest.approx(expected)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("driven", [1.0, -1.0])
def test_the_free_speed_counts_in_the_sense_of_the_rotor(sense: float, driven: float) -> None:
    of = machine(CARRIER | {"stiffness": 10 * (0.5 * W) ** 2}, with_balls("p"))
    found = stands(of, lambda t: sense * W * t, lambda t: sense * W * t, free=driven * W, until=END)
    assert found.evidence.free_speed == pytest.approx(sense * driven * W)
    assert (found.sense, found.speed) == (sense, pytest.approx(W))
    assert found.evidence.mean_speed == pytest.approx((W, W))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_phases_as_bodies_turn(sense: float) -> None:
    """A ball that is 0.5 rad counter-clockwise of the rotor is ahead of it or behind it."""
    of = machine(CARRIER | {"stiffness": 10 * (0.5 * W) ** 2}, with_balls("p"))
    found = stands(of, lambda t: sense * W * t, lambda t: sense * W * t + 0.5, free=sense * W)
    assert found.phases["p"] == pytest.approx(0.5)
    assert found.final_phases == pytest.approx([0.0, sense * 0.5])
    assert found.residual == pytest.approx(abs(1 + np.exp(0.5j)), rel=1e-6)


def test_the_residual_is_the_largest_of_the_last_turns() -> None:
    """The ball swings by 0.2 rad about the place where it compensates the rotor, once in three turns."""
    of = machine(CARRIER | {"stiffness": 10 * (0.5 * W) ** 2}, with_balls("p"))
    found = stands(of, lambda t: W * t, lambda t: W * t + math.pi + 0.2 * np.sin(W * t / 3))
    assert found.residual == pytest.approx(2 * math.sin(0.1) * 0.83, rel=0.1), "of means over a turn, 0.83 of the swing"
    assert found.unrest > 0.5


def test_a_compensated_rotor_has_the_resonance_of_its_unbalance() -> None:
    """The ball leaves nothing that could excite a vibration; the rotor alone has one at half of its speed."""
    of = machine({"mass": 6.0, "stiffness": 10 * (W / 2) ** 2, "damping": 0.1}, with_balls("p"))
    compensated = stands(of, lambda t: W * t, lambda t: W * t + math.pi)
    assert compensated.residual == pytest.approx(0.0, abs=1e-9)
    assert compensated.evidence.resonance == pytest.approx(W / 2, rel=1e-2)
