"""The bearing force: with what the bodies push the carrier, against statics and the forced vibration in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate


def outputs(machine, time):
    flow = compile_system(machine.system)
    run = integrate(flow, initial_state(machine, {}), machine.values, time)
    return flow.outputs(run.time, run.states, run.final_parameter_values)


@pytest.mark.parametrize("speed", [30.0, 62.0, 200.0])
def test_a_rotor_of_constant_speed(speed):
    """z = U w^2 exp(i w t)/(c - M* w^2 + i w b), and the carrier of mass m takes (c - m w^2 + i w b) z."""
    stiffness, damping, mass, own = 2e4, 40.0, 2.0, 3.0
    machine = machine_from(
        {
            "carrier": {"mass": own, "stiffness": stiffness, "damping": damping},
            "bodies": [{"kind": "rotor", "name": "drum", "mass": mass, "eccentricity": 0.01, "inertia": 0.05}],
            "drive": {"kind": "constant-speed", "speed": speed},
        }
    )
    time = np.concatenate([[0.0], 12 + np.linspace(0, 1, 50)])  # the start dies away as exp(-4 t)
    values = outputs(machine, time)
    spring = stiffness + 1j * speed * damping
    force = (spring - own * speed**2) * 0.02 * speed**2 / (spring - (own + mass) * speed**2) * np.exp(1j * speed * time[1:])
    for name, expected in (("bearing_force_x", force.real), ("bearing_force_y", force.imag)):
        assert np.abs(values[name][1:] - expected).max() < 1e-8 * np.abs(force).max()


TWO = {
    "carrier": {
        "mass": 40.0, "inertia": 3.0, "directions": "xyr", "gravity": 9.81, "stiffness": (4e4, 6e4), "damping": (90.0, 120.0),
        "rotation_stiffness": 9e3, "rotation_damping": 20.0,
    },
    "bodies": [
        {"kind": "rotor", "name": "e1", "mass": 4.0, "unbalance": 0.06, "inertia": 0.01, "position": (0.3, 0.1)},
        {"kind": "rotor", "name": "e2", "mass": 5.0, "unbalance": 0.05, "inertia": 0.02, "position": (-0.2, 0.25)},
        {"kind": "pendulum", "name": "p", "about": "e2", "mass": 0.5, "length": 0.08, "inertia": 0.004, "damping": 0.03},
    ],
    "drives": [
        {"kind": "linear", "on": "e1", "slope": 0.05, "no_load_speed": 150.0},
        {"kind": "linear", "on": "e2", "slope": 0.04, "no_load_speed": -120.0},
    ],
}  # fmt: skip


def accelerations(velocity, step):
    """By differences of fourth order, without the two samples at either end."""
    return (velocity[:-4] - 8 * velocity[1:-3] + 8 * velocity[3:-1] - velocity[4:]) / (12 * step)


@pytest.mark.parametrize("bodies", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_the_bearing_force_of_each_rotor_is_newtons_law(bodies):
    """Of the centre of mass of each body, from positions and velocities alone: the bearing gives what its weight does not."""
    machine, step = machine_from(TWO | {"bodies": TWO["bodies"][:bodies]}), 1e-4
    flow = compile_system(machine.system)
    speeds = {"e1": {"speed": 60.0}, "e2": {"angle": 1.0, "speed": -40.0}, "p": {"angle": 0.7, "speed": -10.0}}
    names = [b.name for b in machine.bodies]
    start = initial_state(machine, {name: speeds[name] for name in names})
    run = integrate(flow, start, machine.values, step * np.arange(3000))
    at, shown = (
        dict(zip(machine.state_names, run.states, strict=True)),
        flow.outputs(run.time, run.states, run.final_parameter_values),
    )

    def push(mass, arm, place, body):
        """With what a body pushes what bears it: against its acceleration, and along its weight."""
        (a, b), angle, turning = place, at[f"{body}.angle"], arm * at[f"{body}.speed"]
        vx = at["carrier.vx"] - b * at["carrier.vr"] - turning * np.sin(angle)
        vy = at["carrier.vy"] + a * at["carrier.vr"] + turning * np.cos(angle)
        return np.array([-mass * accelerations(vx, step), -mass * (accelerations(vy, step) + 9.81)])

    first = push(4.0, 0.06 / 4.0, (0.3, 0.1), "e1")
    second = push(5.0, 0.05 / 5.0, (-0.2, 0.25), "e2")
    if "p" in names:
        second += push(0.5, 0.08, (-0.2, 0.25), "p")
    whole = np.array([shown[f"bearing_force_{d}"][2:-2] for d in "xy"])
    for name, expected in (("e1", first), ("e2", second)):
        found = np.array([shown[f"bearing_force[{name}]_{d}"][2:-2] for d in "xy"])
        assert np.abs(found).max() > 100
        assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()
    np.testing.assert_allclose(first + second, whole, atol=1e-6 * np.abs(whole).max())


RATED_ROTOR: dict[str, Any] = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 2e-2, "inertia": 1.5e-2}
ROCKING = {"directions": "r", "inertia": 1.0, "rotation_stiffness": 900.0}


def document(bearing: Any, **more: Any) -> dict[str, Any]:
    carrier, rotor = {"mass": 2.0, "stiffness": 1e4, "damping": 30.0}, RATED_ROTOR | {"bearing": bearing}
    drive = {"kind": "linear", "slope": 0.1, "no_load_speed": 50.0}
    return {"carrier": carrier, "bodies": [rotor], "drive": drive, **more}


def test_where_no_bearing_can_be() -> None:
    couple = {"kind": "rotor", "name": "drum", "mass": 3.0, "couple_unbalance": 1e-3, "inertia": 1.5e-2, "bearing": {"C": 1e3}}
    with refused("machine.bodies[0] (drum).bearing", "a couple unbalance has no force in the plane"):
        machine_from({"carrier": ROCKING, "bodies": [couple]})
    points = [["0 s", "1 kN"], ["1 s", "2 kN"]]
    with refused("machine.schedules[0].parameter", "does not change over time", given="drum.bearing.C", code="rating"):
        machine_from(document({"C": 1e3}, schedules=[{"parameter": "drum.bearing.C", "points": points}]))


def test_the_limits_are_allowed() -> None:
    for table in ({"C": 1e-3, "p": 1, "share": 1}, {"C": "45 kN", "p": 10}, {"C": "45 kN", "p": "10/3", "share": 1e-3}):
        machine = machine_from(document(table))
    assert machine.values["drum.bearing.p"] == 10 / 3
    assert machine.parameters["drum.bearing.C"].unit == "N"


def test_a_rating_moves_nothing() -> None:
    motions = []
    for table in (None, {"C": 1e3}):
        machine = machine_from(document(table))
        motions.append(run_to_end(machine, {}, RunSettings(until=2.0)).machine_motion)
    assert np.array_equal(motions[0].states, motions[1].states)
