"""Distances of the axis, shares of bodies in unbalances and mean angles, and the fastest speed, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from motions import END, W, machine, seen, stands, with_balls

from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import (
    AxisMotion,
    MotionObserver,
    advance_balance,
    fastest_speed,
    fastest_speeds,
    motion_of,
    weights_of,
)
from wucht.files.building import machine_from
from wucht.machines.machine import DISSIPATED_WORK, SUPPLIED_WORK
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance

CARRIER = {"mass": 5.0, "stiffness": 1e3, "damping": 1.0}


def exciters(first: float = 10.0, second: float = -10.0, **more: Any) -> Any:
    """Rotors of 3 and 1 kg m^2 with unbalances of 20 and 10 g m, a pendulum of 4 g m about the second one."""
    rotors = [
        {"kind": "rotor", "name": n, "mass": 1.0, "unbalance": u, "inertia": j}
        for n, u, j in (("a", 0.02, 3.0), ("b", 0.01, 1.0))
    ]
    ball = {"kind": "pendulum", "name": "p", "about": "b", "mass": 0.04, "length": 0.1, "damping": 0.01}
    drives = [{"on": n, "kind": "linear", "slope": 0.1, "no_load_speed": s} for n, s in (("a", first), ("b", second))]
    return machine_from({"carrier": CARRIER, "bodies": [*rotors, ball], "drives": drives} | more)


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


@pytest.mark.parametrize(
    ("place", "speed", "rests"), [(0.0, 0.0, True), (0.1, 0.0, False), (0.0, 0.1, False), (0.0, -0.1, False)]
)
def test_an_axis_that_begins_at_rest(place: float, speed: float, rests: bool) -> None:
    time = np.array([0.0, 1.0])
    assert AxisMotion(time, np.array([[place, 1.0]]), np.array([[speed, 1.0]])).begins_at_rest is rests


def test_the_mean_angle_is_weighted_with_inertias_and_senses() -> None:
    """The torques between rotors do not change it: about 3/4 of the first one's, less 1/4 of that which turns against it."""
    second = 1.0 + 0.04 * 0.1**2
    shares = np.array([3.0, second, 0.0]) / (3.0 + second)
    assert observer(exciters())._common_shares == pytest.approx(shares * [1.0, -1.0, 1.0])
    assert observer(exciters(second=10.0))._common_shares == pytest.approx(shares)
    assert not len(observer(machine(CARRIER, with_balls("p")))._common_shares)


def test_weights_are_shares_of_the_unbalance_of_the_rotor() -> None:
    of = exciters()
    a, b, _ = of.bodies
    assert weights_of(of, a) == pytest.approx((1.0, 0.0, 0.0))
    assert weights_of(of, b) == pytest.approx((1.0, 0.0, 0.4)), "the other rotor's do not count"
    shares = observer(of)._shares
    assert shares["a"].ravel() == pytest.approx([50.0, 0.0, 0.0])
    assert shares["b"].ravel() == pytest.approx([0.0, 100.0, 100.0])


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


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_fastest_speed(sense: float) -> None:
    """Of all bodies, whichever way they turn, and of a prescribed speed."""
    of = exciters()
    rows = [of.row(body.coordinate.velocity) for body in of.bodies]
    states = np.zeros((len(of.state_names), 2))
    states[rows, 0], states[rows, 1] = sense * np.array([-3.0, 2.0, 1.0]), sense * np.array([1.0, 2.0, -4.0])
    assert fastest_speeds(of, states).tolist() == [3.0, 4.0]
    motion: Any = SimpleNamespace(time=np.array([0.0, 1.0]), states=states)
    assert fastest_speed(of, motion) == 4.0
    held = machine(CARRIER, with_balls("p"), {"on": "d", "kind": "constant-speed", "speed": sense * 9.0})
    states = np.zeros((len(held.state_names), 2))
    ball = held.body("p")
    states[held.row(ball.coordinate.velocity)] = -5.0
    motion = SimpleNamespace(time=np.array([0.0, 1.0]), states=states)
    assert fastest_speeds(held, states).tolist() == [5.0, 5.0] and fastest_speed(held, motion) == 9.0
    assert motion_of(held, motion, held.rotor)[1] == pytest.approx([sense * 9.0] * 2)
    assert motion_of(held, motion, ball)[1] == pytest.approx([-5.0] * 2)


def test_the_work_of_a_schedule_is_supplied() -> None:
    """1 J stored, 5 J supplied, 2 J by a schedule, 6 J lost; without the schedule 2 J are missing."""
    works = {SUPPLIED_WORK: np.array([0.0, 5.0]), DISSIPATED_WORK: np.array([0.0, 6.0]), SCHEDULE_WORK: np.array([0.0, 2.0])}
    begun = EnergyBalance()
    _, residual = advance_balance(begun, np.array([0.0, 1.0]), works)
    assert residual == pytest.approx([0.0, 0.0])
    del works[SCHEDULE_WORK]
    assert abs(advance_balance(begun, np.array([0.0, 1.0]), works)[1][-1]) > 0.1


def test_the_largest_distance_is_kept() -> None:
    of = machine(CARRIER, with_balls("p"))
    watch = observer(of)
    first = seen(of, 5.0, lambda t: W * t, lambda t: W * t)
    later = watch.update_from_samples(
        SimpleNamespace(**vars(first) | {"largest": 0.5}),  # type: ignore[arg-type]
        watch_samples(of, 5.0, 6.0),
    )
    assert later.largest == 0.5 and later.end_time == 6.0


def watch_samples(of: Any, begin: float, end: float) -> Any:
    from wucht.numerics.observers.turns import Samples

    time = np.linspace(begin, end, 25)
    return Samples.of(time, *((W * time, np.full(25, W)) for _ in of.bodies))


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
