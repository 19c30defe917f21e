"""Boundary value problems written as formulas, and their solutions over a parameter, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq
from tests.refusals import failed, rejected

from wucht.numerics.collocation.boundary_values import (
    BoundaryValueProblem,
    EndValues,
    Reference,
    end_value,
    start_value,
)
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import Solutions, solve_across_row
from wucht.numerics.continuation.curve import Curve
from wucht.system import System

MESH = Mesh.even(20, 4)


def start(height: float, load: float) -> np.ndarray:
    t = MESH.nodes
    return np.append(np.column_stack([4 * height * t * (1 - t), 4 * height * (1 - 2 * t)]).ravel(), load)


def test_from_where_whole_steps_go_astray() -> None:
    """y' = 0, arctan y(0) = 0: from y = 1.392 on whole steps of Newton's method grow."""

    def field(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros((1, u.shape[1])), np.zeros((1, 2, u.shape[1]))

    def ends(first: np.ndarray, _: np.ndarray, __: np.ndarray) -> EndValues:
        return np.arctan(first), np.array([1 / (1 + first**2)]), np.zeros((1, 1)), np.zeros((1, 1))

    nothing = Reference(np.zeros((1, 0)), np.zeros((1, 0)))
    problem = BoundaryValueProblem(field, 1, 1, ends, None, MESH, nothing, np.ones(2))
    unknowns, row = np.full(len(MESH.nodes) + 1, 3.0), np.zeros(len(MESH.nodes) + 1)
    row[-1] = 1.0
    with failed("no-convergence"):
        Curve(problem).start(unknowns, row)
    found, steps = solve_across_row(problem, unknowns, row, -1, 25, 1e-10)
    np.testing.assert_allclose(found[:-1], 0, atol=1e-12)
    assert found[-1] == 3.0 and 2 < steps < 12
    with failed("too-many-steps", "2"):
        solve_across_row(problem, unknowns, row, -1, 2, 1e-10)


U, V, L, P = sp.symbols("u v load p", real=True)
BRATU = System((U, V), (V, -L * sp.exp(U)), (L,))
"""u'' + load e^u = 0. G. Bratu, Bull. Soc. Math. France 42 (1914) 113-142; AUTO-07p's demo exp.

With u(0) = u(1) = 0, u = -2 ln(cosh(theta (t - 1/2)/2)/cosh(theta/4)), theta = sqrt(2 load) cosh(theta/4).
"""


def highest_of_load(load: float, bracket: tuple[float, float]) -> float:
    theta = brentq(lambda t: t - np.sqrt(2 * load) * np.cosh(t / 4), *bracket, xtol=1e-14)
    return float(2 * np.log(np.cosh(theta / 4)))


def test_bratus_problem_through_its_fold() -> None:
    solutions = Solutions(BoundaryValueProblem.of(BRATU, ["load"], {}, [start_value(U), end_value(U)]), [(0.1, 4.0)], [1.0])
    walk = solutions.walk(solutions.start([0, 1], [[0, 0], [0, 0]], [0.1]))
    points = list(walk)
    one, fold, other = [s for s in points if s.kind]
    assert [s.kind for s in (one, fold, other)] == ["value", "fold", "value"]
    assert one.states_at([0.5])[0] == pytest.approx(highest_of_load(1.0, (1.0, 2.0)), abs=1e-9)
    assert other.states_at([0.5])[0] == pytest.approx(highest_of_load(1.0, (8.0, 14.0)), abs=1e-9)
    # The digits.
    assert [s.states_at([0.5])[0, 0] for s in (one, other)] == pytest.approx([0.1405392144, 4.0914672462], abs=5e-11)
    assert [s.parameter_values[0] for s in (one, other)] == pytest.approx([1.0, 1.0], abs=1e-10)
    # (theta/4) tanh(theta/4) = 1 there, load = theta^2/2/cosh(theta/4)^2.
    quarter = brentq(lambda t: t * np.tanh(t) - 1, 1.0, 1.5, xtol=1e-15)
    assert fold.parameter_values[0] == pytest.approx(8 * (quarter / np.cosh(quarter)) ** 2, abs=1e-10)
    assert fold.parameter_values[0] == pytest.approx(3.513830719, abs=5e-10)
    assert "leaves the range" in walk.end and len(points) < 60
    theta = brentq(lambda t: t - np.sqrt(2.0) * np.cosh(t / 4), 8.0, 14.0, xtol=1e-14)
    t = np.linspace(0, 1, 101)
    exact = -2 * np.log(np.cosh(theta * (t - 0.5) / 2) / np.cosh(theta / 4))
    np.testing.assert_allclose(other.states_at(t)[0], exact, atol=1e-8)
    assert other.error < 1e-8 and other.states.shape == (2, len(other.tau))
    assert solutions.backwards(one).point.tangent[-1] == -one.point.tangent[-1]


def test_a_parameter_that_is_found_with_the_solution() -> None:
    """u'' = -p u, u(0) = u(1) = 0, u'(0) = load: p = pi^2 for each load, u = load/pi sin(pi t)."""
    system = System((U, V), (V, -P * U), (P, L))
    problem = BoundaryValueProblem.of(
        system, ["p", "load"], {}, [start_value(U), end_value(U), start_value(V) - L], scale={"p": 10.0}
    )
    solutions = Solutions(problem, [(0.0, 20.0), (0.5, 2.0)], [1.5])
    t = np.linspace(0, 1, 11)
    walk = solutions.walk(solutions.start(t, [4 * t * (1 - t), 4 - 8 * t], [9.0, 1.0]))
    (wanted,) = [s for s in walk if s.kind]
    assert wanted.parameter_values == pytest.approx([np.pi**2, 1.5], abs=1e-8)
    np.testing.assert_allclose(wanted.states_at(t)[0], 1.5 / np.pi * np.sin(np.pi * t), atol=1e-8)


def test_what_is_no_problem_is_refused() -> None:
    with rejected("count", "2", "1"):
        BoundaryValueProblem.of(BRATU, ["load"], {}, [start_value(U)])
    with rejected("unknown-name", "u", "start_value", "end_value"):
        BoundaryValueProblem.of(BRATU, ["load"], {}, [start_value(U), U])
    solutions = Solutions(BoundaryValueProblem.of(BRATU, ["load"], {}, [start_value(U), end_value(U)]), [(0.0, 4.0)])
    with rejected("shape", "2"):
        solutions.start([0, 1], [[0, 0]], [0.1])


@pytest.mark.parametrize("size", [1e6, 1e-6])
def test_what_is_left_counts_by_the_size_of_the_unknowns(size: float) -> None:
    """y' = 0, y(0)^2 = 4: from 3 size on in as many steps whatever the size is."""

    def field(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros((1, u.shape[1])), np.zeros((1, 2, u.shape[1]))

    def ends(first: np.ndarray, _: np.ndarray, __: np.ndarray) -> EndValues:
        return (first / size) ** 2 - 4, np.array([2 * first / size**2]), np.zeros((1, 1)), np.zeros((1, 1))

    nothing = Reference(np.zeros((1, 0)), np.zeros((1, 0)))
    problem = BoundaryValueProblem(field, 1, 1, ends, None, MESH, nothing, np.array([size, 1.0]))
    unknowns, row = np.append(np.full(len(MESH.nodes), 3.0 * size), 1.0), np.zeros(len(MESH.nodes) + 1)
    row[-1] = 1.0
    unknowns, steps = solve_across_row(problem, unknowns, row, -1, 25, 1e-6)
    assert unknowns[:-1] == pytest.approx(2.0 * size, rel=1e-9) and steps == 4


def test_values_within_one_step_come_in_the_order_of_the_curve() -> None:
    problem = BoundaryValueProblem.of(BRATU, ["load"], {}, [start_value(U), end_value(U)])
    solutions = Solutions(problem, [(0.1, 3.0)], [1.001, 1.0])
    walk = solutions.walk(solutions.start([0, 1], [[0, 0], [0, 0]], [0.1]))
    assert [s.parameter_values[0] for s in walk if s.kind == "value"] == pytest.approx([1.0, 1.001], abs=1e-10)
