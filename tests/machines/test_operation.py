"""Operation without vibration: what several drives reach together, and the inertias of their rotors."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import eigh

from wucht import SynchronousStates, run
from wucht.analysis.working_points import is_held_at_rest
from wucht.files.building import machine_from
from wucht.machines import operation
from wucht.machines.operation import (
    axis_at_rest,
    common_free_speed,
    driven_speeds,
    free_speed,
    free_speed_from,
    has_damped_balancers,
    machine_at_speed,
    natural_frequencies,
    net_torque,
    operating_speed,
    relative_damping,
    rotor_inertia,
    sense_of,
    shaft_torques,
)
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


BALL = {"kind": "pendulum", "name": "p", "about": "r0", "mass": 0.5, "length": 0.2, "damping": 0.1}


def alone(drive=None, carrier=CARRIER, rotor=None, **more):
    """One rotor, with a drive or without."""
    drives = {"drives": [drive | {"on": "r0"}]} if drive else {}
    return machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "r0"} | (rotor or {})]} | drives | more)


def test_the_axis_hangs_at_rest_by_the_weight_of_all():
    """10 kg, a rotor of 2 kg and a pendulum of 0.5 kg on springs of 1e4 and 2e4 N/m."""
    machine = machine_from(
        {
            "carrier": CARRIER | {"stiffness": [1e4, 2e4], "damping": [10.0, 10.0], "gravity": 9.81},
            "bodies": [ROTOR | {"name": "r0"}, BALL],
        }
    )
    assert axis_at_rest(machine) == pytest.approx({"x": 0.0, "y": -12.5 * 9.81 / 2e4})
    assert axis_at_rest(alone()) == pytest.approx({"x": 0.0, "y": 0.0})


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


@pytest.mark.parametrize("torque", [0.5, -0.5])
def test_a_drive_that_nothing_limits_turns_as_it_starts(torque):
    machine = together({"kind": "constant-torque", "torque": torque}, None)
    assert free_speed(machine, machine.rotor) is None
    assert [sense_of(machine, b) for b in machine.bodies] == [math.copysign(1.0, torque), 1.0]


def test_the_damper_between_two_bodies_is_that_of_the_later_one():
    """Of two balls one is not damped; the bearing of the rotor is no damper between bodies."""
    bodies = [ROTOR | {"name": "r0", "bearing_damping": 0.7}, BALL, BALL | {"name": "q", "damping": 0.0}]
    machine = machine_from({"carrier": CARRIER, "bodies": bodies})
    assert [float(relative_damping(machine, b)) for b in machine.bodies[1:]] == [0.1, 0.0]
    assert not has_damped_balancers(machine)
    assert has_damped_balancers(machine.with_values({"q.damping": 0.01}))
    assert has_damped_balancers(alone())


def test_natural_frequencies_of_directions_and_of_coupled_modes():
    """With the rotor beside the centre of mass x and the rotation move together: modes, the lowest first."""
    assert natural_frequencies(alone(carrier=CARRIER | {"stiffness": [1e4, 4e4], "damping": [1.0, 1.0]})) == pytest.approx(
        {"x": math.sqrt(1e4 / 12), "y": math.sqrt(4e4 / 12)}
    )
    carrier = CARRIER | {"directions": "xyr", "inertia": 2.0, "stiffness": [1e4, 4e4], "damping": [1.0, 1.0]}
    carrier |= {"rotation_stiffness": 500.0, "rotation_damping": 1.0}
    frequencies = natural_frequencies(
        machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "r0", "position": [0.0, 0.5]}]})
    )
    # Kinetic energy 10 x'^2/2 + 2 (x' - 0.5 psi')^2/2 + 12 y'^2/2 + 2 psi'^2/2.
    mass = np.array([[12.0, 0.0, -1.0], [0.0, 12.0, 0.0], [-1.0, 0.0, 2.5]])
    exact = np.sqrt(eigh(np.diag([1e4, 4e4, 500.0]), mass, eigvals_only=True))
    assert list(frequencies) == ["mode 1", "mode 2", "mode 3"]
    assert list(frequencies.values()) == pytest.approx(exact.tolist())


def test_the_operating_speed_is_the_largest_of_drives_and_resonances_in_magnitude():
    natural = math.sqrt(1e4 / 14)  # the carrier with two rotors
    assert operating_speed(together(linear(0.3, 100.0), linear(0.1, -160.0))) == pytest.approx(160.0)
    assert operating_speed(together(linear(0.3, 10.0), linear(0.1, -20.0))) == pytest.approx(natural)
    assert operating_speed(alone(carrier={"directions": "fixed"})) == 1.0


@pytest.mark.parametrize("sense", [1, -1])
def test_speeds_that_drives_reach_are_searched_up_to_a_little_above_the_highest(sense):
    (low, high), runs_away = driven_speeds(together(linear(0.3, 40.0), linear(0.1, sense * 60.0)))
    assert (low, high) == pytest.approx((0.06, 60.006))
    assert not runs_away


def test_a_drive_that_nothing_holds_is_searched_up_to_three_times_the_highest_resonance():
    torque = {"kind": "constant-torque", "torque": 0.5}
    natural = math.sqrt(4e4 / 14)
    stiff = CARRIER | {"stiffness": [1e4, 4e4], "damping": [1.0, 1.0]}

    def two(speed):
        bodies = [ROTOR | {"name": "r0"}, ROTOR | {"name": "r1"}]
        drives = [torque | {"on": "r0"}, linear(0.1, speed) | {"on": "r1"}]
        return driven_speeds(machine_from({"carrier": stiff, "bodies": bodies, "drives": drives}))

    assert two(60.0) == (pytest.approx((3e-3 * natural, 3 * natural)), True)
    assert two(-400.0) == (pytest.approx((0.4, 400.0)), True)
    assert driven_speeds(alone(torque, carrier={"directions": "fixed"})) == (pytest.approx((0.3, 300.0)), True)
    assert driven_speeds(alone()) == (pytest.approx((0.0, 0.0)), False)


def test_a_machine_at_a_speed_has_the_last_values_and_nothing_locked():
    schedule = {"parameter": "drive.no_load_speed", "points": [[0, 50.0], [4, 90.0]]}
    locked = BALL | {"release": {"time": 2.0}}
    machine = machine_from(
        {"carrier": CARRIER, "bodies": [ROTOR | {"name": "r0"}, locked], "drive": linear(0.3, 50.0), "schedules": [schedule]}
    )
    steady = machine_at_speed(machine, None)
    assert not steady.schedules
    assert all(b.release is None for b in steady.bodies)
    assert free_speed(steady, steady.rotor) == pytest.approx(90.0)
    turned = machine_at_speed(machine, -33.0)
    assert free_speed(turned, turned.rotor) == -33.0
    assert [b.coordinate.prescribed_velocity is None for b in turned.bodies] == [False, True]


def test_a_prescribed_speed_with_a_schedule_is_steady_at_the_end_of_that():
    drive = {"on": "r0", "kind": "constant-speed", "speed": 50.0}
    schedule = {"parameter": "drive.speed", "points": [[0, 0.0], [4, 90.0]]}
    bodies = [ROTOR | {"name": "r0"}, BALL, BALL | {"name": "second"}]
    machine = machine_from({"carrier": CARRIER, "bodies": bodies, "drive": drive, "schedules": [schedule]})
    steady = machine_at_speed(machine, None)
    assert free_speed(steady, steady.rotor) == pytest.approx(90.0)
    summary = run(SynchronousStates(), machine).wucht.summary
    assert summary["speed"] == pytest.approx(90.0) and summary["states"]


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


@pytest.mark.parametrize("speed", [0.0, 90.0, 300.0, -300.0])
def test_a_motor_that_starts_reaches_one_speed_from_any(speed):
    """To the last bit: the equilibrium from standstill is the one that is returned."""
    for machine in (held_motor(20.0), together(linear(0.3, 100.0))):
        assert free_speed_from(machine, machine.rotors[0], speed) == free_speed(machine, machine.rotors[0])
        assert not is_held_at_rest(machine)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_load_is_held_at_speed_in_either_sense(sense):
    """A torque between 60 and 150 rad/s alone, and a creep of 0.4 rad/s: the mirror image of a clockwise motor."""
    corners = [(-400.0, 5.0), (0.0, 0.4), (0.8, -0.4), (59.0, -1.0), (61.0, 1.0), (149.0, 1.0), (151.0, -1.0), (400.0, -1.0)]
    points = sorted([sense * w, sense * torque] for w, torque in corners)
    drum = {"kind": "rotor", "name": "drum", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01}
    document = {"carrier": {"directions": "fixed"}, "bodies": [drum], "drive": {"kind": "table", "points": points}}
    machine = machine_from(document)
    for speed, reached in ((120.0, 150.0), (300.0, 150.0), (20.0, 0.4), (0.1, 0.4)):
        assert free_speed_from(machine, machine.rotor, sense * speed) == pytest.approx(
            sense * reached, rel=2e-3
        )  # a smooth table


@pytest.mark.parametrize(
    ("torque", "driven"),
    [
        (lambda w: -0.1 * w, False),  # a brake, in either sense
        (lambda w: 0.1 * w * (50.0 - abs(w)), True),  # as a DC motor in series with its field, once it turns
        (lambda w: -1.0 if w <= 0 else 0.0, True),  # clockwise from standstill
        (lambda w: 0.0, False),
    ],
)
def test_a_brake_drives_nothing(torque, driven, monkeypatch):
    monkeypatch.setattr(operation, "shaft_torques", lambda machine, rotor: (torque, None))
    machine = SimpleNamespace(function=lambda drive, of, modules: lambda w: (drive(w),))
    assert operation.is_driven(machine, None, 100.0) is driven
