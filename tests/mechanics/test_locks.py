"""Locks: a body that is locked to another moves as if it were rigidly connected, a released one as if it had never been locked.

The witness is another mechanism: the same masses rigidly connected, described by absolute positions (``tests/witness.py``).
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
import sympy as sp

from wucht import RunUp, run
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.mechanics.energies import InternalState, StateDescription
from wucht.mechanics.lagrange import Coordinate, Lock, acceleration, first_order, reaction
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import TIME, SecondOrder

FAR = {"time": 1e6}
DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.02, "inertia": 0.02, "bearing_damping": 1e-3}
P1 = {"kind": "pendulum", "name": "p1", "about": "drum", "mass": 0.3, "length": 0.1, "inertia": 0.004, "damping": 0.02}
P2 = {"kind": "pendulum", "name": "p2", "about": "p1", "mass": 0.2, "length": 0.15, "damping": 0.03}
MACHINE = {
    "carrier": {"mass": 1.0, "stiffness": [4e3, 9e3], "damping": [6.0, 9.0], "gravity": 9.81},
    "bodies": [DRUM, P1, P2],
    "drive": {"kind": "linear", "slope": 0.05, "no_load_speed": 45.0},
}
START = {"drum": 0.4, "p1": 0.7, "p2": -1.1}
TIME_GRID = np.linspace(0.0, 1.0, 51)


def released(*when, **changed):
    """MACHINE with releases of p1 and p2 (None: free from the start)."""
    bodies = [DRUM, *(b if w is None else b | {"release": w} for b, w in zip((P1, P2), when, strict=True))]
    return machine_from(MACHINE | {"bodies": bodies} | changed)


def states(machine, start, grid=TIME_GRID, parameters=None, initial=None):
    flow = compile_system(machine.system)
    trajectory = integrate(
        flow, initial_state(machine, start) if initial is None else initial, parameters or machine.values, grid
    )
    assert trajectory.failure is None
    outputs = flow.outputs(trajectory.time, trajectory.states, trajectory.final_parameter_values)
    return dict(zip(machine.system.state_names, trajectory.states, strict=True)) | dict(trajectory.quadratures) | outputs


def test_locks_do_no_work_and_locked_dampers_lose_none():
    motion = states(released(FAR, FAR), START)
    gap = motion["supplied_work"] - motion["dissipated_work"] - motion["stored_energy"] + motion["stored_energy"][0]
    assert np.abs(gap).max() < 1e-9 * motion["supplied_work"].max()
    stiff = states(released(FAR, FAR, bodies=[DRUM, P1 | {"release": FAR, "damping": 9.0}, P2 | {"release": FAR}]), START)
    assert stiff["dissipated_work"] == pytest.approx(motion["dissipated_work"], rel=1e-9, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [50.0, -50.0])
def test_a_speed_of_release_that_is_reached_at_the_start(speed):
    """The drum turns with 50 rad/s from the beginning: a release at 40 rad/s is one at t = 0, one at 60 rad/s never comes."""
    drive = {"kind": "constant-speed", "speed": speed}
    start = {"p1": 0.7, "p2": -1.1}
    free = run(RunUp(until=0.5, start=start), released(None, None, drive=drive))
    for engine in (None, "radau"):
        early = run(RunUp(until=0.5, start=start, tolerance=1e-9, engine=engine), released({"speed": 40.0}, None, drive=drive))
        assert early.angle.values[..., -1] == pytest.approx(free.angle.values[..., -1], abs=1e-6)
        never = run(RunUp(until=0.5, start=start, tolerance=1e-9, engine=engine), released({"speed": 60.0}, None, drive=drive))
        assert (never.angle.sel(body="p1") - never.angle.sel(body="drum")).values == pytest.approx(0.7, abs=1e-10)


def test_a_locked_rotor_turns_with_a_carrier_that_turns():
    """On a carrier that turns about the normal the locked rotor is part of it: frequency sqrt(c/(Theta + J + m a^2))."""
    body = {"kind": "rotor", "name": "exciter", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.05, "release": FAR}
    carrier = {"directions": "r", "inertia": 0.4, "rotation_stiffness": 90.0}
    machine = machine_from({"carrier": carrier, "bodies": [body | {"position": [0.3, 0.0]}]})
    motion = states(machine, {"carrier": {"r": 0.01}})
    frequency = math.sqrt(90.0 / (0.4 + 0.05 + 2.0 * 0.3**2))
    assert motion["carrier.r"] == pytest.approx(0.01 * np.cos(frequency * TIME_GRID), abs=1e-11)
    assert motion["exciter.angle"] == pytest.approx(motion["carrier.r"] - 0.01, abs=1e-11)


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
