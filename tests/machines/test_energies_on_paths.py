"""A pendulum on a pivot off the axis and a mass in a guide: their energies from the paths of their masses.

The energy balance is no witness for a wrong kinetic energy: any Lagrangian conserves its own.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.files.building import machine_from
from wucht.machines.machine import Machine

MASS, LENGTH, A, B = 0.3, 0.12, 0.05, -0.03
INERTIA = 0.006  # more than m l^2 = 0.00432


def machine(**pendulum: object) -> Machine:
    return machine_from({
        "carrier": {"directions": "xy", "mass": 2.0, "stiffness": 30.0, "gravity": 9.81},
        "bodies": [
            {"kind": "rotor", "name": "r", "mass": 1.5, "eccentricity": 0.004, "inertia": 0.01},
            {"kind": "pendulum", "name": "p", "about": "r", "mass": MASS, "length": LENGTH, "suspension": [A, B]} | pendulum,
        ],
        "drive": {"kind": "constant-torque", "torque": 0.0},
    })  # fmt: skip


def stored_energy(described: Machine, state: dict[str, float]) -> float:
    system = described.system
    values = dict(zip(system.parameters, system.values(described.values), strict=True))
    named = {s: state[s.name] for s in system.states}
    return float(sp.sympify(system.output("stored_energy").expression).subs(values | named))


def energy_of_points(state: dict[str, float], inertia: float) -> float:
    """Of all masses, each at its place, with velocities by differences of the places."""
    h = 1e-6

    def at(t: float) -> dict[str, np.ndarray]:
        x, y = (state[f"carrier.{d}"] + t * state[f"carrier.v{d}"] for d in "xy")
        phi, theta = (state[f"{n}.angle"] + t * state[f"{n}.speed"] for n in ("r", "p"))
        axis, turned = np.array([x, y]), np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
        pivot = axis + turned @ [A, B]
        return {
            "axis": axis, "centre": axis + 0.004 * turned[:, 0], "pivot": pivot,
            "mass": pivot + LENGTH * np.array([np.cos(theta), np.sin(theta)]),
        }  # fmt: skip

    now, speed = at(0.0), {k: (at(h)[k] - at(-h)[k]) / (2 * h) for k in at(0.0)}
    of = {"axis": 2.0, "centre": 1.5, "mass": MASS}
    kinetic = sum(m * speed[k] @ speed[k] / 2 for k, m in of.items())
    kinetic += (0.01 - 1.5 * 0.004**2) * state["r.speed"] ** 2 / 2 + (inertia - MASS * LENGTH**2) * state["p.speed"] ** 2 / 2
    potential = 30.0 * now["axis"] @ now["axis"] / 2 + 9.81 * sum(m * now[k][1] for k, m in of.items())
    return float(kinetic + potential)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("inertia", [None, INERTIA])
def test_the_energy_is_that_of_its_mass_on_its_path(seed: int, inertia: float | None) -> None:
    described = machine() if inertia is None else machine(inertia=inertia)
    rng = np.random.default_rng(seed)
    names = [s.name for s in described.system.states]
    state = dict(zip(names, rng.uniform(-2, 2, len(names)), strict=True))
    whole = MASS * LENGTH**2 if inertia is None else inertia
    rest = dict.fromkeys(names, 0.0)
    change = stored_energy(described, state) - stored_energy(described, rest)
    expected = energy_of_points(state, whole) - energy_of_points(rest, whole)
    assert change == pytest.approx(expected, rel=1e-7)
