"""Gears and belts: the reduced drive, closed solutions, and a loss that never gives energy, whichever way the power flows."""

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import refused

from wucht import CoastDown, RunUp, TorqueBalance, run
from wucht.analysis.dimensionless import dimensionless_numbers
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.machines.operation import free_speed
from wucht.machines.parts import ConstantTorque, LinearDrive
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

BALANCED = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.03}
DRUM = BALANCED | {"eccentricity": 0.01}
CARRIER = {"mass": 1.0, "stiffness": 1.2e4, "damping": 20.0}
LINEAR = {"kind": "linear", "slope": 0.05, "no_load_speed": 270.0}
GEAR = {"ratio": 3.0, "inertia": 0.002}
REDUCED = 0.03 + 9 * 0.002


def machine_with(drive, **parts):
    return machine_from({"carrier": {"directions": "fixed"}, "bodies": [BALANCED], "drive": drive} | parts)


def moved(machine, end, start=None, samples=41):
    flow = compile_system(machine.system)
    time = np.linspace(0, end, samples)
    ran = integrate(flow, initial_state(machine, start or {}), machine.values, time)
    assert ran.failure is None
    return dict(zip(machine.system.state_names, ran.states, strict=True)) | dict(ran.quadratures) | {"time": time}


def test_a_geared_rotor_runs_up_as_one_with_the_reduced_motor():
    """J + J_M i^2, slope i^2 U, no-load speed over i: the closed solution, and the works."""
    rows = moved(machine_with(LINEAR | {"transmission": GEAR}), 0.5)
    rate = 9 * 0.05 / REDUCED
    assert rows["drum.speed"] == pytest.approx(90 * (1 - np.exp(-rate * rows["time"])), abs=1e-9)
    assert rows["supplied_work"] == pytest.approx(REDUCED * rows["drum.speed"] ** 2 / 2, rel=1e-10, abs=1e-12)
    assert rows["dissipated_work"] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("before", "factor"), [(0.0, 0.8), (200.0, 1 / 0.8)])
def test_what_arrives_when_the_motor_drives_and_when_it_is_driven(before, factor):
    """Below no-load speed eta of its torque arrives; above it brakes with its torque over eta: exponentials both."""
    machine = machine_with(LINEAR | {"transmission": GEAR | {"efficiency": 0.8, "transition_speed": 1e-3}})
    rows = moved(machine, 0.5, {"drum": {"speed": before}})
    rate = factor * 9 * 0.05 / REDUCED
    at = rows["time"] > 0.05  # the transition at standstill is over
    left, first = rows["drum.speed"][at] - 90, rows["drum.speed"][at][0] - 90
    assert left == pytest.approx(first * np.exp(-rate * (rows["time"][at] - rows["time"][at][0])), rel=1e-6)
    stored = REDUCED * (rows["drum.speed"] ** 2 - before**2) / 2
    gap = rows["supplied_work"] - rows["dissipated_work"] - stored
    assert np.abs(gap).max() < 1e-9 * np.abs(stored).max()
    assert (np.diff(rows["dissipated_work"]) >= 0).all()


@settings(max_examples=60, deadline=None)
@given(
    torque=st.floats(-20, 20), speed=st.floats(-3, 3), efficiency=st.floats(0.05, 1.0), ratio=st.floats(0.2, 50.0),
)  # fmt: skip
def test_a_transmission_never_gives_energy(torque, speed, efficiency, ratio):
    """At every speed and torque, within the transition too; beyond it the power that is lost is 1 - eta of what enters."""
    drive = ConstantTorque(torque=torque, transmission={"ratio": ratio, "efficiency": efficiency})
    motor, lost = (drive.number(x) for x in drive.reduced_torque(sp.Float(speed)))
    assert motor == pytest.approx(ratio * torque, rel=1e-12, abs=1e-12)
    power = lost * speed
    assert power >= -1e-12 * abs(motor * speed)
    if abs(speed) > 2:
        entering = motor * speed if motor * speed > 0 else -motor * speed / efficiency
        assert power == pytest.approx((1 - efficiency) * entering, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("speed", "factor"), [(20.0, 0.8), (200.0, 1 / 0.8)], ids=["the motor drives", "it is driven"])
def test_the_torques_before_and_after_the_transmission(speed, factor):
    """Their difference is the loss, and what acts on the rotor is what turns it: the reduced inertia times its acceleration."""
    machine = machine_with(LINEAR | {"transmission": GEAR | {"efficiency": 0.8}})
    result = run(RunUp(until=0.5, start={"drum": {"speed": speed}}), machine)
    time, w, motor, drive = result.time.values, result.speed.values[0], result.motor_torque.values, result.drive_torque.values
    assert motor == pytest.approx(3 * 0.05 * (270 - 3 * w), abs=1e-9)  # the ratio times that of the motor at its own speed
    assert drive == pytest.approx(factor * motor, rel=1e-9)

    def work(power):
        return np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])

    stored = REDUCED * (w**2 - speed**2) / 2
    for found, known in (
        (work((motor - drive) * w), result.dissipated_work), (work(motor * w), result.supplied_work), (work(drive * w), stored)
    ):  # fmt: skip
        assert found == pytest.approx(np.asarray(known), abs=1e-4 * np.abs(stored).max())
    assert np.abs(result.energy_residual.values).max() < 1e-9
    assert result.motor_torque.units == result.drive_torque.units == "N m"


def test_the_torques_are_those_of_the_averaged_motion_too():
    """Of a rotor that turns clockwise while its motor slows down by a schedule: first driving, at last driven."""
    drive = LINEAR | {"no_load_speed": -270.0, "transmission": GEAR | {"efficiency": 0.8}}
    slower = {"parameter": "drive.no_load_speed", "points": [[0.0, -270.0], [1.0, -270.0], [2.0, -60.0]]}
    machine = machine_with(
        drive, carrier=CARRIER | {"stiffness": 1e6}, bodies=[DRUM | {"eccentricity": 1e-4}], schedules=[slower]
    )
    result = run(RunUp(until=3.0, start={"drum": {"speed": -80.0}}, model="slow"), machine)
    motor, drive = result.motor_torque.values, result.drive_torque.values
    assert motor.min() < -1 < 1 < motor.max()
    assert drive == pytest.approx(np.where(motor < 0, 0.8 * motor, motor / 0.8), rel=1e-9)


def test_without_a_transmission_both_torques_are_one():
    result = run(RunUp(until=0.5, start={"drum": {"speed": 10.0}}), machine_with(LINEAR))
    assert result.drive_torque.values.tolist() == result.motor_torque.values.tolist()


def test_a_motor_on_a_free_carrier_keeps_its_angular_momentum():
    """With its stator on the carrier everything is inner: the motor's rotor turns i times as fast against it."""
    carrier = {"directions": "r", "inertia": 0.4, "rotation_stiffness": 0.0}
    drive = LINEAR | {"stator": "carrier", "transmission": GEAR | {"efficiency": 0.9}}
    rows = moved(machine_with(drive, carrier=carrier), 1.0)
    chi, w = rows["carrier.vr"], rows["drum.speed"]
    momentum = 0.4 * chi + 0.03 * w + 0.002 * (chi + 3 * (w - chi))
    assert w[-1] > 50
    assert np.abs(momentum).max() < 1e-10
    assert (w - chi)[-1] == pytest.approx(90, rel=1e-2)


def test_the_numbers_of_a_machine_see_the_reduced_drive():
    """Free speed, dimensionless numbers, the tangent of the characteristic, and the torque balance."""
    geared = machine_with(LINEAR | {"transmission": GEAR}, carrier=CARRIER, bodies=[DRUM])
    reduced = machine_with(LINEAR | {"slope": 0.45, "no_load_speed": 90}, carrier=CARRIER, bodies=[DRUM | {"inertia": REDUCED}])
    assert free_speed(geared, geared.rotor) == pytest.approx(90, rel=1e-12)
    assert dimensionless_numbers(geared) == pytest.approx(dimensionless_numbers(reduced), rel=1e-12)
    assert geared.drives[0].linearisation(50.0) == pytest.approx((0.45, 90.0), rel=1e-12)
    first, second = (run(TorqueBalance(), m).wucht.summary["working_points"] for m in (geared, reduced))
    assert [p["speed"] for p in first] == pytest.approx([p["speed"] for p in second], rel=1e-9)
    assert [p["torque"] for p in first] == pytest.approx([p["torque"] for p in second], rel=1e-9)


def test_breakdown_and_slip_are_seen_at_the_rotor():
    motor = {
        "kind": "induction", "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 0.5,
        "rotor_resistance": 0.5, "stator_reactance": 1.0, "rotor_reactance": 1.0,
    }  # fmt: skip
    gear = {"ratio": 4.0, "efficiency": 0.9}
    machine = machine_with(
        motor | {"transmission": gear}, carrier=CARRIER, bodies=[DRUM], load={"kind": "viscous", "coefficient": 1.0}
    )
    slip, speed, torque = machine.drives[0].breakdown()
    s = run(TorqueBalance(), machine.with_values({"drive.transmission.ratio": 5.0})).wucht.summary
    assert s["breakdown"]["slip"] == pytest.approx(slip)
    assert s["breakdown"]["speed"] == pytest.approx(speed / 5)
    assert s["breakdown"]["torque"] == pytest.approx(0.9 * 5 * torque, rel=1e-9)
    (point,) = s["working_points"]
    assert point["slip"] == pytest.approx(1 - 5 * point["speed"] / (50 * math.pi), rel=1e-12)
    assert point["torque"] == pytest.approx(point["speed"] * 1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("drive", "speed"),
    [
        ({"kind": "constant-speed", "speed": 90.0}, 30.0),
        ({"kind": "synchronous", "frequency": 50, "pole_pairs": 1}, 100 * math.pi / 3),
    ],
)
def test_a_prescribed_speed_is_that_of_the_motor(drive, speed):
    machine = machine_with(drive | {"transmission": GEAR})
    assert free_speed(machine, machine.rotor) == pytest.approx(speed, rel=1e-12)
    with refused("machine.drive.transmission"):
        machine_with(drive | {"transmission": GEAR | {"efficiency": 0.9}})


@pytest.mark.slow
def test_a_run_up_through_a_resonance_closes_its_balance():
    machine = machine_with(LINEAR | {"transmission": GEAR | {"efficiency": 0.85}}, carrier=CARRIER, bodies=[DRUM])
    s = run(RunUp(until="2 s"), machine).wucht.summary
    assert s["outcome"] == "passed"
    assert s["energy_residual"] < 1e-10


def test_a_coasting_rotor_drags_its_motor_along():
    """Switched off, the motor has inertia and no torque, so that its gear loses nothing."""
    load = {"kind": "viscous", "coefficient": 0.01}
    machine = machine_with(LINEAR | {"transmission": GEAR | {"efficiency": 0.5}}, carrier=CARRIER, load=load)
    s = run(CoastDown(start={"drum": {"speed": "50 rad/s"}}), machine).wucht.summary
    assert s["half_time"] == pytest.approx(math.log(2) * REDUCED / 0.01, rel=1e-3)


@pytest.mark.parametrize(
    ("transmission", "refusal"),
    [
        ({"ratio": 0}, refused("machine.drive.transmission.ratio", given=0, code="limits")),
        ({"ratio": 2, "efficiency": 1.2}, refused("machine.drive.transmission.efficiency", given=1.2, code="limits")),
        ({"ratio": 2, "efficiency": 0}, refused("machine.drive.transmission.efficiency", code="limits")),
        ({"ratio": 2, "inertia": "1 kg"}, refused("machine.drive.transmission.inertia", code="dimension")),
        ({"inertia": 1}, refused("machine.drive.transmission.ratio", code="missing")),
        ({"ratio": 2, "slip": 0.02}, refused("machine.drive.transmission.slip", code="unknown-key")),
        (3, refused("machine.drive.transmission", given=3, code="type")),
    ],
)
def test_bad_transmissions_are_refused(transmission, refusal):
    with refusal:
        machine_with(LINEAR | {"transmission": transmission})


def test_in_python_a_transmission_is_a_table_too():
    assert LinearDrive(slope=1, no_load_speed=90, transmission={"ratio": "3"}).torque_at(0.0) == 270.0
