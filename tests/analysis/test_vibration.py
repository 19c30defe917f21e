"""The vibration torque against the closed forms of 002, its last maximum against SciPy, and free speeds."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from wucht.analysis.vibration import Vibration, unbalances
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


def test_the_same_in_si_units():
    """With k^2 = c/M*, sigma = b/(2 M* k) and the unbalance U the torque has the unit U^2 k^2/M*."""
    total, u = 3.0 + 2.0, 0.02
    k = math.sqrt(2e4 / total)
    sigma = 40.0 / (2 * total * k)
    for directions, factor in (("xy", 2), ("x", 1), ("y", 1)):
        torque = Vibration.of(si_machine(directions)).torque(k * SPEEDS, np.zeros(1))[0]
        assert torque == pytest.approx(factor * u**2 * k**2 / total * one_direction(SPEEDS, sigma), rel=1e-12)


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


def test_of_a_rotor_that_turns_clockwise_the_same():
    """What its drive reaches is a negative speed: a resonance lies below it all the same."""
    vibration = Vibration.of(si_machine())
    below = vibration.last_maximum(300.0, np.zeros(1))
    assert below == pytest.approx(math.sqrt(2e4 / 5), rel=0.01)
    assert vibration.last_maximum(-300.0, np.zeros(1)) == below


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


def test_a_group_is_a_rotor_with_all_that_turns_about_it():
    ball = {"kind": "pendulum", "mass": 0.1, "length": 0.1}
    chain = [ball | {"name": "outer", "about": "inner"}, ball | {"name": "inner", "about": "drum"}]
    other = {**ROTOR, "name": "second"}
    machine = si_machine(bodies=[*chain, other, ball | {"name": "third", "about": "second"}])
    assert [b.name for b in machine.group(machine.rotor)] == ["drum", "inner", "outer"]
    assert [b.name for b in machine.group(machine.bodies[3])] == ["second", "third"]
