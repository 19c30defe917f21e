"""What drives a rotor and what brakes it: whether a swing can only lose energy, and what is left beside a vibration."""

import numpy as np
import pytest

from wucht.analysis.vibration import Vibration
from wucht.analysis.working_points import is_only_braked, torque_surplus
from wucht.files.building import machine_from

CARRIER = {"mass": 6.0, "stiffness": 1e4, "damping": 20.0, "gravity": 9.81}
ROTOR = {"kind": "rotor", "name": "d", "mass": 4.0, "unbalance": 0.05, "inertia": 0.1, "bearing_damping": 1e-3}
BALL = {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.1, "length": 0.1, "damping": 0.01}
MOTION = {"direction": "x", "amplitude": 1e-3, "frequency": 30.0}
SLOPE, FREE = 0.02, 90.0
LINEAR = {"kind": "linear", "slope": SLOPE, "no_load_speed": FREE}
RISING = {"kind": "table", "points": [[-50, 1.5], [0, 1.0], [10, 0.5], [20, 0.9], [30, 2.0]]}


def machine(bodies=(ROTOR,), carrier=CARRIER, **more):
    return machine_from({"carrier": carrier, "bodies": list(bodies)} | more)


@pytest.mark.parametrize(
    "braked",
    [
        machine(),
        machine([ROTOR | {"bearing_damping": 0.0}]),
        machine([ROTOR, BALL]),
        machine(carrier={"directions": "fixed"}),
        machine(drive=LINEAR),
        machine(drive={"kind": "constant-torque", "torque": 0.5}),
        machine(loads=[{"kind": "viscous", "coefficient": 0.01}, {"kind": "coulomb", "torque": 0.05}]),
        machine([ROTOR, ROTOR | {"name": "e"}], drives=[{"on": "e"} | LINEAR]),
    ],
    ids=["bearing", "no losses", "ball", "fixed", "linear drive", "constant torque", "loads", "two rotors"],
)
def test_a_swing_can_only_lose_energy_to_what_is_damped(braked):
    assert is_only_braked(braked, 50.0)


@pytest.mark.parametrize(
    "fed",
    [
        machine(carrier={"directions": "x", "mass": 6.0, "motion": MOTION}),
        machine(drive={"kind": "constant-speed", "speed": 10.0}),
        machine([ROTOR, ROTOR | {"name": "e"}], drives=[{"on": "e", "kind": "constant-speed", "speed": 10.0}]),
        machine([ROTOR, BALL | {"damping": 0.0}]),
        machine(carrier=CARRIER | {"damping": 0.0}),
        machine(drive=RISING),
        machine([ROTOR, ROTOR | {"name": "e"}], drives=[{"on": "e"} | RISING]),
    ],
    ids=["shaken", "prescribed", "another prescribed", "free ball", "free carrier", "rising torque", "of another rotor"],
)
def test_not_so_where_it_is_shaken_driven_by_more_at_a_speed_than_at_rest_or_not_damped(fed):
    assert not is_only_braked(fed, 50.0)


@pytest.mark.parametrize(("fastest", "braked"), [(20.0, True), (21.0, True), (25.0, False)])
def test_speeds_beyond_the_fastest_do_not_matter(fastest, braked):
    """The torque of the drive exceeds that at rest from 21 rad/s on."""
    assert is_only_braked(machine([ROTOR | {"bearing_damping": 0.0}], drive=RISING), fastest) is braked


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_surplus_of_the_drive_over_the_vibration(sense):
    """On an isotropic carrier the vibration takes c w z^2 with z = U w^2/|k - m w^2 + i c w|; bearings take b w."""
    driven = machine(carrier=CARRIER | {"gravity": 0.0}, drive=LINEAR | {"no_load_speed": sense * FREE})
    w = np.array([5.0, 30.0, 31.6, 35.0, 80.0, 120.0])
    z = 0.05 * w**2 / np.abs(1e4 - 10 * w**2 + 20j * w)
    surplus = torque_surplus(driven, Vibration.of(driven), np.zeros(1), w)
    assert surplus == pytest.approx(SLOPE * (FREE - w) - 1e-3 * w - 20 * w * z**2, rel=1e-9)
    assert surplus[0] > 0 > surplus[2]


def test_bodies_that_compensate_leave_the_drive_all_of_its_torque():
    driven = machine([ROTOR | {"unbalance": 0.01}, BALL], drive=LINEAR)
    w = np.array([20.0, 50.0])
    surplus = torque_surplus(driven, Vibration.of(driven), np.array([0.0, np.pi]), w)
    assert surplus == pytest.approx(SLOPE * (FREE - w) - 1e-3 * w, rel=1e-9)
