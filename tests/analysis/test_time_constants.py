"""How long transients last: against the closed forms of linear machines."""

import math

import numpy as np
import pytest

from wucht.analysis.time_constants import run_up_time, runaway_limit, slowest_decay, vibration_decay
from wucht.analysis.working_points import swing_frequency
from wucht.files.building import machine_from

MASS, DAMPING, INERTIA, SLOPE, FREE = 10.0, 40.0, 0.02, 1e-3, 200.0
ROTOR = {"kind": "rotor", "name": "d", "mass": 4.0, "unbalance": 1e-9, "inertia": INERTIA}
LINEAR = {"kind": "linear", "slope": SLOPE, "no_load_speed": FREE}
CARRIER = {"directions": "x", "mass": MASS - 4.0, "stiffness": 1e5, "damping": DAMPING}


def machine(**changes):
    return machine_from({"carrier": CARRIER, "bodies": [ROTOR], "drive": LINEAR} | changes)


def test_a_free_vibration_falls_with_half_the_damping_over_the_mass():
    assert vibration_decay(machine()) == pytest.approx(2 * MASS / DAMPING, rel=1e-6)
    assert vibration_decay(machine(carrier=CARRIER | {"damping": 0.0})) == 0.0
    assert vibration_decay(machine(carrier={"directions": "fixed"})) == 0.0


def test_the_slowest_is_the_drive_the_carrier_or_a_slipping_body():
    assert slowest_decay(machine(), FREE) == pytest.approx(INERTIA / SLOPE, rel=1e-4)
    assert slowest_decay(machine(drive=LINEAR | {"slope": 1.0}), FREE) == pytest.approx(2 * MASS / DAMPING, rel=1e-4)
    pendulum = {"kind": "pendulum", "name": "p", "about": "d", "mass": 1e-3, "length": 0.1, "damping": 1e-8}
    slipping = machine(bodies=[ROTOR, pendulum], drive={"kind": "constant-speed", "speed": FREE})
    assert slowest_decay(slipping, FREE) == pytest.approx(1e-3 * 0.1**2 / 1e-8, rel=1e-3)


def test_a_rotor_in_gravity_swings_as_a_pendulum():
    heavy = machine(bodies=[ROTOR | {"unbalance": 0.05}], carrier={"directions": "fixed", "gravity": 9.81})
    assert swing_frequency(heavy) == pytest.approx(np.sqrt(9.81 * 0.05 / INERTIA), rel=1e-9)
    assert swing_frequency(machine()) == 0.0


SENSES = pytest.mark.parametrize("sense", [1.0, -1.0])


@SENSES
def test_a_run_up_takes_as_long_in_either_sense_from_a_speed_in_either_sense(sense):
    """The speed from which it begins counts by its magnitude."""
    driven = machine(drive=LINEAR | {"no_load_speed": sense * FREE})
    expected = INERTIA / SLOPE * math.log((FREE - 100) / (0.005 * FREE))
    for begin in (100.0, -100.0):
        assert run_up_time(driven, begin) == pytest.approx(expected, rel=2e-2)
    for beyond in (199.5, -199.5, 250.0, -250.0):
        assert run_up_time(driven, beyond) == 0.0


@SENSES
def test_a_runaway_takes_as_long_in_either_sense(sense):
    free = machine(drive={"kind": "constant-torque", "torque": sense * 0.5})
    assert runaway_limit(free) == pytest.approx(3000.0)
    assert run_up_time(free, 0.0) == pytest.approx(INERTIA * 3000 / 0.5, rel=1e-6)
    assert run_up_time(free, -sense * 1000.0) == pytest.approx(INERTIA * 2000 / 0.5, rel=1e-6)
    assert run_up_time(free, 3000.0) == 0.0


def test_a_machine_that_nothing_drives_neither_runs_up_nor_away():
    coasting = machine_from({"carrier": CARRIER, "bodies": [ROTOR]})
    assert (runaway_limit(coasting), run_up_time(coasting, 0.0)) == (None, 0.0)
    prescribed = machine(drive={"kind": "constant-speed", "speed": FREE})
    assert (runaway_limit(prescribed), run_up_time(prescribed, 0.0)) == (None, 0.0)


@SENSES
def test_the_slowest_of_two_slips_is_that_of_the_larger_inertia_over_its_damper(sense):
    """Balls about a rotor of prescribed speed: m l^2/b of each, 1 s and 0.2 s; the carrier decays within a millisecond."""
    balls = [
        {"kind": "pendulum", "name": n, "about": "d", "mass": 1e-3, "length": 0.1, "damping": b}
        for n, b in (("p", 1e-5), ("q", 5e-5))
    ]
    drive = {"kind": "constant-speed", "speed": sense * FREE}
    stiff = CARRIER | {"damping": 4e3}
    slipping = machine(bodies=[ROTOR, *balls], drive=drive, carrier=stiff)
    assert slowest_decay(slipping, sense * FREE) == pytest.approx(1.0, rel=1e-3)
    assert slowest_decay(machine(bodies=[ROTOR, balls[1]], drive=drive, carrier=stiff), 0.0) == pytest.approx(0.2, rel=1e-3)
