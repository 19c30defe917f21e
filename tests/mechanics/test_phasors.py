"""Symbolic complex amplitudes, and the response of a linear carrier as a program."""

import numpy as np
import pytest
import sympy as sp

from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import HarmonicResponse, Lines, Phasor, product

A, B, C = sp.symbols("a b c", real=True)


def numbers(lines: Lines, *expressions: sp.Expr) -> list[float]:
    """Evaluate definitions in order, then expressions, without free parameters."""
    known: dict[sp.Symbol, sp.Expr] = {}
    for symbol, expression in lines.pairs:
        assert symbol not in known  # every result has a name of its own
        known[symbol] = sp.sympify(expression).xreplace(known)
    return [float(sp.sympify(e).xreplace(known)) for e in expressions]


def test_a_complex_expression_is_split() -> None:
    assert Phasor.of((A - B) * C - sp.I * (A - B)) == Phasor(A * C - B * C, -A + B)
    assert Phasor.of(-sp.I * A * (B + sp.I * C)) == Phasor(A * C, -A * B)


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
    response = HarmonicResponse(sp.Matrix([[A]]), sp.Matrix([[0]]), sp.Matrix([[B]]), C, ["x"], lines)
    (z,) = response([Phasor(sp.S.One)], "z")
    assert z.im == 0
    assert sp.simplify(lines_explicit(lines, z.re) - 1 / (B - C**2 * A)) == 0


def lines_explicit(lines: Lines, expression: sp.Expr) -> sp.Expr:
    for symbol, meaning in reversed(lines.pairs):
        expression = expression.xreplace({symbol: meaning})
    return expression


def test_rates_go_through_the_definitions() -> None:
    x, y = sp.symbols("x y", real=True)
    lines = Lines()
    s = lines.name(sp.sin(x) * y, "s")
    t = lines.name(s**2 + A, "t")
    (rate,) = lines.rates({x: y, y: B}, [t * x], "'", list(lines.pairs))
    whole = (sp.sin(x) ** 2 * y**2 + A) * x
    meant = sp.diff(whole, x) * y + sp.diff(whole, y) * B
    assert sp.expand(lines_explicit(lines, rate) - meant) == 0


def test_elimination_of_a_matrix_that_is_not_symmetric() -> None:
    rng = np.random.default_rng(5)
    matrix, right = rng.normal(size=(4, 4)) + 4 * np.eye(4), rng.normal(size=4)
    matrix[2, 0] = matrix[0, 3] = 0.0
    lines = Lines()
    rows = [[sp.Float(e) if e else sp.S.Zero for e in row] for row in matrix]
    solution = solve_by_elimination(sp.Matrix(rows), list(map(sp.Float, right)), list("pqrs"), lines, "x", symmetric=False)
    assert np.allclose(numbers(lines, *solution), np.linalg.solve(matrix, right), rtol=1e-12)
