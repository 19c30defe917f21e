"""Elimination gives what LU decomposition gives, and stays small for machines with many bodies."""

import random

import numpy as np
import pytest
import sympy as sp

from wucht.files.building import machine_from
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import Lines
from wucht.system import substitute_definitions


def solved(mass, forces):
    names = [f"q{i}" for i in range(mass.rows)]
    accelerations = solve_by_elimination(mass, forces, names, lines := Lines())
    return sp.Matrix([substitute_definitions(sp.sympify(a), lines.pairs) for a in accelerations])


@pytest.mark.parametrize("seed", range(12))
def test_random_symmetric_matrices_exactly(seed):
    """Positive definite, rational, half of them sparse: no rounding, so the results are the same fractions."""
    draw = random.Random(seed)
    n = draw.randint(1, 7)
    full = sp.Matrix(
        n, n, lambda i, j: sp.Integer(draw.randint(-5, 5)) if draw.random() < 0.3 + 0.7 * (seed % 2) else sp.S.Zero
    )
    mass = full * full.T + sp.diag(*[draw.randint(1, 4) for _ in range(n)])
    forces = sp.Matrix(n, 1, lambda i, j: sp.Rational(draw.randint(-9, 9), draw.randint(1, 5)))
    assert solved(mass, forces) == mass.LUsolve(forces)


@pytest.mark.parametrize(
    "pattern",
    [
        [[1, 1], [1, 1]],
        [[1, 1, 1], [1, 1, 1], [1, 1, 1]],
        [[1, 0, 1], [0, 1, 1], [1, 1, 1]],
    ],
    ids=["full 2x2", "full 3x3", "arrow"],
)
def test_symbolic_matrices(pattern):
    n = len(pattern)
    mass = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"m{min(i, j)}{max(i, j)}") * pattern[i][j])
    forces = sp.Matrix(sp.symbols(f"f:{n}"))
    assert (solved(mass, forces) - mass.LUsolve(forces)).applyfunc(sp.cancel) == sp.zeros(n, 1)


def test_a_chain_of_four_symbolically():
    """Solved in symbols first, then compared at rational values, which is exact."""
    mass = sp.Matrix(4, 4, lambda i, j: sp.Symbol(f"m{min(i, j)}{max(i, j)}") if abs(i - j) < 2 else sp.S.Zero)
    forces = sp.Matrix(sp.symbols("f:4"))
    symbolic, draw = solved(mass, forces), random.Random(4)
    for _ in range(5):
        numbers = {s: sp.Rational(draw.randint(1, 50), draw.randint(1, 9)) for s in mass.free_symbols | forces.free_symbols}
        assert symbolic.xreplace(numbers) == mass.xreplace(numbers).LUsolve(forces.xreplace(numbers))


def test_nothing_to_solve():
    lines = Lines()
    assert solve_by_elimination(sp.Matrix(0, 0, []), [], [], lines) == []
    assert lines.pairs == []


def rotor_with(pendulums):
    body = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "damping": 0.169}
    return machine_from(
        {
            "carrier": {"stiffness": 1e5, "damping": 200.0, "gravity": 9.81},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.01},
                *({**body, "name": f"p{i}"} for i in range(pendulums)),
            ],
            "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 200.0},
        }
    )


def test_the_program_grows_linearly_with_the_number_of_bodies():
    systems = {n: rotor_with(n).system for n in (2, 4, 8)}
    lines = {n: len(s.definitions) for n, s in systems.items()}
    operations = {n: sum(sp.count_ops(e) for _, e in s.definitions) for n, s in systems.items()}
    assert lines[8] - lines[4] == 2 * (lines[4] - lines[2])
    assert operations[8] - operations[4] == 2 * (operations[4] - operations[2])
    assert lines[8] - lines[4] <= 4 * 15


def test_eight_pendulums_numerically():
    """The straight-line program against NumPy's LU decomposition of the whole mass matrix."""
    machine = rotor_with(8)
    system, motion = machine.system, machine.system.second_order
    draw = random.Random(8)
    values = machine.numbers | {s: draw.uniform(-2, 2) for s in system.states}
    for symbol, expression in system.definitions:
        values[symbol] = float(expression.xreplace(values))
    accelerations = [float(d.xreplace(values)) for d in system.derivatives[len(motion.coordinates) :]]
    mass = np.array(motion.mass.xreplace(values).tolist(), float)
    forces = np.array(motion.forces.xreplace(values).tolist(), float).ravel()
    assert np.allclose(mass, mass.T, rtol=0, atol=0)
    assert np.allclose(accelerations, np.linalg.solve(mass, forces), rtol=1e-9)


def test_a_matrix_that_is_not_symmetric_is_eliminated_in_the_given_order():
    """Its last row has the fewest entries, and a zero on the diagonal: it cannot come first."""
    matrix, right = sp.Matrix([[1, 1, 1], [1, 2, 0], [1, 0, 0]]), [sp.Integer(6), sp.Integer(5), sp.Integer(1)]
    found = solve_by_elimination(matrix, right, "abc", lines := Lines(), symmetric=False)
    assert [substitute_definitions(sp.sympify(a), lines.pairs) for a in found] == [1, 2, 3]
