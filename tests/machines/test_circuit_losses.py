"""The heat in the circuits of motors: with the power on the shaft it is what their circuits take from the supply."""

import math

import pytest
import sympy as sp

from wucht.machines.parts import drives
from wucht.schema import validate_table

W = sp.Symbol("w", real=True)
INDUCTION = {
    "on": "m", "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 0.5, "rotor_resistance": 0.4,
    "stator_reactance": 1.1, "rotor_reactance": 1.2,
}  # fmt: skip
MAGNETISING = {"magnetising_reactance": 25.0}
SEPARATE = {"on": "m", "voltage": 200, "armature_resistance": 2, "motor_constant": 1.5, "flux": "0.8 V s"}
WOUND = {
    "on": "m", "voltage": 200, "armature_resistance": 2, "field_resistance": 3, "field_inductance": "0.1 H",
    "motor_constant": 1.5,
}  # fmt: skip


def part(kind, table):
    return validate_table(drives()[kind], table, "machine.drive")


def supplied_power(motor, speed):
    law = motor.circuit_loss(W) + motor.torque(W) * W
    return motor.number(law.subs(W, speed))


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(
    "further", [{}, {"magnetising_reactance": 25.0}, {"magnetising_reactance": 25.0, "standstill_resistance": 0.9}]
)
@pytest.mark.parametrize("slip", [1.0, 0.3, 0.02, -0.05])
def test_an_induction_motor_takes_the_active_power_of_its_circuit(further, slip, sense):
    """The circuit in complex numbers is another formulation: P = Re(3 U^2/Z*)."""
    motor = part("induction", INDUCTION | further | {"sense": sense})
    speed = motor.synchronous_speed() * (1 - slip)
    circuit = part("induction", INDUCTION | further).circuit_at(230.0, 50.0)
    assert supplied_power(motor, speed) == pytest.approx(circuit.complex_power(slip).real, rel=1e-10)


@pytest.mark.parametrize("speed", [0.0, 60.0, 150.0, 200.0])
def test_direct_current_motors_take_voltage_times_current(speed):
    current = (200 - 1.5 * 0.8 * speed) / 2
    assert supplied_power(part("dc-separate", SEPARATE), speed) == pytest.approx(200 * current, rel=1e-12)
    constant = 1.5 * 0.1
    series = 200 / (5 + constant * speed)
    assert supplied_power(part("dc-series", WOUND), speed) == pytest.approx(200 * series, rel=1e-12)
    field = 200 / 3
    armature = (200 - constant * field * speed) / 2
    assert supplied_power(part("dc-shunt", WOUND), speed) == pytest.approx(200 * (armature + field), rel=1e-12)


@pytest.mark.parametrize("kind", ["dc-series", "dc-shunt"])
def test_turned_backwards_a_motor_takes_the_same(kind):
    assert supplied_power(part(kind, WOUND | {"sense": -1}), -60.0) == pytest.approx(supplied_power(part(kind, WOUND), 60.0))


def test_a_drive_known_by_its_torque_has_no_circuit():
    assert part("linear", {"on": "m", "slope": 0.1, "no_load_speed": 150}).circuit_loss(W) is None
    assert math.isclose(part("linear", {"on": "m", "slope": 0.1, "no_load_speed": 150}).torque_at(50.0), 10.0)
