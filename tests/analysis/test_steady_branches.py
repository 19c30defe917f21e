"""Steady phases over the speed: the states that each speed alone has, their slopes, their names, and where they are stable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.refusals import refused

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.closed_form import fixed_speed_states
from wucht.analysis.configurations.steady_branches import steady_branches
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.vibration import ForcedVibration
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.operation import machine_at_speed

NAMES = ("drozdetskaya-2020/r1", "practice/exciter")


@pytest.mark.parametrize("name", NAMES)
def test_at_each_speed_they_are_the_states_at_that_speed(name: str) -> None:
    machine = load_machine(name)
    _, branches = steady_branches(machine)
    mass, _, stiffness = machine.matrices
    for share in (0.4, 1.1, 1.9):
        w = share * float(np.sqrt(stiffness[0, 0] / mass[0, 0]))
        held = machine_at_speed(machine, w)
        torques, at = SteadyTorques.of(held), np.array([w])
        stability = AveragedStability(torques, averaged_equations_of(held))
        expected = {tuple(np.round(s.phases, 9)): stability.stability(s).stable for s in fixed_speed_states(torques, w)}
        there = [b for b in branches if b.labels(at)[0]]
        found = {tuple(np.round(b.phases(at)[:, 0] % (2 * np.pi), 9)): bool(b.stable(at)[0]) for b in there}
        assert found == expected


@pytest.mark.parametrize("name", NAMES)
def test_slopes_along_a_branch_are_those_of_the_curve(name: str) -> None:
    """By central differences: of the vibration's torque and amplitude, with the phases that change with the speed."""
    machine = load_machine(name)
    _, branches = steady_branches(machine)
    forced, top = ForcedVibration.of(machine, np.zeros(len(machine.bodies))), 200.0 if machine.units.speed else 2.0
    for branch in branches:
        w, h = np.linspace(0.05, 1.0, 60) * top, 1e-6 * top
        whole = np.isfinite(branch.phases(w + 0.005 * top)[-1]) & np.isfinite(branch.phases(w - 0.005 * top)[-1])
        w, along = w[whole], replace(forced, phase_law=branch.machine_phases)
        for curve in (along.torque, along.amplitude):
            slope, numeric = curve(w)[1], (curve(w + h)[0] - curve(w - h)[0]) / (2 * h)
            assert slope == pytest.approx(numeric, rel=1e-5, abs=1e-7 * np.abs(numeric).max(initial=0.0))
        for body in range(len(machine.bodies)):
            slope = along.torque_on(w, [body])[1]
            numeric = (along.torque_on(w + h, [body])[0] - along.torque_on(w - h, [body])[0]) / (2 * h)
            assert slope == pytest.approx(numeric, rel=1e-5, abs=1e-7 * np.abs(along.torque(w)[1]).max(initial=1e-9))


def test_what_configurations_are_called() -> None:
    _, (compensating, opposed, *together) = steady_branches(load_machine("drozdetskaya-2020/r1"))
    at = np.array([0.0, 50.0, 150.0])
    assert compensating.labels(at).tolist() == ["", "compensating", "compensating"]
    assert compensating.stable(at).tolist() == [False, False, True]
    assert opposed.labels(at).tolist() == ["", "opposed", "opposed"]
    assert {b.labels(at)[1] for b in together} == {"together, heavy side", "together, light side"}
    stable = [bool(b.stable(at)[1]) for b in together if b.labels(at)[1] == "together, heavy side"]
    assert stable == [True]
    edges = np.concatenate([b.ends(np.linspace(0, 200, 400)) for b in together])
    assert np.isfinite(together[0].phases(edges)[-1]).sum() == len(edges) / 2, "on both sides of each end"


def test_refused() -> None:
    with refused("machine", code="slider"):
        steady_branches(load_machine("practice/laundry-drum-switchable"))
    rotor = {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.03}
    pair = [rotor, rotor | {"name": "other"}, {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.1, "length": 0.1}]
    balanced = [rotor | {"eccentricity": 0.0}, pair[2]]
    with refused("machine.bodies", code="no-unbalance"):
        steady_branches(machine_from({"carrier": {"stiffness": 1e5}, "bodies": balanced}))
    with refused("machine.bodies", code="several-rotors"):
        steady_branches(machine_from({"carrier": {"stiffness": 1e5}, "bodies": pair}))
