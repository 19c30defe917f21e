"""Newton's method for boundary value problems: from far away, and where there is nothing to be found."""

from __future__ import annotations

import numpy as np
import pytest
from tests.refusals import failed

from wucht.numerics.collocation.boundary_values import BoundaryValueProblem, EndValues, Reference
from wucht.numerics.collocation.damped import solved
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.curve import Curve

MESH = Mesh.even(20, 4)


def bratu(load: float) -> tuple[BoundaryValueProblem, np.ndarray]:
    """y'' = -load exp(y), y(0) = y(1) = 0: two solutions below the load 3.513830719, none above. The row keeps the load."""

    def field(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        zero, one, grown = np.zeros_like(u[0]), np.ones_like(u[0]), np.exp(np.minimum(u[0], 50.0))
        return np.array([u[1], -u[2] * grown]), np.array([[zero, one, zero], [-u[2] * grown, zero, -grown]])

    def ends(first: np.ndarray, last: np.ndarray, _: np.ndarray) -> EndValues:
        begin, end = np.zeros((2, 2)), np.zeros((2, 2))
        begin[0, 0] = end[1, 0] = 1.0
        return np.array([first[0], last[0]]), begin, end, np.zeros((2, 1))

    nothing = Reference(np.zeros((2, 0)), np.zeros((2, 0)))
    problem = BoundaryValueProblem(field, 2, 1, ends, None, MESH, nothing, np.ones(3))
    row = np.zeros(2 * len(MESH.nodes) + 1)
    row[-1] = 1.0
    return problem, row


def start(height: float, load: float) -> np.ndarray:
    t = MESH.nodes
    return np.append(np.column_stack([4 * height * t * (1 - t), 4 * height * (1 - 2 * t)]).ravel(), load)


def highest(theta: float) -> float:
    """Of y = -2 ln(cosh(theta (t - 1/2)/2)/cosh(theta/4))."""
    return float(2 * np.log(np.cosh(theta / 4)))


@pytest.mark.parametrize(("height", "theta"), [(0.0, 1.5171645990507543), (5.0, 10.93870277206211)])
def test_both_solutions_of_bratu(height: float, theta: float) -> None:
    """Load 1: theta = sqrt(2 load) cosh(theta/4)."""
    assert theta == pytest.approx(np.sqrt(2) * np.cosh(theta / 4), rel=1e-9)
    problem, row = bratu(1.0)
    u, steps = solved(problem, start(height, 1.0), row, -1, 25, 1e-10)
    assert problem.split(u)[0][:, 0].max() == pytest.approx(highest(theta), rel=1e-6)
    assert u[-1] == 1.0 and steps < 12
    assert np.abs(problem.residual(u)[0]).max() < 1e-9


def test_from_where_whole_steps_go_astray() -> None:
    """y' = 0, arctan y(0) = 0: from y = 1.392 on whole steps of Newton's method grow."""

    def field(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros((1, u.shape[1])), np.zeros((1, 2, u.shape[1]))

    def ends(first: np.ndarray, _: np.ndarray, __: np.ndarray) -> EndValues:
        return np.arctan(first), np.array([1 / (1 + first**2)]), np.zeros((1, 1)), np.zeros((1, 1))

    nothing = Reference(np.zeros((1, 0)), np.zeros((1, 0)))
    problem = BoundaryValueProblem(field, 1, 1, ends, None, MESH, nothing, np.ones(2))
    u, row = np.full(len(MESH.nodes) + 1, 3.0), np.zeros(len(MESH.nodes) + 1)
    row[-1] = 1.0
    with failed("no-convergence"):
        Curve(problem).start(u, row)
    found, steps = solved(problem, u, row, -1, 25, 1e-10)
    np.testing.assert_allclose(found[:-1], 0, atol=1e-12)
    assert found[-1] == 3.0 and 2 < steps < 12
    with failed("too-many-steps", "2"):
        solved(problem, u, row, -1, 2, 1e-10)


def test_where_there_is_none_it_is_told() -> None:
    problem, row = bratu(4.0)
    with failed("no-convergence"):
        solved(problem, start(1.0, 4.0), row, -1, 40, 1e-10)
