"""Drives: each kind is known by its name, its keys are those of the contract, and its torque is its formula."""

import math

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import refused

from wucht.errors import InputError
from wucht.machines.parts import drives
from wucht.schema import validate_table

few = settings(max_examples=40, deadline=None)
INDUCTION = {
    "on": "m", "voltage": "230 V", "frequency": "50 Hz", "pole_pairs": 2, "stator_resistance": "0.5 ohm",
    "rotor_resistance": "0.4 ohm", "stator_reactance": "1.1 ohm", "rotor_reactance": "1.2 ohm",
}  # fmt: skip
SEPARATE = {"on": "m", "voltage": 200, "armature_resistance": 2, "motor_constant": 1.5, "flux": "0.8 V s"}
WOUND = {
    "on": "m", "voltage": 200, "armature_resistance": 2, "field_resistance": 1, "field_inductance": "0.1 H",
    "motor_constant": 1.5,
}  # fmt: skip
POINTS = [["0 rpm", "5 N m"], [100, 8.0], [150, 0.0]]

DESCRIBED = {
    "constant-torque": {"on": "m", "torque": "5 N m"},
    "dc-separate": SEPARATE,
    "dc-shunt": WOUND,
    "dc-series": WOUND,
    "induction": INDUCTION,
    "linear": {"on": "m", "slope": 0.1, "no_load_speed": 150},
    "table": {"on": "m", "points": POINTS},
}


def drive(kind, **changes):
    """A drive as a study file describes it."""
    described = {**DESCRIBED.get(kind, {"on": "m"}), **changes}
    return validate_table(drives()[kind], {k: v for k, v in described.items() if v is not None}, "machine.drive")


def values(part):
    return {p.path: p.value for p in part.parameters()}


@pytest.mark.parametrize("kind", sorted(DESCRIBED))
@pytest.mark.parametrize("speed", [-40.0, 1.0, 37.0, 120.0, 220.0])
def test_the_line_through_a_working_point_is_the_tangent(kind, speed):
    made, h = drive(kind), 1e-3
    slope, no_load = made.linearisation(speed)
    assert slope == pytest.approx(-(made.torque_at(speed + h) - made.torque_at(speed - h)) / (2 * h), rel=1e-5, abs=1e-9)
    if slope:
        assert slope * (no_load - speed) == pytest.approx(made.torque_at(speed), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "speed", "torque"),
    [
        ("dc-separate", 50.0, 1.2 * (200 - 1.2 * 50) / 2),  # k Phi = 1.2 V s
        ("dc-shunt", 2.0, 30.0 * (200 - 30.0 * 2) / 2),  # k L U/R_E = 30 V s
        ("dc-series", 10.0, 0.15 * (200 / (2 + 1 + 0.15 * 10)) ** 2),  # k L times the square of the current
        ("linear", 50.0, 0.1 * (150 - 50)),
    ],
)
def test_torques_of_direct_current_by_hand(kind, speed, torque):
    assert drive(kind).torque_at(speed) == pytest.approx(torque, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["dc-shunt", "dc-series", "induction"])
@few
@given(speed=st.floats(-300, 300))
def test_sense_turns_a_motor_round(kind, speed):
    if kind == "dc-series" and speed < -15:
        return  # beyond the pole at -R/(k L) = -20 rad/s the formula means nothing
    assert drive(kind, sense=-1).torque_at(-speed) == pytest.approx(-drive(kind).torque_at(speed), rel=1e-12, abs=1e-12)


def test_reactances_hold_at_the_rated_frequency():
    """Half the frequency halves a reactance; without rated_frequency they are those at the given frequency."""
    assert values(drive("induction"))["drive.rated_frequency"] == 50.0
    half = drive("induction", frequency="25 Hz", rated_frequency="3000 rpm")
    same = drive("induction", frequency="25 Hz", stator_reactance=0.55, rotor_reactance=0.6)
    assert half.torque_at(60.0) == pytest.approx(same.torque_at(60.0), rel=1e-14)
    assert half.breakdown() == pytest.approx(same.breakdown(), rel=1e-14)


def test_synchronous():
    made = drive("synchronous", frequency="50 Hz", pole_pairs=2, angle="90 deg", sense=-1)
    numbers = {sp.Symbol(path, real=True): value for path, value in values(made).items()}
    assert float(made.prescribed_speed().subs(numbers)) == pytest.approx(-math.pi * 50)
    assert made.start_angle() == pytest.approx(math.pi / 2)


increasing = st.lists(st.tuples(st.floats(0.1, 50), st.floats(-20, 20)), min_size=2, max_size=8)


@few
@given(steps=increasing, at=st.floats(-20, 420))
def test_between_two_points_a_table_stays_between_their_torques(steps, at):
    speeds = [sum(h for h, _ in steps[: i + 1]) for i in range(len(steps))]
    torques = [t for _, t in steps]
    torque = drive("table", points=[list(p) for p in zip(speeds, torques, strict=True)]).torque_at(at)
    i = sum(w <= at for w in speeds)
    near = torques[max(i - 1, 0) : i + 1]
    assert min(near) - 1e-9 <= torque <= max(near) + 1e-9


@pytest.mark.parametrize(
    ("kind", "changes", "refusal"),
    [
        ("table", {"points": [[0, 1]]}, refused("machine.drive.points", given=[[0, 1]])),
        ("table", {"points": [[0, 1], [2]]}, refused("machine.drive.points", given=[[0, 1], [2]])),
        ("table", {"points": [[0, 1], [0, 2]]}, refused("machine.drive.points", "0 rad/s", given=[[0, 1], [0, 2]])),
        ("table", {"points": [[0, 1], [1, math.nan]]}, refused("machine.drive.points", code="not-finite")),
        ("induction", {"frequency": "0 Hz"}, refused("machine.drive.frequency", given="0 Hz")),
    ],
)
def test_bad_values_are_refused_with_place_and_remedy(kind, changes, refusal):
    with refusal:
        drive(kind, **changes)


@pytest.mark.parametrize(
    ("kind", "changes", "field"),
    [
        ("induction", {"pole_pairs": 1.5}, "pole_pairs"),
        ("synchronous", {"frequency": 50, "pole_pairs": 1.5}, "pole_pairs"),
        ("induction", {"stator_reactance": 0, "rotor_reactance": 0}, "rotor_reactance"),
    ],
)
def test_impossible_motors_are_refused(kind, changes, field):
    with pytest.raises(InputError, match="must be") as error:
        drive(kind, **changes)
    assert error.value.location == f"machine.drive.{field}"


W = sp.Symbol("w", real=True)
CIRCUIT = {
    "on": "m", "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 0.5, "rotor_resistance": 0.4,
    "stator_reactance": 1.1, "rotor_reactance": 1.2,
}  # fmt: skip
WINDING = WOUND | {"field_resistance": 3}


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
    motor = part("induction", CIRCUIT | further | {"sense": sense})
    speed = motor.synchronous_speed() * (1 - slip)
    circuit = part("induction", CIRCUIT | further).circuit_at(230.0, 50.0)
    assert supplied_power(motor, speed) == pytest.approx(circuit.complex_power(slip).real, rel=1e-10)


@pytest.mark.parametrize("speed", [0.0, 60.0, 150.0, 200.0])
def test_direct_current_motors_take_voltage_times_current(speed):
    current = (200 - 1.5 * 0.8 * speed) / 2
    assert supplied_power(part("dc-separate", SEPARATE), speed) == pytest.approx(200 * current, rel=1e-12)
    constant = 1.5 * 0.1
    series = 200 / (5 + constant * speed)
    assert supplied_power(part("dc-series", WINDING), speed) == pytest.approx(200 * series, rel=1e-12)
    field = 200 / 3
    armature = (200 - constant * field * speed) / 2
    assert supplied_power(part("dc-shunt", WINDING), speed) == pytest.approx(200 * (armature + field), rel=1e-12)


@pytest.mark.parametrize("kind", ["dc-series", "dc-shunt"])
def test_turned_backwards_a_motor_takes_the_same(kind):
    assert supplied_power(part(kind, WINDING | {"sense": -1}), -60.0) == pytest.approx(
        supplied_power(part(kind, WINDING), 60.0)
    )


def test_a_drive_known_by_its_torque_has_no_circuit():
    assert part("linear", {"on": "m", "slope": 0.1, "no_load_speed": 150}).circuit_loss(W) is None
    assert math.isclose(part("linear", {"on": "m", "slope": 0.1, "no_load_speed": 150}).torque_at(50.0), 10.0)
