"""Operation without vibration: what several drives reach together, and the inertias of their rotors."""

import pytest

from wucht.files.building import machine_from
from wucht.machines.operation import common_free_speed, rotor_inertia

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


@pytest.mark.parametrize(("damping", "speed"), [(0.0, None), (0.1, 0.0)])
def test_without_drives_rotors_rest_or_turn_as_they_do(damping, speed):
    bodies = [ROTOR | {"name": n, "bearing_damping": damping} for n in "ab"]
    assert common_free_speed(machine_from({"carrier": CARRIER, "bodies": bodies})) == speed


def test_the_inertia_of_a_rotor_has_its_bodies_and_its_motor_but_no_other_rotor():
    bodies = [
        ROTOR | {"name": "a"},
        {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.5, "length": 0.2, "inertia": 0.03, "damping": 0.1},
        ROTOR | {"name": "b"},
    ]
    drive = linear(0.3, 100.0) | {"on": "b", "transmission": {"ratio": 3.0, "inertia": 0.002}}
    machine = machine_from({"carrier": CARRIER, "bodies": bodies, "drives": [drive]})
    a, b = (rotor_inertia(machine, r) for r in machine.rotors)
    assert a == pytest.approx(0.03 + 0.03, rel=1e-12)
    assert b == pytest.approx(0.03 + 9 * 0.002, rel=1e-12)
