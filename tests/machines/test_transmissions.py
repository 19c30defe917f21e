"""Gears and belts: the reduced drive, closed solutions, and a loss that never gives energy, whichever way the power flows."""

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import refused

from wucht import RunUp, run
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.machines.operation import free_speed
from wucht.machines.parts import ConstantTorque
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

BALANCED = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.03}
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
