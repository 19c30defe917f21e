"""Operation without vibration: what several drives reach together, and the inertias of their rotors."""

import math

import pytest

from wucht.analysis.working_points import is_held_at_rest
from wucht.files.building import machine_from
from wucht.machines.operation import common_free_speed, free_speed, free_speed_from, net_torque, sense_of, shaft_torques
from wucht.machines.structure import SPEED

ROTOR = {"kind": "rotor", "mass": 2.0, "eccentricity": 0.1, "inertia": 0.03}
CARRIER = {"mass": 10.0, "stiffness": 1e4, "damping": 10.0}


def together(*drives, loads=()):
    """A machine with a rotor for each drive, some of them without."""
    bodies = [ROTOR | {"name": f"r{i}"} for i in range(len(drives))]
    on = [d | {"on": f"r{i}"} for i, d in enumerate(drives) if d]
    return machine_from({"carrier": CARRIER, "bodies": bodies, "drives": on, "loads": list(loads)})


def linear(slope, speed):
    return {"kind": "linear", "slope": slope, "no_load_speed": speed}


@pytest.mark.parametrize("sense", [1, -1])
def test_drives_of_rotors_that_turn_at_one_speed_are_in_balance(sense):
    """The mean of their speeds, weighted by their slopes; senses do not count."""
    assert common_free_speed(together(linear(0.3, 100.0), linear(0.1, sense * 60.0))) == pytest.approx(90.0, rel=1e-12)


def test_a_rotor_that_nothing_drives_brakes_by_its_load():
    load = {"kind": "quadratic", "on": "r1", "coefficient": 1e-3}
    w = common_free_speed(together(linear(0.3, 100.0), None, loads=[load]))
    assert 0.3 * (100 - w) == pytest.approx(1e-3 * w**2, rel=1e-12)


BALL = {"kind": "pendulum", "name": "p", "about": "r0", "mass": 0.5, "length": 0.2, "damping": 0.1}


def alone(drive=None, carrier=CARRIER, rotor=None, **more):
    """One rotor, with a drive or without."""
    drives = {"drives": [drive | {"on": "r0"}]} if drive else {}
    return machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "r0"} | (rotor or {})]} | drives | more)


@pytest.mark.parametrize("sense", [1, -1])
def test_shaft_torques_are_those_of_drives_and_of_losses(sense):
    """A load on the ball's rotor, the bearing and a straight characteristic; dampers between bodies take nothing."""
    machine = machine_from(
        {
            "carrier": CARRIER,
            "bodies": [ROTOR | {"name": "r0", "bearing_damping": 0.02}, BALL],
            "drives": [linear(0.3, sense * 100.0) | {"on": "r0"}],
            "loads": [{"kind": "quadratic", "on": "r0", "coefficient": 1e-3}],
        }
    )
    w = sense * 40.0
    drive, losses = (float(machine.function(t, of=SPEED)(w)[0]) for t in shaft_torques(machine, machine.rotor))
    assert drive == pytest.approx(0.3 * (sense * 100 - w))
    assert losses == pytest.approx(0.02 * w + sense * 1e-3 * w**2)
    assert net_torque(machine, machine.rotor)(w) == pytest.approx(drive - losses)
    assert sense_of(machine, machine.rotor) == sense_of(machine, machine.bodies[1]) == sense


@pytest.mark.parametrize("sense", [1, -1])
def test_a_speed_at_which_a_curved_torque_vanishes(sense):
    """Of a motor against a fan: 0.3 (100 - w) = 1e-3 w^2, in the sense of the motor."""
    machine = alone(linear(0.3, sense * 100.0), loads=[{"kind": "quadratic", "on": "r0", "coefficient": 1e-3}])
    exact = (-0.3 + math.sqrt(0.09 + 4e-3 * 30)) / 2e-3
    assert free_speed(machine, machine.rotor) == pytest.approx(sense * exact, rel=1e-12)


def held_motor(load):
    """An induction motor with a breakdown torque of 61 N m and 31 N m at standstill, against dry friction."""
    motor = {
        "kind": "induction", "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 2.0,
        "rotor_resistance": 1.5, "stator_reactance": 3.0, "rotor_reactance": 3.0,
    }  # fmt: skip
    return together(motor, loads=[{"kind": "coulomb", "on": "r0", "torque": load}])


def test_a_motor_that_does_not_start_holds_its_load_at_speed():
    """From beyond the unstable crossing it reaches its working point, from below it and from standstill a creep."""
    machine = held_motor(40.0)
    rotor = machine.rotors[0]
    creep, fast = free_speed(machine, rotor), free_speed_from(machine, rotor, 120.0)
    assert creep < 0.5
    assert 140.0 < fast < 50 * math.pi
    assert net_torque(machine, rotor)(fast) == pytest.approx(0.0, abs=1e-9)
    assert free_speed_from(machine, rotor, 150.0) == pytest.approx(fast, rel=1e-12)  # from above
    assert free_speed_from(machine, rotor, 20.0) == free_speed_from(machine, rotor, 0.0) == creep
    assert is_held_at_rest(machine)
