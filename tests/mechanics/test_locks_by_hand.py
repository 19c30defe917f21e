"""Accelerations and reactions of locked and driven coordinates: against constraints with multipliers, of random numbers."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import sympy as sp

from wucht.mechanics.energies import InternalState, StateDescription
from wucht.mechanics.lagrange import Coordinate, Lock, acceleration, first_order, reaction
from wucht.system import TIME, SecondOrder

COUNT = 4
SWITCHES = sp.symbols("l0:4", real=True)
SPEED = 3.0 + 2.5 * TIME**2  # of a driven coordinate: its acceleration is 5 t


def mechanism(
    locks: list[Lock], on: tuple[bool, ...], driven: int | None
) -> tuple[np.ndarray, np.ndarray, dict[sp.Symbol, float]]:
    """Mass matrix and forces of four coordinates at random, and the values of all definitions at t = 0.4 with some locks on."""
    random = np.random.default_rng(5)
    root = random.normal(size=(COUNT, COUNT))
    mass, forces = root @ root.T + COUNT * np.eye(COUNT), random.normal(size=COUNT)
    coordinates = [
        Coordinate.from_names(f"q{i}", f"v{i}", prescribed_velocity=SPEED if i == driven else None) for i in range(COUNT)
    ]
    motion = SecondOrder(
        tuple(c.position for c in coordinates), tuple(c.velocity for c in coordinates), sp.ImmutableMatrix(mass),
        sp.ImmutableMatrix(forces),
    )  # fmt: skip
    system = first_order(motion, coordinates, tuple(lock.switch for lock in locks), locks=locks)
    switches = {lock.switch: float(is_on) for lock, is_on in zip(locks, on, strict=True)}
    values: dict[sp.Symbol, float] = {TIME: 0.4} | switches
    for symbol, expression in system.definitions:
        values[symbol] = float(sp.sympify(expression).xreplace(values))
    return mass, forces, values


def by_multipliers(
    mass: np.ndarray, forces: np.ndarray, pairs: list[tuple[int, int | None]], driven: int | None
) -> tuple[np.ndarray, float]:
    """Accelerations with a_i = a_k (or 0) for each pair, and the force that gives the driven one its acceleration of 2."""
    rows, right = [], []
    for i, k in pairs:
        rows.append(np.eye(COUNT)[i] - (np.eye(COUNT)[k] if k is not None else 0.0))
        right.append(0.0)
    if driven is not None:
        rows.append(np.eye(COUNT)[driven])
        right.append(2.0)
    c = np.array(rows).reshape(-1, COUNT)
    whole = np.block([[mass, -c.T], [c, np.zeros((len(c), len(c)))]])
    solution = np.linalg.solve(whole, np.concatenate([forces, right]))
    return solution[:COUNT], float(solution[-1]) if driven is not None else 0.0


LOCKS = {
    "at rest": [(1, None)],
    "to the next": [(1, 2)],
    "to one before": [(3, 0)],
    "two to one": [(1, 0), (2, 0)],
    "a chain": [(2, 1), (1, 0)],
    "a chain of three": [(3, 2), (2, 1), (1, 0)],
    "a chain at rest": [(2, 1), (1, None)],
}


@pytest.mark.parametrize("driven", [None, 0])
@pytest.mark.parametrize("pairs", LOCKS.values(), ids=LOCKS)
def test_locked_coordinates_have_one_acceleration(pairs: list[tuple[int, int | None]], driven: int | None) -> None:
    """With each of them on and off: those on the followers of others come first."""
    locks = [Lock(i, k, SWITCHES[i]) for i, k in pairs]
    for on in product([True, False], repeat=len(locks)):
        mass, forces, values = mechanism(locks, on, driven)
        active = [pair for pair, is_on in zip(pairs, on, strict=True) if is_on]
        expected, force = by_multipliers(mass, forces, active, driven)
        found = [values[acceleration(Coordinate.from_names(f"q{i}", f"v{i}"))] for i in range(COUNT)]
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-12)
        if driven is not None:
            assert values[reaction(Coordinate.from_names("q0", "v0"))] == pytest.approx(force, rel=1e-9)
            assert values[sp.Symbol("v0", real=True)] == pytest.approx(3.0 + 2.5 * 0.16)


def test_states_are_positions_free_velocities_and_internal_states() -> None:
    q, v = zip(*[(f"q{i}", f"v{i}") for i in range(3)], strict=True)
    coordinates = [Coordinate.from_names(a, b, angle=i == 2, prescribed_velocity=SPEED if i == 1 else None)
                   for i, (a, b) in enumerate(zip(q, v, strict=True))]  # fmt: skip
    description = StateDescription("z", "m", "strain", "z")
    state = InternalState(description.at("damper"), coordinates[0].velocity - 4, description, sp.S.One)
    motion = SecondOrder(
        tuple(c.position for c in coordinates), tuple(c.velocity for c in coordinates), sp.ImmutableMatrix(np.diag([2, 3, 4])),
        sp.ImmutableMatrix([10, 20, 30]),
    )  # fmt: skip
    system = first_order(motion, coordinates, (), internal=[state])
    assert system.state_names == ("q0", "q1", "q2", "v0", "v2", "damper.z")
    assert {s.name for s in system.angles} == {"q2"}
    values = {TIME: 0.4, coordinates[0].velocity: 7.0}
    for symbol, expression in system.definitions:
        values[symbol] = float(sp.sympify(expression).xreplace(values))
    rates = [sp.sympify(d).xreplace(values) for d in system.derivatives]
    assert [float(r) for r in (rates[0], rates[1], *rates[3:])] == pytest.approx([7.0, 3.4, 5.0, 7.5, 3.0])
    assert values[reaction(coordinates[1])] == pytest.approx(3 * 2.0 - 20)
