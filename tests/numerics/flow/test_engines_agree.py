"""heyoka (Taylor), the compiled stepper and SciPy (Dormand-Prince) share no line below the Program: 50 turns agree."""

import math

import numpy as np
import pytest

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

pytest.importorskip("heyoka")


def two_rollers_on_an_anisotropic_carrier_under_gravity():
    roller = {"kind": "roller", "about": "drum", "mass": 0.2, "track_radius": 0.12, "radius": 0.02, "damping": 0.02}
    return machine_from(
        {
            "carrier": {"mass": 5.0, "stiffness": [8e4, 1.6e5], "damping": [150.0, 250.0], "gravity": 9.81},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 4.0, "eccentricity": 2e-3, "inertia": 0.02, "bearing_damping": 1e-3},
                {**roller, "name": "r1"},
                {**roller, "name": "r2", "mass": 0.15, "radius": 0.015, "shape_factor": 0.5},
            ],
            "drive": {"kind": "linear", "slope": 0.05, "no_load_speed": 250.0},
        }
    )


@pytest.mark.parametrize("engine", ["compiled", pytest.param("scipy", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("machine", "start", "until"),
    [
        (lambda: load_machine("drozdetskaya-2020/r1"), {"p1": 0.3, "p2": -0.5}, 4.2),
        pytest.param(two_rollers_on_an_anisotropic_carrier_under_gravity, {"r1": 0.4, "r2": 2.5}, 3.2, marks=pytest.mark.slow),
        (lambda: load_machine("drozdetskaya-2020/table-5.1"), {"psi": 0.0, "delta": 0.5}, 420.0),
    ],
    ids=["R1", "rollers", "table 5.1"],
)
def test_fifty_turns(machine, start, until, engine):
    if engine == "compiled":
        pytest.importorskip("llvmlite")
    made = machine()
    time, initial = np.linspace(0, until, 1001), initial_state(made, start)
    runs = [integrate(compile_system(made.system, engine=e), initial, made.values, time) for e in ("heyoka", engine)]
    states = [np.vstack([r.states, *r.quadratures.values()]) for r in runs]
    rotor = made.system.state_names.index(made.rotor.coordinate.position.name)
    assert np.abs(states[0][rotor]).max() > 50 * 2 * math.pi
    scale = np.abs(states[0]).max(axis=1, keepdims=True)
    assert (np.abs(states[0] - states[1]) / scale).max() < 1e-8
