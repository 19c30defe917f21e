"""Dry friction on a rotor that swings to and fro, against LSODA with short steps on equations written out by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

INERTIA, WEIGHT = 0.05, 2 * 9.81 * 0.1
DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.1, "inertia": INERTIA}
CARRIER = {"directions": "fixed", "gravity": 9.81}
IDLE = {"kind": "constant-torque", "torque": 0.0}
FRICTION, MOTOR, RATIO, EFFICIENCY, GEAR = 0.3, 0.04, 3.0, 0.7, 0.002
CURVE = PchipInterpolator([-10, -5, 0, 5, 10], [-0.5, -0.05, 0, 0.05, 0.5])


def coulomb(width):
    load = {"kind": "coulomb", "torque": FRICTION, "transition_speed": width}
    return {"drive": IDLE, "load": load}, INERTIA, lambda w: -FRICTION * np.tanh(w / width)


def table(width):
    load = {"kind": "table", "points": [[0, 0.3], [5, 0.35], [10, 0.8]], "transition_speed": width}
    return {"drive": IDLE, "load": load}, INERTIA, lambda w: -CURVE(np.clip(w, -10, 10)) - FRICTION * np.tanh(w / width)


def geared(width):
    """What drives arrives with eta, what is driven is taken with 1/eta: the law with sign(w), and tanh for the sign."""
    gear = {"ratio": RATIO, "inertia": GEAR, "efficiency": EFFICIENCY, "transition_speed": width}
    drive = {"kind": "constant-torque", "torque": MOTOR, "transmission": gear}
    torque, b, c = RATIO * MOTOR, (1 / EFFICIENCY - EFFICIENCY) / 2, 1 - (1 / EFFICIENCY + EFFICIENCY) / 2

    def law(w):
        sign = np.tanh(w / width)
        return torque - (b * torque + c * torque * sign) * sign

    return {"drive": drive}, INERTIA + GEAR * RATIO**2, law


def witness(inertia, law, start, end):
    def rates(_, state):
        return [state[1], (law(state[1]) - WEIGHT * np.cos(state[0])) / inertia]

    solution = solve_ivp(rates, (0, end), start, method="LSODA", rtol=1e-12, atol=1e-13, max_step=5e-3)
    return solution.y[:, -1]


def swung(parts, angle, end, tolerance=1e-12):
    machine = machine_from({"carrier": CARRIER, "bodies": [DRUM], **parts})
    start = initial_state(machine, {"drum": {"angle": angle}})
    ran = integrate(compile_system(machine.system, tolerance), start, machine.values, np.linspace(0, end, 31))
    assert ran.failure is None
    return ran


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.6, np.pi - 0.6])  # it falls over the one side, and over the other
@pytest.mark.parametrize("width", [1e-5, 1e-2, 10.0])  # rad/s; it swings with up to 12 rad/s
@pytest.mark.parametrize("kind", [coulomb, table, geared])
def test_it_swings_as_an_independent_integration_says(kind, width, angle):
    parts, inertia, law = kind(width)
    ran = swung(parts, angle, 1.8)
    assert (np.diff(np.sign(ran.states[1])[1:]) != 0).sum() >= 2
    assert ran.states[:, -1] == pytest.approx(witness(inertia, law, [angle, 0.0], 1.8), abs=2e-8)
    stored = inertia * ran.states[1] ** 2 / 2 + WEIGHT * np.sin(ran.states[0])
    gap = ran.quadratures["supplied_work"] - ran.quadratures["dissipated_work"] - (stored - stored[0])
    assert np.abs(gap).max() < 1e-10
    assert ran.quadratures["dissipated_work"][-1] > 0.1
