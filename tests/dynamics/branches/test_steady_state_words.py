"""Phases and names of steady states of machines, and the ranges in which they are searched."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.branches.averaged_equilibria import AveragedEquilibria
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.steady_states import Kind
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine

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


def states(sense: float = 1.0, second: float = 0.05) -> AveragedEquilibria:
    ball = {"kind": "pendulum", "about": "d", "length": 0.1, "damping": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 5.0},
        "bodies": [
            {"kind": "rotor", "name": "d", "mass": 1.0, "unbalance": 4e-3, "inertia": 0.01}, ball | {"name": "p", "mass": 0.05},
            ball | {"name": "q", "mass": second},
        ],
        "drive": {"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": sense * 300.0},
    })  # fmt: skip
    return AveragedEquilibria.of(machine, "d.unbalance", (1e-3, 9e-3))


@pytest.mark.parametrize(
    ("first", "second", "psi", "delta"),
    [(1.0, 0.5, 0.75, 0.5), (0.5, 1.0, 0.75, -0.5), (6.0, 0.25, 3.125 - math.pi, 5.75 - 2 * math.pi), (3.5, 3.0, None, 0.5)],
)
@pytest.mark.parametrize("equal", [True, False])
def test_steady_states_by_name(first: float, second: float, psi: float | None, delta: float, equal: bool) -> None:
    """psi is the mean of the phases, in (-pi, pi], delta their difference; of equal bodies without its sign."""
    of = states(second=0.05 if equal else 0.06)
    values = {"p.phase": first, "q.phase": second, "d.speed": 200.0}
    unknowns = np.array([*(values.get(n, 0.0) for n in of.names), 4e-3])
    found = of.state_by_name(unknowns)
    assert found["p.phase"] == pytest.approx(first) and found["q.phase"] == pytest.approx(second)
    assert found["delta"] == pytest.approx(abs(delta) if equal else delta)
    mean = second + delta / 2 if psi is None else psi
    assert math.remainder(found["psi"] - mean, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert -math.pi < found["psi"] <= math.pi


def test_names_of_steady_states_at_a_value_of_the_unbalance() -> None:
    """By the phases of both bodies; whether they compensate the unbalance depends on its value, 4 or 8 of 10 g m."""
    of, half, most = states(), math.acos(-0.4), math.acos(-0.8)

    def kind(first: float, second: float, value: float = 4e-3, of: AveragedEquilibria = of) -> Kind:
        return of.kind(of.point(State(150.0, np.array([0.0, first, second])), value))

    assert kind(1.0, 1.0) == kind(math.pi, math.pi) == Kind("together", "II", (2, 0), 1)
    assert kind(0.0, math.pi) == kind(math.pi, 0.0) == Kind("opposed", "III", (1, 1), 2)
    assert kind(half, -half) == kind(most, -most, 8e-3) == Kind("compensating", "I", None, 2)
    assert kind(half, -half, 8e-3) == kind(most, -most) == kind(1.0, 2.0) == Kind(None, None, None, 2)
    assert kind(math.pi, 0.0, of=states(second=0.06)) == Kind("opposed", None, (1, 1), 1)
