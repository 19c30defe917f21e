"""Properties of steady phase configurations, of any machine: nothing is left of the torques, the search finds what the closed
form says, equal bodies may be exchanged, and turning the machine over changes nothing.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from wucht.analysis.configurations.closed_form import State, compensating_phases, family_members, fixed_speed_states
from wucht.analysis.configurations.search import search_by_subdivision
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.configurations.torus import TorusProblem
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

few = settings(
    max_examples=25, deadline=None, suppress_health_check=list(HealthCheck),
    phases=(Phase.explicit, Phase.generate),
)  # fmt: skip
UNBALANCE = st.floats(0.002, 0.03)
SPEED = st.floats(20.0, 200.0)
DAMPING = st.floats(0.0, 300.0)


def machine(rotor: float, balls: list[float], speed: float, damping: float, turned: bool = False) -> Machine:
    """A rotor with pendulums of these unbalances (kg m) on springs of different stiffness."""
    common = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    order = slice(None, None, -1 if turned else 1)
    described: dict[str, Any] = {
        "carrier": {"mass": 2.0, "stiffness": [1e4, 2e4][order], "damping": [damping, 1.5 * damping][order]},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": rotor, "inertia": 1.5e-2},
            *(common | {"name": f"b{k}", "mass": u / 0.5} for k, u in enumerate(balls)),
        ],
        "drive": {"kind": "constant-speed", "speed": speed},
    }
    return machine_from(described)


def turned(a: State, b: State) -> float:
    """The largest difference of their phases."""
    return float(np.abs((a.phases - b.phases + np.pi) % (2 * np.pi) - np.pi).max())


@few
@given(UNBALANCE, st.lists(UNBALANCE, min_size=1, max_size=5), SPEED, DAMPING)
def test_nothing_is_left_of_the_torques(rotor: float, balls: list[float], speed: float, damping: float) -> None:
    torques = SteadyTorques.of(machine(rotor, balls, speed, damping))
    states = fixed_speed_states(torques, speed)
    phases = np.array([s.phases for s in states]).reshape(len(states), torques.size).T  # one ball may have none
    left = torques.residual(np.full(len(states), speed), phases)[1:]
    influence = np.abs(torques.influence(np.array([speed]))[0]).max()
    assert np.abs(left).max(initial=0.0) <= 1e-11 * speed**4 * influence


@few
@given(UNBALANCE, UNBALANCE, UNBALANCE, SPEED, st.floats(0.0, 100.0))
def test_the_search_finds_what_the_closed_form_says(a: float, b: float, c: float, speed: float, damping: float) -> None:
    """No less and no more. Where a triangle is all but flat two states nearly coincide, and the search may stay undecided."""
    torques = SteadyTorques.of(machine(a, [b, c], speed, damping))
    closed, searched = fixed_speed_states(torques, speed), search_by_subdivision(torques, 0.0, 0.0, 20_000)
    for state in searched.states:
        exchanged = replace(state, phases=state.phases[[0, 2, 1]]) if len(torques.classes) == 1 else state
        assert min(turned(s, other) for other in closed for s in (state, exchanged)) < 1e-6
    if searched.complete:
        assert len(searched.states) == len(closed)
    else:
        sides = sorted((a, b, c))
        assert abs(sides[2] - sides[0] - sides[1]) < 1e-2 * sum(sides) or _at_an_end(torques, speed)


def _at_an_end(torques: SteadyTorques, speed: float) -> bool:
    """Whether two states in line are about to meet: |sin(beta - eta)| near 1."""
    c = np.abs(torques.coefficients)  # type: ignore[arg-type]
    a = torques.axis_influence(np.array([speed]))[0]
    ratios = np.array([c[1] + c[2], c[1] - c[2]]) / c[0] * abs(a.imag / a)
    return bool((np.abs(np.abs(ratios) - 1) < 1e-2).any())


@few
@given(UNBALANCE, UNBALANCE, st.integers(2, 6), SPEED, DAMPING)
def test_equal_bodies_may_be_exchanged(rotor: float, ball: float, count: int, speed: float, damping: float) -> None:
    """Each entry stands for its multiplicity: together they are the states of bodies that can be told apart."""
    torques = SteadyTorques.of(machine(rotor, [ball] * count, speed, damping))
    apart = SteadyTorques.of(machine(rotor, [ball * (1 + 1e-9 * k) for k in range(count)], speed, damping))
    equal, different = (sum(s.multiplicity for s in fixed_speed_states(t, speed) if s.sides) for t in (torques, apart))
    assert len(torques.classes) == 1
    assert len(apart.classes) == count
    assert equal == different


@few
@given(UNBALANCE, st.lists(UNBALANCE, min_size=3, max_size=8))
def test_the_family_compensates(rotor: float, balls: list[float]) -> None:
    """Where the force polygon closes, 000 (41), and only there."""
    torques = SteadyTorques.of(machine(rotor, balls, 100.0, 50.0))
    sizes = np.array([rotor, *balls])
    closed = compensating_phases(torques)
    if 2 * sizes.max() > sizes.sum() * (1 + 1e-6):
        assert closed == []
    elif 2 * sizes.max() < sizes.sum() * (1 - 1e-6):
        ((at, dimension, _),) = closed
        assert dimension == len(balls) - 2
        every = np.concatenate([at[:, None], family_members(torques, 10)], axis=1)
        assert np.abs((sizes[:, None] * np.exp(1j * every)).sum(axis=0)).max() < 1e-11 * sizes.sum()


@few
@given(UNBALANCE, UNBALANCE, UNBALANCE, SPEED, DAMPING)
def test_the_machine_turned_by_a_right_angle(a: float, b: float, c: float, speed: float, damping: float) -> None:
    """x and y exchanged: phases count from the rotor, so that they are the same; both stiffnesses act alike."""
    states, turned_states = (
        fixed_speed_states(SteadyTorques.of(machine(a, [b, c], speed, damping, by_90)), speed) for by_90 in (False, True)
    )
    assert len(states) == len(turned_states)
    for state in states:
        assert min(turned(state, twin) for twin in turned_states) < 1e-6


@few
@given(st.integers(0, 10_000), st.sampled_from([None, 60.0]), st.floats(0.001, 1.0), st.floats(0.001, 20.0))
def test_the_bounds_on_the_jacobian_hold(seed: int, held: float | None, turn: float, wide: float) -> None:
    """What makes the search complete: nowhere in a box does the Jacobian differ by more than is claimed."""
    problem, draw = TorusProblem(SteadyTorques.of(driven(held))), np.random.default_rng(seed)
    unknowns = 2 if held is not None else 3
    centre, radius = draw.uniform(0, 2 * np.pi, (unknowns, 20)), np.full((unknowns, 20), turn)
    if held is None:
        centre[-1], radius[-1] = draw.uniform(20.0, 150.0, 20), wide
    bound, middle = problem.spread(centre, radius), problem.jacobian(centre)
    scale = np.abs(middle).max()
    for _ in range(20):
        other = problem.jacobian(centre + draw.uniform(-1, 1, centre.shape) * radius)
        assert (np.abs(other - middle) <= bound * (1 + 1e-9) + 1e-11 * scale).all()


@cache
def driven(held: float | None) -> Machine:
    """Three exciters on a planar body, one against the others, with motors of two kinds and a load."""
    induction = {
        "kind": "induction", "voltage": 230, "frequency": 50, "pole_pairs": 2, "stator_resistance": 2, "rotor_resistance": 1.5,
        "stator_reactance": 3, "rotor_reactance": 3,
    }  # fmt: skip
    first = {"kind": "constant-speed", "speed": held} if held is not None else induction
    bodies = [
        {"kind": "rotor", "name": f"e{k}", "mass": 3.0, "unbalance": 0.1 + 0.02 * k, "inertia": 1.5e-2, "position": at}
        for k, at in enumerate([[0.3, 0.0], [-0.3, 0.1], [0.0, 0.4]])
    ]
    return machine_from(
        {
            "carrier": {
                "directions": "xyr", "mass": 50.0, "inertia": 6.0, "stiffness": [1e5, 2e5], "damping": 400.0,
                "rotation_stiffness": 1e4, "rotation_damping": 40.0,
            },
            "bodies": bodies,
            "drives": [
                {"on": "e0"} | first,
                {"on": "e1", "kind": "linear", "slope": 0.1, "no_load_speed": -150.0},
                {"on": "e2"} | induction,
            ],
            "loads": [{"on": "e2", "kind": "quadratic", "coefficient": 1e-4}],
        }
    )  # fmt: skip
