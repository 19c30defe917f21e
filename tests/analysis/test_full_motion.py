"""From slow states back to the full motion: it must solve the full equations where the slow motion stands still."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of, states_with_fast_parts
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

PENDULUM = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "inertia": 1.69e-3, "damping": 0.169}


def drum(sense: int = 1, **changes: Any) -> Machine:
    """R2 with a drive in either sense."""
    rotor = {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.0338}
    return machine_from(
        {
            "carrier": {"directions": "xy", "stiffness": 1e5, "damping": 200.0} | changes.pop("carrier", {}),
            "bodies": [rotor, PENDULUM | {"name": "p1"}, PENDULUM | {"name": "p2"}],
            "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": sense * 200.0},
        }
        | changes
    )


def rebuilt(
    averaged_equations: AveragedEquations, time: np.ndarray, states: np.ndarray, angle: np.ndarray
) -> dict[str, np.ndarray]:
    return dict(
        zip(
            averaged_equations.machine.state_names, states_with_fast_parts(averaged_equations, time, states, angle), strict=True
        )
    )


def steady(machine: Machine, speed: float, phases: dict[str, float]) -> tuple[AveragedEquations, np.ndarray]:
    """The slow machine, and its state (n,) at a speed in the bodies' own sense."""
    averaged_equations = averaged_equations_of(machine, True)
    angles = {b.name: averaged_equations.senses[b.name] * phases.get(b.name, 0.0) for b in machine.bodies}
    return averaged_equations, averaged_equations.state(
        angles, {name: s * speed for name, s in averaged_equations.senses.items()}
    )


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("speed", [99.0, 180.0])
def test_the_carrier_of_a_steady_rotation_follows_its_own_equation(speed: float, sense: int) -> None:
    """Bodies with a huge inertia turn steadily: then the carrier's equation (4.1)-(4.2) holds in numbers, q'' = -w^2 q."""
    machine = drum(sense, carrier={"stiffness": [1e5, 1.7e5], "damping": [200.0, 90.0]})
    machine = machine.with_values({"drum.inertia": 1e7, "p1.inertia": 1e7, "p2.inertia": 1e7})
    slow, state = steady(machine, speed, {"p1": 0.7, "p2": -2.0})
    time = np.linspace(0.0, 0.2, 40)
    full = rebuilt(slow, time, np.repeat(state[:, None], 40, axis=1), speed * time)
    q = np.array([full["carrier.x"], full["carrier.y"]])
    v = np.array([full["carrier.vx"], full["carrier.vy"]])
    unbalances, alpha = np.array([9.75e-3, 0.013, 0.013]), np.array([0.0, 0.7, -2.0])
    turned = sense * (speed * time + alpha[:, None])
    force = speed**2 * np.array([unbalances @ np.cos(turned), unbalances @ np.sin(turned)])
    stiffness, damping, mass = np.array([[1e5], [1.7e5]]), np.array([[200.0], [90.0]]), 10.0
    residual = -(speed**2) * mass * q + damping * v + stiffness * q - force
    assert np.abs(force).max() > 10
    # The bodies still change their speed by 1e-8 of itself; z' comes by differences with a relative error of 1e-8.
    assert np.abs(residual).max() < 1e-6 * np.abs(force).max()
    for b in machine.bodies:
        assert full[b.coordinate.velocity.name] == pytest.approx(slow.senses[b.name] * speed, rel=1e-6)


MOTIONS = {
    "second order": ("drozdetskaya-2020/r2", {}, 2),
    "unequal directions": ("sperling-rollers/table-1", {}, 1),
    "shaken": ("sperling-vibration/figure-2a", {}, 1),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", MOTIONS)
def test_velocities_are_the_rates_of_positions_while_the_slow_motion_goes_on(case: str) -> None:
    """Central differences along the slow motion itself: amplitudes and phases change while the rotor turns."""
    name, values, order = MOTIONS[case]
    machine = load_machine(name).with_values(values)
    averaged_equations = averaged_equations_of(machine, True, order)
    speeds = {b.name: averaged_equations.senses[b.name] * 0.45 * 200.0 for b in machine.bodies}
    if machine.shaken_coordinate is not None:
        speeds = {b.name: 6.0 for b in machine.bodies}
    w = max(map(abs, speeds.values()))
    start = averaged_equations.state({b.name: 0.3 * k for k, b in enumerate(machine.bodies)}, speeds)
    step = 2e-3 / w
    time = step * np.arange(9)
    flow = compile_system(averaged_equations.system, 1e-13)
    run = integrate(flow, start, averaged_equations.values(), time)
    full = rebuilt(averaged_equations, time, run.states, run.quadratures["rotor_angle"])
    for c in machine.carrier:
        if c.prescribed_velocity is not None:
            continue
        q, v = full[c.position.name], full[c.velocity.name]
        fourth = (q[:-4] - 8 * q[1:-3] + 8 * q[3:-1] - q[4:]) / (12 * step)
        # The slow rates hold to first order in the ripple; what is left is that of z' by differences, and round-off.
        assert fourth == pytest.approx(v[2:-2], rel=1e-6, abs=1e-6 * w * np.abs(q - q.mean()).max() + 1e-9 * np.abs(v).max())
    assert set(full) == set(machine.state_names)


@pytest.mark.parametrize("sense", [1, -1])
def test_the_search_of_a_periodic_motion_starts_with_the_vibration_that_belongs_to_it(sense: int) -> None:
    """Newton's method would mend a wrong start, at the cost of steps and sometimes of another motion.

    The carrier's springs and dampers differ in x and y, and bodies with a huge inertia turn steadily.
    """
    machine = drum(sense, carrier={"stiffness": [1e5, 1.7e5], "damping": [200.0, 90.0], "gravity": 9.81})
    machine = machine.with_values({"drum.inertia": 1e7, "p1.inertia": 1e7, "p2.inertia": 1e7})
    phases = {"p1": 0.7, "p2": -2.0}
    slow, state = steady(machine, 120.0, phases)
    torques = SteadyTorques.from_averaged_equations(slow)
    at = State(120.0, np.array([phases.get(name, 0.0) for name in torques.names]))
    start = dict(zip(machine.state_names, FullStability(torques, True).start(at), strict=True))
    expected = rebuilt(slow, np.zeros(1), state[:, None], np.zeros(1))
    assert {name: expected[name][0] for name in start} == pytest.approx(start, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("sense", [1, -1])
def test_gravity_makes_a_rotor_fluctuate_about_its_even_rotation(sense: int) -> None:
    """J phi'' = -U g cos phi, near phi = +-w t: phi = +-w t + U g/(J w^2) cos w t, the same in both senses.

    In the averaged equations it is the angle of the machine that is counted, which is the sense times that of the motion.
    """
    rotor = {"kind": "rotor", "name": "r", "mass": 5.0, "unbalance": 4e-3, "inertia": 0.05}
    drive = {"on": "r", "kind": "linear", "slope": 1e-9, "no_load_speed": sense * 30.0}
    carrier = {"mass": 10.0, "stiffness": 4e4, "damping": 60.0, "gravity": 9.81}
    averaged_equations = averaged_equations_of(machine_from({"carrier": carrier, "bodies": [rotor], "drive": drive}))
    speed, theta = 40.0, np.linspace(0.0, 6.0, 7)
    states = averaged_equations.state({"r": 0.0}, {"r": sense * speed})[:, None] * np.ones(7)
    whole = states_with_fast_parts(averaged_equations, theta / speed, states, theta)
    rows = dict(zip(averaged_equations.machine.state_names, whole, strict=True))
    size = 4e-3 * 9.81 / (0.05 * speed**2)
    assert rows["r.angle"] - sense * theta == pytest.approx(size * np.cos(theta), abs=1e-6 * size)
    assert rows["r.speed"] - sense * speed == pytest.approx(-size * speed * np.sin(theta), abs=1e-6 * size * speed)
