"""Motions against independent integrators of the equations as written: heyoka's Taylor series and SciPy's Runge-Kutta methods.

The explicit integrator allows a state an error of 1e-12 (0.01 + |x|) a step, an angle one of 1e-12; fifty turns take some four
thousand steps. Errors, of the largest value of each state, add up to 5e-11; ten times as much is allowed. The implicit one at a
tolerance of 1e-7 has an error of 1.5e-7.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import sympy as sp
from tests.reference_integrators import needs_heyoka, runge_kutta_states, taylor_states

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.piecewise import Pieces, PiecewiseCubic
from wucht.system import TIME, System

x, v = sp.symbols("x v", real=True)


def two_rollers_on_an_anisotropic_carrier_under_gravity() -> Machine:
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


def difference(states: np.ndarray, witness: np.ndarray) -> float:
    """The largest one, of the largest value of each state."""
    return float((np.abs(states - witness) / np.abs(witness).max(axis=1, keepdims=True)).max())


@pytest.mark.slow
@needs_heyoka
@pytest.mark.parametrize(
    ("machine", "start", "until"),
    [
        (lambda: load_machine("drozdetskaya-2020/r1"), {"p1": 0.3, "p2": -0.5}, 4.2),
        (two_rollers_on_an_anisotropic_carrier_under_gravity, {"r1": 0.4, "r2": 2.5}, 3.2),
        (lambda: load_machine("drozdetskaya-2020/table-5.1"), {"psi": 0.0, "delta": 0.5}, 420.0),
        (lambda: load_machine("practice/screen"), {}, 6.0),
    ],
    ids=["R1", "rollers", "table 5.1", "screen"],
)
def test_fifty_turns(machine: Callable[[], Machine], start: dict[str, float], until: float) -> None:
    made = machine()
    time, initial = np.linspace(0, until, 1001), initial_state(made, start)
    witness = taylor_states(made.system, initial, made.values, time)
    rotor = made.system.state_names.index(made.rotor.coordinate.position.name)
    assert np.abs(witness[rotor]).max() > 50 * 2 * math.pi
    run = integrate(compile_system(made.system), initial, made.values, time)
    assert difference(run.states, witness) < 5e-10
    if until == 420.0:
        run = integrate(compile_system(made.system, 1e-7, engine="radau"), initial, made.values, time)
        assert difference(run.states, witness) < 1e-6


def test_fifty_turns_by_runge_kutta() -> None:
    """By coefficients that SciPy's authors have copied from the book for themselves, without heyoka."""
    machine = load_machine("drozdetskaya-2020/table-5.1")
    time, initial = np.linspace(0, 420.0, 101), initial_state(machine, {"psi": 0.0, "delta": 0.5})
    run = integrate(compile_system(machine.system), initial, machine.values, time)
    assert difference(run.states, runge_kutta_states(machine.system, initial, machine.values, time)) < 5e-10


@pytest.mark.slow
def test_a_chaotic_oscillator_with_stops() -> None:
    """Duffing-like between two stops, driven: the witness, which does not know them, errs by 1e-12 a step at each, and errors
    grow tenfold every few periods. The implicit integrator interpolates its places by cubics."""
    stops = Pieces("stops", (-1.0, 1.0), ((0, 400, 0, 0), (0, 0, 0, 0), (0, 400, 0, 0)))
    system = System((x, v), (v, -PiecewiseCubic(x, stops) - 0.1 * v + 5 * sp.cos(TIME)))
    time = np.linspace(0, 30, 301)
    witness = runge_kutta_states(system, [0.0, 0.0], [], time, max_step=0.02)
    assert np.abs(witness[0]).max() > 1.05
    for engine, tolerance, allowed in (("compiled", 1e-12, 2e-7), ("radau", 1e-8, 2e-5)):
        run = integrate(compile_system(system, tolerance, engine=engine), [0.0, 0.0], [], time)
        assert np.abs(run.states - witness).max() < allowed, engine


@pytest.mark.slow
def test_a_pendulum_that_sticks_to_its_rotor_is_stiff() -> None:
    """A damping of 1e5 N m s holds it within 1e-8 s. LSODA goes over to backward differences by itself; they differ by 6e-9."""
    machine = load_machine("drozdetskaya-2020/r1", {"p1.damping": "1e5 N m s"})
    time, initial = np.linspace(0, 1.0, 1001), initial_state(machine, {"p1": 0.3, "p2": -0.5})
    witness = runge_kutta_states(machine.system, initial, machine.values, time, "LSODA")
    run = integrate(compile_system(machine.system, 1e-8, engine="radau"), initial, machine.values, time)
    assert difference(run.states, witness) < 6e-8
    failed = integrate(compile_system(machine.system, 1e-8), initial, machine.values, time)
    assert failed.failure and "500000 steps were not enough" in failed.failure
    assert "The machine is stiff" in failed.failure and "engine = 'radau'" in failed.failure
