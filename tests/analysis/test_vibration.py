"""The vibration torque against the closed forms of 002, its last maximum against SciPy, and free speeds."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from wucht.analysis.time_constants import run_up_time, runaway_limit, slowest_decay, vibration_decay
from wucht.analysis.vibration import Vibration, unbalances
from wucht.analysis.working_points import swing_frequency
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.operation import free_speed
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

SPEEDS = np.array([0.05, 0.5, 0.95, 1.0, 1.05, 1.5, 2.0, 10.0])
ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.05}


def one_direction(w, sigma):
    """002 (3.50), second term."""
    return sigma * w**5 / ((1 - w**2) ** 2 + 4 * sigma**2 * w**2)


def si_machine(directions="xy", drive=None, bodies=(), **carrier):
    carrier = {"mass": 3.0, "stiffness": 2e4, "damping": 40.0, "directions": directions} | carrier
    described = {"carrier": carrier, "bodies": [ROTOR, *bodies]}
    return machine_from(described | ({"drive": drive} if drive else {}))


def test_rotor_on_an_isotropic_carrier():
    """002 (3.67): 2 sigma w^5/((1 - w^2)^2 + 4 sigma^2 w^2)."""
    machine = load_machine("drozdetskaya-2020/table-3.1-laval")
    torque = Vibration.of(machine).torque(SPEEDS, np.zeros(1))[0]
    assert torque == pytest.approx(2 * one_direction(SPEEDS, machine.values["sigma"]), rel=1e-12)


def test_rotor_on_a_carrier_that_moves_in_one_direction():
    """002 (3.50)."""
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier")
    torque = Vibration.of(machine).torque(SPEEDS, np.zeros(1))[0]
    assert torque == pytest.approx(one_direction(SPEEDS, machine.values["sigma"]), rel=1e-12)


def test_bodies_act_with_the_sum_of_their_unbalances():
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.1, "length": 0.1}  # U = 0.01, half of the rotor's
    machine = si_machine(bodies=[ball | {"name": "a"}, ball | {"name": "b"}])
    vibration = Vibration.of(machine)
    alone = vibration.torque(SPEEDS * 50, np.array([0.0, 0.0, math.pi]))[0]
    assert unbalances(machine) == pytest.approx([0.02, 0.01, 0.01])
    assert vibration.torque(SPEEDS * 50, np.zeros(3))[0] == pytest.approx(4 * alone, rel=1e-12)
    assert vibration.torque(SPEEDS * 50, np.array([0, math.pi, math.pi]))[0] == pytest.approx(0, abs=1e-12)
    # Turned together nothing changes.
    assert vibration.torque(SPEEDS * 50, np.array([1.0, 1.0, 1.0 + math.pi]))[0] == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize("directions", ["x", "xy"])
def test_a_rotor_of_constant_speed_needs_this_torque_on_average(directions):
    """Against the full equations: the mean motor torque over ten turns, once the start has died away."""
    speed = 66.0
    machine = si_machine(directions, {"kind": "constant-speed", "speed": speed})
    settled, window = 1000, 1001
    time = np.concatenate([[0.0], (settled + np.linspace(0, 10, window)) * 2 * math.pi / speed])
    flow = compile_system(machine.system)
    run = integrate(flow, initial_state(machine, {}), machine.values, time)
    torque = flow.outputs(run.time, run.states, run.final_parameter_values)["motor_torque"][1:]
    expected = float(Vibration.of(machine).torque(np.array([speed]), np.zeros(1))[0][0])
    assert np.trapezoid(torque) / (window - 1) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("sigma", [1e-4, 0.2])
@pytest.mark.parametrize("name", ["laval", "carrier"])
def test_the_last_maximum(name, sigma):
    machine = load_machine(f"drozdetskaya-2020/table-3.1-{name}", {"sigma": sigma})
    exact = minimize_scalar(lambda w: -one_direction(w, sigma), bounds=(0.9, 1.2), method="bounded", options={"xatol": 1e-12})
    assert Vibration.of(machine).last_maximum(2.0, np.zeros(1)) == pytest.approx(exact.x, rel=1e-7)


def test_no_maximum_with_strong_damping():
    """Then the torque rises all the way."""
    machine = load_machine("drozdetskaya-2020/table-3.1-laval", {"sigma": 0.7})
    assert Vibration.of(machine).last_maximum(2.0, np.zeros(1)) is None


def test_of_two_maxima_the_upper_one():
    vibration = Vibration.of(si_machine(stiffness=[2e4, 8e4], damping=[20.0, 20.0]))
    upper = math.sqrt(8e4 / 5)
    exact = minimize_scalar(
        lambda w: -vibration.torque(np.array([w]), np.zeros(1))[0][0], bounds=(0.9 * upper, 1.2 * upper), method="bounded",
        options={"xatol": 1e-9},
    )  # fmt: skip
    assert vibration.last_maximum(300.0, np.zeros(1)) == pytest.approx(exact.x, rel=1e-7)
    assert vibration.last_maximum(100.0, np.zeros(1)) == pytest.approx(math.sqrt(2e4 / 5), rel=0.01)


# --- the speed reached without vibration ---

LINEAR = {"kind": "linear", "slope": 0.05, "no_load_speed": 250.0}


@pytest.mark.parametrize("bearing", [0.01, 5.0])
def test_bearing_damping_costs_speed(bearing):
    """slope (no_load - w) = b w."""
    machine = machine_from({"carrier": {"stiffness": 2e4}, "bodies": [ROTOR | {"bearing_damping": bearing}], "drive": LINEAR})
    assert free_speed(machine, machine.rotor) == pytest.approx(0.05 * 250 / (0.05 + bearing), rel=1e-14)


def test_without_a_drive():
    coasting = si_machine()
    assert free_speed(coasting, coasting.rotor) is None
    braked = machine_from({"carrier": {"stiffness": 2e4}, "bodies": [ROTOR | {"bearing_damping": 0.1}]})
    assert free_speed(braked, braked.rotor) == 0.0


MASS, DAMPED, INERTIA, SLOPE, FREE = 10.0, 40.0, 0.02, 1e-3, 200.0
LIGHT = {"kind": "rotor", "name": "d", "mass": 4.0, "unbalance": 1e-9, "inertia": INERTIA}
SLOPING = {"kind": "linear", "slope": SLOPE, "no_load_speed": FREE}
ALONG_X = {"directions": "x", "mass": MASS - 4.0, "stiffness": 1e5, "damping": DAMPED}


def sloping(**changes):
    return machine_from({"carrier": ALONG_X, "bodies": [LIGHT], "drive": SLOPING} | changes)


def test_a_free_vibration_falls_with_half_the_damping_over_the_mass():
    assert vibration_decay(sloping()) == pytest.approx(2 * MASS / DAMPED, rel=1e-6)
    assert vibration_decay(sloping(carrier=ALONG_X | {"damping": 0.0})) == 0.0
    assert vibration_decay(sloping(carrier={"directions": "fixed"})) == 0.0


def test_the_slowest_is_the_drive_the_carrier_or_a_slipping_body():
    assert slowest_decay(sloping(), FREE) == pytest.approx(INERTIA / SLOPE, rel=1e-4)
    assert slowest_decay(sloping(drive=SLOPING | {"slope": 1.0}), FREE) == pytest.approx(2 * MASS / DAMPED, rel=1e-4)
    pendulum = {"kind": "pendulum", "name": "p", "about": "d", "mass": 1e-3, "length": 0.1, "damping": 1e-8}
    slipping = sloping(bodies=[LIGHT, pendulum], drive={"kind": "constant-speed", "speed": FREE})
    assert slowest_decay(slipping, FREE) == pytest.approx(1e-3 * 0.1**2 / 1e-8, rel=1e-3)


def test_a_rotor_in_gravity_swings_as_a_pendulum():
    heavy = sloping(bodies=[LIGHT | {"unbalance": 0.05}], carrier={"directions": "fixed", "gravity": 9.81})
    assert swing_frequency(heavy) == pytest.approx(np.sqrt(9.81 * 0.05 / INERTIA), rel=1e-9)
    assert swing_frequency(sloping()) == 0.0


SENSES = pytest.mark.parametrize("sense", [1.0, -1.0])


@SENSES
def test_a_run_up_takes_as_long_in_either_sense_from_a_speed_in_either_sense(sense):
    """The speed from which it begins counts by its magnitude."""
    driven = sloping(drive=SLOPING | {"no_load_speed": sense * FREE})
    expected = INERTIA / SLOPE * math.log((FREE - 100) / (0.005 * FREE))
    for begin in (100.0, -100.0):
        assert run_up_time(driven, begin) == pytest.approx(expected, rel=2e-2)
    for beyond in (199.5, -199.5, 250.0, -250.0):
        assert run_up_time(driven, beyond) == 0.0


@SENSES
def test_a_runaway_takes_as_long_in_either_sense(sense):
    free = sloping(drive={"kind": "constant-torque", "torque": sense * 0.5})
    assert runaway_limit(free) == pytest.approx(3000.0)
    assert run_up_time(free, 0.0) == pytest.approx(INERTIA * 3000 / 0.5, rel=1e-6)
    assert run_up_time(free, -sense * 1000.0) == pytest.approx(INERTIA * 2000 / 0.5, rel=1e-6)
    assert run_up_time(free, 3000.0) == 0.0


def test_a_machine_that_nothing_drives_neither_runs_up_nor_away():
    coasting = machine_from({"carrier": ALONG_X, "bodies": [LIGHT]})
    assert (runaway_limit(coasting), run_up_time(coasting, 0.0)) == (None, 0.0)
    prescribed = sloping(drive={"kind": "constant-speed", "speed": FREE})
    assert (runaway_limit(prescribed), run_up_time(prescribed, 0.0)) == (None, 0.0)
