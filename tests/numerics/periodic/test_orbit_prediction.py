"""Orbits a step farther on: shifted along themselves where they change fast, at the place to which that moves."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.equations import CurvePoint
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.orbit_prediction import predicted_orbit
from wucht.system import System

X, Y, P = sp.symbols("x y p", real=True)
MESH = Mesh.even(60, 6)


def problem_of(system: System, winding: dict[str, int] | None = None) -> BoundaryValueProblem:
    return Cycles.of(system, "p", {}, (-1.0, 1.0), winding=winding).problem(MESH, 1.0)


def point(states: np.ndarray, change: np.ndarray, parameters: tuple[float, float], by: tuple[float, float]) -> CurvePoint:
    return CurvePoint(np.append(states.ravel(), parameters), np.append(change.ravel(), by), None, 0.0, 0)


def test_a_front_moves_as_far_as_the_tangent_says_and_keeps_its_shape() -> None:
    """A turn within a fiftieth of the period, moved by that width: along the tangent it would not be monotone any more."""
    problem = problem_of(System((X,), (P + sp.cos(X),), (P,), angles=frozenset({X})), {"x": 1})
    tau, width = MESH.nodes, 0.02

    def front(at: float) -> np.ndarray:
        return np.pi * (1 + np.tanh((tau - at) / width))[:, None]

    here, step = front(0.5), 0.01
    change = -MESH.slopes(here)  # by one unit of the curve's length the front moves by one period
    here[-1] = here[0] + 2 * np.pi
    unknowns = predicted_orbit(problem, point(here, change, (7.0, 0.1), (2.0, -1.0)), step)
    states, parameters = problem.split(unknowns)
    assert parameters == pytest.approx([7.02, 0.09], abs=1e-14)
    assert states[-1] - states[0] == pytest.approx(2 * np.pi, abs=1e-12)
    off, off_tangent = (float(np.abs(guess - front(0.51)).max()) for guess in (states, here + step * change))
    assert off < off_tangent / 5


def test_states_that_change_without_a_shift_are_those_of_the_tangent() -> None:
    """A circle that grows."""
    problem = problem_of(System((X, Y), (P * X - Y, X + P * Y), (P,)))
    angle = 2 * np.pi * MESH.nodes
    circle = np.array([np.cos(angle), np.sin(angle)]).T
    states, _ = problem.split(predicted_orbit(problem, point(circle, circle, (1.0, 0.0), (0.0, 0.0)), 0.3))
    np.testing.assert_allclose(states, 1.3 * circle, atol=1e-9)


def test_a_circle_that_turns_stays_a_circle() -> None:
    problem = problem_of(System((X, Y), (P * X - Y, X + P * Y), (P,)))
    angle = 2 * np.pi * MESH.nodes
    circle = np.array([np.cos(angle), np.sin(angle)]).T
    states, _ = problem.split(predicted_orbit(problem, point(circle, circle @ [[0, 1], [-1, 0]], (1.0, 0.0), (0.0, 0.0)), 0.3))
    assert np.linalg.norm(states, axis=1) == pytest.approx(1.0, abs=2e-3)  # along the tangent: 1.044
