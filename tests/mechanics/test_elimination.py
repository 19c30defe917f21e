"""Elimination gives what LU decomposition gives, and stays small for machines with many bodies."""

import random

import numpy as np
import pytest
import sympy as sp

from wucht.files.building import machine_from
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import HarmonicResponse, Lines, Phasor, product
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


def test_a_matrix_that_is_not_symmetric_is_eliminated_in_the_given_order():
    """Its last row has the fewest entries, and a zero on the diagonal: it cannot come first."""
    matrix, right = sp.Matrix([[1, 1, 1], [1, 2, 0], [1, 0, 0]]), [sp.Integer(6), sp.Integer(5), sp.Integer(1)]
    found = solve_by_elimination(matrix, right, "abc", lines := Lines(), symmetric=False)
    assert [substitute_definitions(sp.sympify(a), lines.pairs) for a in found] == [1, 2, 3]


A, B, C = sp.symbols("a b c", real=True)


def numbers(lines: Lines, *expressions: sp.Expr) -> list[float]:
    """Evaluate definitions in order, then expressions, without free parameters."""
    known: dict[sp.Symbol, sp.Expr] = {}
    for symbol, expression in lines.pairs:
        assert symbol not in known  # every result has a name of its own
        known[symbol] = sp.sympify(expression).xreplace(known)
    return [float(sp.sympify(e).xreplace(known)) for e in expressions]


def test_arithmetic_is_that_of_complex_numbers() -> None:
    a, b = Phasor(A, B), Phasor(B, C)
    x, y = A + sp.I * B, B + sp.I * C
    for computed, meant in ((a * b, x * y), (a + b, x + y), (a - b, x - y), (a.times_i, sp.I * x), (a.conj, A - sp.I * B)):
        assert sp.expand(computed.re + sp.I * computed.im - meant) == 0
    assert product([a, b], [b, a]) == Phasor(sp.Add(*2 * [(a * b).re]), sp.Add(*2 * [(a * b).im]))


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_response_of_coupled_coordinates(size: int) -> None:
    """Against numpy's solution of K - w^2 M + i w C, for two forces with one factorisation."""
    rng = np.random.default_rng(size)
    mass, damping, stiffness = (r @ r.T + np.eye(size) for r in rng.normal(size=(3, size, size)))
    forces = rng.normal(size=(2, size)) + 1j * rng.normal(size=(2, size))
    lines = Lines()
    names = [f"q{i}" for i in range(size)]
    symbolic = [sp.Matrix(size, size, list(map(sp.Float, m.ravel()))) for m in (mass, damping, stiffness)]
    response = HarmonicResponse(symbolic[0], symbolic[1], symbolic[2], sp.Float(1.7), names, lines)
    dynamic = stiffness - 1.7**2 * mass + 1.7j * damping
    for k, force in enumerate(forces):
        z = response([Phasor(sp.Float(f.real), sp.Float(f.imag)) for f in force], f"z{k}")
        values = numbers(lines, *(x for p in z for x in (p.re, p.im)))
        amplitudes = np.array(values[::2]) + 1j * np.array(values[1::2])
        assert np.abs(amplitudes - np.linalg.solve(dynamic, force)).max() < 1e-10


def test_an_undamped_coordinate_has_a_real_response() -> None:
    lines = Lines()
    response = HarmonicResponse(sp.Matrix([[2.0]]), sp.Matrix([[0]]), sp.Matrix([[5.0]]), sp.Float(3.0), ["x"], lines)
    (z,) = response([Phasor(sp.S.One)], "z")
    assert z.im == 0
    assert numbers(lines, z.re) == pytest.approx([1 / (5 - 9 * 2)])
