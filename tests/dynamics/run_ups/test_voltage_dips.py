"""Dips of the supply voltage: the critical duration by quadrature, the motion by a schedule, and the border by bisection."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.operating_state import machine_after_schedules
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.dynamics.run_ups.settled_operation import EndState, operation_of
from wucht.dynamics.run_ups.voltage_dips import CriticalDip, Dip, DippingSupply, critical_dip, voltages_of_drives
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

J, R1, R2, X, U = 0.05, 2.0, 1.5, 6.0, 230.0
SYNCHRONOUS = math.pi * 50
SETTINGS = RunSettings(stored_samples=20_000)
MOTOR = {
    "on": "rotor", "kind": "induction", "voltage": U, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": R1,
    "rotor_resistance": R2, "stator_reactance": X / 2, "rotor_reactance": X / 2,
}  # fmt: skip


def loaded_motor(load: float, **parts: Any) -> Machine:
    """An induction motor on a fixed axis against a constant torque, without vibration."""
    body = {"kind": "rotor", "name": "rotor", "mass": 5.0, "eccentricity": 0.0, "inertia": J}
    loads = [{"on": "rotor", "kind": "coulomb", "torque": load}]
    return machine_from({"carrier": {"directions": "fixed"}, "bodies": [body], "drive": MOTOR, "loads": loads} | parts)


def motor_torque(speed: float, voltage: float = U) -> float:
    """002 (2.119)."""
    d = SYNCHRONOUS - speed
    return 3 * R2 * voltage**2 * d / ((R1 * d + R2 * SYNCHRONOUS) ** 2 + (X * d) ** 2)


def working_speeds(load: float) -> tuple[float, float]:
    """The stable and the unstable crossing of torque and load, on both sides of pull-out."""
    pull_out = SYNCHRONOUS * (1 - R2 / math.hypot(R1, X))
    return tuple(brentq(lambda w: motor_torque(w) - load, *ends) for ends in ((pull_out, SYNCHRONOUS), (1.0, pull_out)))


def critical_by_quadrature(load: float, depth: float) -> float:
    """The time from the working point to the unstable crossing at the low voltage: that of dw = (T - T_load)/J dt."""
    stable, unstable = working_speeds(load)
    return quad(lambda w: J / (motor_torque(w, (1 - depth) * U) - load), stable, unstable)[0]


def supply_of(machine: Machine, depth: float, on: str | None = None) -> DippingSupply:
    operation = operation_of(machine, {}, SETTINGS, 10, Work())
    return DippingSupply(machine_after_schedules(machine), operation, voltages_of_drives(machine, on), depth, SETTINGS)


@pytest.mark.parametrize(("load", "depth"), [(50.0, 1.0), (45.0, 0.4)])
def test_the_critical_duration_is_that_of_a_quadrature(load: float, depth: float) -> None:
    supply, expected = supply_of(loaded_motor(load), depth), critical_by_quadrature(load, depth)
    assert supply.operation.end.speed == pytest.approx(working_speeds(load)[0], rel=1e-9)
    lasting = supply.lasting_dip(None, 4, Work())
    assert lasting.end.outcome == "stopped" and lasting.is_settled
    *_, tried = critical_dip(supply.dip, lasting.levels.tolist(), 0.0, CriticalDip(), Work())
    assert tried.longest_return.duration < expected < tried.shortest_loss.duration
    assert tried.longest_return.duration == pytest.approx(expected, rel=0.01)
    assert tried.shortest_loss.end.outcome == "stopped"
    assert tried.longest_return.speed_at_recovery == pytest.approx(working_speeds(load)[1], rel=0.03)


def test_both_sides_of_the_critical_duration() -> None:
    supply, expected = supply_of(loaded_motor(50.0), 1.0), critical_by_quadrature(50.0, 1.0)
    before, beyond = (supply.dip(share * expected, Work()) for share in (0.999, 1.001))
    assert before.is_return and before.end.speed == pytest.approx(supply.operation.end.speed, rel=1e-6)
    assert not beyond.is_return and beyond.end.speed == 0.0
    assert before.recovery_time > 0.5  # it stays near the unstable crossing for long


def test_a_motor_that_does_not_start_is_placed_at_its_working_point() -> None:
    assert motor_torque(0.0) < 40.0
    operation = operation_of(loaded_motor(40.0), {}, SETTINGS, 10, Work())
    assert operation.working_point == pytest.approx(working_speeds(40.0)[0], rel=1e-6)
    starting = operation_of(loaded_motor(25.0), {}, SETTINGS, 10, Work())
    assert starting.working_point is None and starting.end.speed == pytest.approx(151.0, rel=0.01)


def test_the_dip_is_a_step_schedule_of_the_voltage() -> None:
    """An unbalanced rotor on springs: the motion of both is one, in the dip and after it."""
    parts: dict[str, Any] = {
        "carrier": {"mass": 60.0, "stiffness": 1e5, "damping": 800.0},
        "bodies": [{"kind": "rotor", "name": "rotor", "mass": 20.0, "eccentricity": 1e-3, "inertia": 0.3}],
    }
    fan = loaded_motor(40.0, **parts)
    supply = supply_of(fan, 0.6)
    dip = supply.dip(0.5, Work())
    tables = [{"parameter": "drive.voltage", "points": [[0.0, 0.4 * U], [0.5, U]], "interpolation": "steps"}]
    stepped = loaded_motor(40.0, schedules=tables, **parts)
    state = dict(zip(fan.state_names, supply.operation.state.tolist(), strict=True))
    carrier = {"x": state["carrier.x"], "y": state["carrier.y"], "vx": state["carrier.vx"], "vy": state["carrier.vy"]}
    start = {"rotor": {"angle": state["rotor.angle"], "speed": state["rotor.speed"]}, "carrier": carrier}
    run = run_to_end(stepped, start, RunSettings(until=6.0))
    time, speed = run.trajectory.time, run.rows["rotor.speed"]
    inside = (dip.course.time > 0) & (dip.course.time < min(6.0, dip.course.time[-1]))
    expected = np.interp(dip.course.time[inside], time, speed)
    np.testing.assert_allclose(dip.course.speeds[0, inside], expected, rtol=2e-3)
    low = run_to_end(stepped, start, RunSettings(until=0.5)).trajectory.end_state[
        stepped.row(stepped.rotor.coordinate.velocity)
    ]
    assert dip.speed_at_recovery == pytest.approx(low, rel=1e-9)
    assert dip.is_return and run.verdict.speed == pytest.approx(dip.end.speed, rel=1e-3)


def test_a_clockwise_motor_is_the_mirror_image() -> None:
    """Speeds are magnitudes, but for the course."""
    forwards, backwards = (supply_of(loaded_motor(50.0, drive=MOTOR | {"sense": sense}), 1.0) for sense in (1, -1))
    assert backwards.operation.end.speed == pytest.approx(forwards.operation.end.speed, rel=1e-9)
    assert backwards.operation.working_point == pytest.approx(forwards.operation.working_point, rel=1e-9)
    one, other = (supply.dip(0.04, Work()) for supply in (forwards, backwards))
    assert other.is_return and other.end.speed == pytest.approx(one.end.speed, rel=1e-6)
    assert other.speed_at_recovery == pytest.approx(one.speed_at_recovery, rel=1e-6)
    assert other.course.speeds.max() < 0 < one.course.speeds.min()


# --- the border by bisection ---


def _tried(
    returns: Callable[[float], bool], durations: list[float], shortest: float = 0.0, earlier: list[float] | None = None
) -> CriticalDip:
    course = MotionCourse(np.zeros(1), np.zeros((1, 1)), np.zeros(1))

    def dip(duration: float, _work: Work) -> Dip:
        return Dip(duration, EndState("passed", (1.0,), (), None, 1.0), returns(duration), 1.0, None, 0.0, course)

    before = CriticalDip(tuple(dip(duration, Work()) for duration in earlier or ()))
    *_, tried = critical_dip(dip, durations, shortest, before, Work())
    return tried


@pytest.mark.parametrize("critical", [0.3, 0.01, 0.99, 0.25])
def test_to_one_percent(critical: float) -> None:
    tried = _tried(lambda t: t <= critical, [0.25, 0.5, 0.75, 1.0])
    assert tried.longest_return.duration <= critical < tried.shortest_loss.duration
    assert tried.shortest_loss.duration - tried.longest_return.duration <= 0.01 * tried.longest_return.duration
    assert len(tried.dips) < 25


def test_the_first_border_counts() -> None:
    """Longer dips may do no harm again, as a machine that stops may start."""
    tried = _tried(lambda t: t < 0.3 or t > 0.7, [0.25, 0.5, 0.75, 1.0])
    assert tried.longest_return.duration == pytest.approx(0.3, rel=0.01)
    assert [d.duration for d in tried.later_returns] == [0.75, 1.0]


# --- what a return is ---

OPERATION = EndState("synchronised", (100.0, 100.0), (1.0,), 1e-3, 5.0)


@pytest.mark.parametrize(
    ("changes", "is_return"),
    [
        ({}, True), ({"speeds": (100.49, 100.49)}, True), ({"speeds": (100.51, 100.51)}, False),
        ({"speeds": (99.51, 99.51)}, True), ({"speeds": (99.49, 99.49)}, False), ({"speeds": (100.0, 99.0)}, False),
        ({"outcome": "not-synchronised"}, False), ({"phases": (1.6,)}, True), ({"phases": (1.7,)}, False),
        ({"phases": (1.0 + 2 * math.pi,)}, True), ({"amplitude": 2e-3}, True),
    ],
)  # fmt: skip
def test_a_return_is_the_same_outcome_speed_and_configuration(changes: dict[str, Any], is_return: bool) -> None:
    assert replace(OPERATION, **changes).equals(OPERATION) is is_return


# --- drives ---
