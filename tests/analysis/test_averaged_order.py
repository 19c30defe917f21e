"""The error of the averaged equations as epsilon -> 0, measured: O(epsilon) in the first order, O(epsilon^2) in the second.

Over times 1/epsilon, from a start with the fast part that belongs to the slow motion. epsilon is made smaller by ``weakened``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.averaged_equations import averaged_equations_of, states_with_fast_parts
from wucht.dynamics.scenarios.order_of_error import scale_epsilon
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Evaluator

PHASES = {"p1": -0.5, "p2": 0.7}
PENDULUM = {"kind": "pendulum", "about": "drum", "inertia": 1.69e-3, "damping": 0.169}
SHAKY: dict[str, Any] = {  # the directions differ, gravity acts, the pendulums are not alike
    "carrier": {"stiffness": [1e5, 2.3e5], "damping": [200.0, 320.0], "gravity": 4.0},
    "bodies": [
        {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 9.75e-4},
        PENDULUM | {"name": "p1", "mass": 0.125, "length": 0.104},
        PENDULUM | {"name": "p2", "mass": 0.1, "length": 0.1},
    ],
    "drive": {"on": "drum", "kind": "linear", "slope": 2e-3, "no_load_speed": 80.0},
}


def machine(name: str) -> Machine:
    if name == "isotropic":  # Table 5.1 with dampers that are reciprocal
        return load_machine("drozdetskaya-2020/table-5.1", {}).with_values(
            {"u": 1.5, "lambda": 0.8, "beta_r": 2 * 0.01 * 1.3 / (0.01 * 0.75)}
        )
    sense = -1 if name == "shaky, clockwise" else 1
    return machine_from(SHAKY | {"drive": SHAKY["drive"] | {"no_load_speed": sense * 80.0}})


def largest_error(given: Machine, kappa: float, start: Mapping[str, float], until: float, inertia: bool, order: int) -> float:
    """Of the rotor's speed, over a time until/kappa."""
    small = scale_epsilon(given, kappa)
    averaged_equations = averaged_equations_of(small, inertia, order)
    state = np.array([start[name] for name in averaged_equations.system.state_names if name in start])
    if inertia:  # on the slow manifold: the slips that the damped equations give
        damped = averaged_equations_of(small, False, order)
        speeds = [o for o in damped.system.outputs if o.name.startswith("speed[")]
        at = np.array([[start[name]] for name in damped.system.state_names])
        seen = Evaluator.of(damped.system, [o.expression for o in speeds], [o.name for o in speeds])
        slips = seen(np.zeros(1), at, damped.values())
        names = [n.rpartition(".") for n in averaged_equations.system.state_names]
        state = np.array([slips[f"speed[{b}]"][0] if what == "speed" else start[f"{b}.phase"] for b, _, what in names])
    time = np.linspace(0.0, until / kappa, 301)
    run = integrate(compile_system(averaged_equations.system, 1e-14), state, averaged_equations.values(), time)
    rebuilt = states_with_fast_parts(averaged_equations, time, run.states, run.quadratures["rotor_angle"])
    full = replace(small.system, quadratures=(), outputs=())
    true = integrate(compile_system(full, 1e-14), rebuilt[:, 0], full.values(small.values), time)
    row = small.state_names.index(small.rotor.coordinate.velocity.name)
    return float(np.abs(true.states[row] - rebuilt[row]).max())


@pytest.mark.slow
@pytest.mark.parametrize("inertia", [True, False], ids=["with inertia", "without"])
@pytest.mark.parametrize(
    ("name", "order"),
    [
        ("isotropic", 1),
        ("shaky", 1),
        ("isotropic", 2),
        ("shaky, clockwise", 2),
    ],
)
def test_order_of_the_error(name: str, order: int, inertia: bool) -> None:
    given = machine(name)
    speed, until = (0.4, 60.0) if name == "isotropic" else (60.0, 0.3)
    start = {f"{b}.phase": a for b, a in PHASES.items()} | {f"{given.rotor.name}.speed": speed}
    errors = [largest_error(given, k, start, until, inertia, order) for k in (0.25, 0.125)]
    # At these epsilons the next term of the expansion is below a tenth.
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_the_fluctuation_that_gravity_causes_brakes_in_the_second_order() -> None:
    """J psi'' + k psi' = Re[W exp(i theta)] with W = U g, k the slope of the drive: in the mean it loses k |psi'|^2/2 = V w."""
    j, k, u, g, w = 0.02, 0.3, 0.004, 9.81, 40.0
    rotor = {"kind": "rotor", "name": "drum", "mass": 2.0, "unbalance": u, "inertia": j}
    drive = {"on": "drum", "kind": "linear", "slope": k, "no_load_speed": w}
    braked = []
    for gravity in (g, 0.0):
        stiff = {"stiffness": 1e12, "damping": 1.0, "gravity": gravity}
        averaged_equations = averaged_equations_of(machine_from({"carrier": stiff, "bodies": [rotor], "drive": drive}), True, 2)
        rate = Evaluator.of_rates(averaged_equations.system).array(np.zeros(1), np.array([[w]]), averaged_equations.values())[
            0, 0
        ]
        braked.append(j * rate)
    amplitude = u * g / abs(complex(-j * w**2, k * w))
    assert braked[0] - braked[1] == pytest.approx(-k * w * amplitude**2 / 2, rel=1e-5)
