"""From samples of an orbit to a solution of its boundary value problem on a mesh that suits it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.problem import CurvePoint

_INTERVALS, _MOST_REFINEMENTS = 40, 6
_FINE = 20_001
_EXACT = 1e-10  # Newton's tolerance, where points are located


def sampled(times: np.ndarray, states: np.ndarray, sizes: np.ndarray, degree: int) -> tuple[Mesh, np.ndarray]:
    """A mesh as fine as the states change fast, and their values at its nodes (K', n), by a cubic spline.

    times (K,), increasing, states (n, K), sizes (n,): by how much each changes when it changes much.
    """
    from scipy.interpolate import CubicSpline

    samples = CubicSpline((times - times[0]) / (times[-1] - times[0]), states.T)
    fine = np.linspace(0.0, 1.0, _FINE)
    speed = np.linalg.norm(np.diff(samples(fine), axis=0) / sizes, axis=1)
    # What does not change at all asks for an even mesh.
    grown = np.insert(np.cumsum(speed + (0.5 * speed.mean() or 1.0)), 0, 0.0)
    mesh = Mesh(np.interp(np.linspace(0.0, grown[-1], _INTERVALS + 1), grown, fine), degree)
    return mesh, samples(mesh.nodes)


def solved_near(curve: Curve, u: np.ndarray, towards: np.ndarray | None = None) -> tuple[Curve, CurvePoint]:
    """The solution near u, and the curve on a mesh that suits it.

    curve: of a boundary value problem, on the mesh of u. towards: the direction, of all unknowns, in the plane across which it
    lies, and in which the curve goes on; else that of the last parameter, which then is kept. Raises ``RunError`` where none is
    found.
    """
    if towards is None:
        towards = np.zeros(len(u))
        towards[-1] = 1.0
    for refinement in range(_MOST_REFINEMENTS + 1):
        problem = curve.problem
        assert isinstance(problem, BoundaryValueProblem)
        curve = replace(curve, problem=replace(problem, reference=problem.referred(u)))
        point = curve.start(u, towards)
        better = problem.remeshed(point.u)
        if better.mesh is problem.mesh or refinement == _MOST_REFINEMENTS:
            break
        u, towards = problem.moved(np.stack([point.u, towards], axis=1), better.mesh).T
        curve = replace(curve, problem=better)
    return curve, point


def tangent_near(problem: BoundaryValueProblem, u: np.ndarray) -> np.ndarray:
    """The direction in which the solutions near u go on, of all unknowns and with either sign. Raises ``RunError``."""
    sides = np.zeros((len(u), 1))
    sides[-1] = 1.0
    row = np.random.default_rng(0).normal(size=len(u)) / problem.scale  # not across the curve, as that of a fold would be
    return problem.solution(problem.residual(u)[1], row, sides)[0][:, 0]


def exactly(curve: Curve) -> Curve:
    """The same, Newton's method going on to rounding: for points that are asked for, not passed."""
    return replace(curve, steps=replace(curve.steps, tolerance=min(_EXACT, curve.steps.tolerance), foretold=False))


def refined(a: tuple[Curve, CurvePoint], b: tuple[Curve, CurvePoint], accuracy: float) -> tuple[Curve, CurvePoint, CurvePoint]:
    """Two neighbours of a curve as they are on one mesh, on which what lies between them can be located.

    a, b: with the curves on whose meshes they are. accuracy: see ``BoundaryValueProblem``; Newton's method goes on to rounding.
    Raises ``RunError`` where it fails.
    """
    curve, there = b
    problem = curve.problem
    assert isinstance(problem, BoundaryValueProblem)
    better = replace(problem, accuracy=min(accuracy, problem.accuracy)).remeshed(there.u)
    better = replace(better, reference=better.referred(problem.moved(there.u, better.mesh)))
    fine, found = exactly(replace(curve, problem=better)), list[CurvePoint]()
    for at, point in (a, b):
        known = at.problem
        assert isinstance(known, BoundaryValueProblem)
        u, tangent = known.moved(np.stack([point.u, point.tangent], axis=1), better.mesh).T
        found.append(fine.corrected(u, tangent, point.length)[0])
    return fine, found[0], found[1]
