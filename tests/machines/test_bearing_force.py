"""The bearing force: with what the bodies push the carrier, against statics and the forced vibration in closed form."""

import math

import numpy as np
import pytest

from wucht.files.building import machine_from
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.studies.initial_state import initial_state


def outputs(machine, time):
    flow = compile_system(machine.system)
    run = integrate(flow, initial_state(machine, {}), machine.values, time)
    return flow.outputs(run.time, run.states, run.parameters)


def test_bodies_at_rest_push_with_their_weight():
    """A balanced rotor and a ball that hangs straight down, on a carrier in its static position."""
    machine = machine_from(
        {
            "carrier": {"mass": 3.0, "stiffness": 2e4, "damping": 40.0, "gravity": 9.81},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.05},
                {"kind": "pendulum", "name": "ball", "about": "drum", "mass": 0.5, "length": 0.1},
            ],
        }
    )
    hanging = initial_state(machine, {"ball": -math.pi / 2})
    flow = compile_system(machine.system)
    run = integrate(flow, hanging, machine.values, np.linspace(0, 1, 11))
    values = flow.outputs(run.time, run.states, run.parameters)
    assert values["bearing_force_x"] == pytest.approx(0, abs=1e-10)
    assert values["bearing_force_y"] == pytest.approx(-2.5 * 9.81, rel=1e-12)
    assert machine.system.output("bearing_force_y").long_name == "bearing force on the carrier in y"


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
