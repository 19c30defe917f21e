"""What steady states of machines and equations are called, why their branches end, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.branches import steady_states
from wucht.dynamics.branches.averaged_equilibria import AveragedEquilibria
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.steady_states import SystemEquilibria
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.system import System

X, Y, P, S = sp.symbols("x y p s", real=True)
TABLE = "drozdetskaya-2020/table-5.1"


def table(**settings: Any) -> AveragedEquilibria:
    return AveragedEquilibria.of(load_machine(TABLE), "u", (0.5, 4.0), **settings)


def test_phases_of_a_state_are_those_to_the_main_rotor_of_bodies_on_the_others_too() -> None:
    exciter = {"kind": "rotor", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03}
    ball = {"kind": "pendulum", "name": "ball", "about": "second", "mass": 0.1, "length": 0.1, "damping": 0.05}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
        "bodies": [exciter | {"name": "first"}, exciter | {"name": "second"}, ball],
        "drives": [{"on": on, "kind": "linear", "slope": 0.01, "no_load_speed": 200.0} for on in ("first", "second")],
    })  # fmt: skip
    states = AveragedEquilibria.of(machine, "carrier.damping", (100.0, 300.0))
    assert states.model_at(200.0).torques.names == ("first", "second", "ball")
    there = State(190.0, np.array([0.0, 1.0, 3.0]))
    assert states.state(states.point(there, 200.0)).phases == pytest.approx(there.phases)


def test_ranges_of_speeds_and_angles_in_which_steady_states_are_searched() -> None:
    """Of a machine from 0.02 to 1.15 of its fastest speed."""
    machine, states = load_machine(TABLE), table()
    motion = ModulatedMotion.of(machine, "u", states.bounds, states, together=True)
    turning, fastest = motion.subject.turning, states.ordinate_size
    assert motion.box[:, turning].tolist() == [[0.0] * turning.sum(), [2 * np.pi] * turning.sum()]
    np.testing.assert_allclose(motion.box[:, ~turning].T, [[0.02 * fastest, 1.15 * fastest]] * (~turning).sum())
    assert motion.whole is not None and len(motion.whole.turning) > len(turning)
    assert motion.starts(4).shape == (4, len(motion.whole.turning))


def test_states_are_the_same_but_for_whole_turns_of_angles() -> None:
    """In units of the ranges' widths, 4 and 2; an angle in radians; by name an angle is within a turn."""
    theta = sp.Symbol("theta", real=True)
    system = System((theta, X), (P - sp.sin(theta), -X), (P,), angles=frozenset({theta}))
    states = SystemEquilibria.of(wucht.UserSystem(system, {"p": 0.5}), "p", (0.0, 2.0), {"x": (-1.0, 3.0)}, show="x")
    u, near = np.array([1.0, 0.5, 0.25]), steady_states._SAME
    for k, size in ((0, 1.0), (1, 4.0), (2, 2.0)):
        for way in (1, -1):
            assert states.is_same(u, u + 0.99 * way * near * size * np.eye(3)[k])
            assert not states.is_same(u, u + 1.01 * way * near * size * np.eye(3)[k])
    turned = u + np.array([2 * np.pi, 0.0, 0.0])
    assert states.is_same(u, turned) and states.is_same(turned, u) and states.is_same(u, u - 3 * (turned - u))
    assert not states.is_same(u, u + np.array([np.pi, 0.0, 0.0])) and not states.is_same(u, u + np.array([0.0, 2 * np.pi, 0.0]))
    assert states.state_by_name(turned) == {"theta": pytest.approx(1.0), "x": 0.5}
    assert states.ordinate(u[:, None]).tolist() == [0.5] and states.ordinate_size == 4.0
    assert states.labels.state == "x" and states.nominal_value == 0.5 and states.equilibria.limits == {1: (-5.0, 7.0)}
