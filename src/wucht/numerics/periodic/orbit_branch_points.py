"""Branch points of periodic orbits, where two branches cross, and the directions of both.

There the equations F(X) = 0 lack a rank. With a gap beta l left open, y(1) - y(0) - 2 pi winding = beta l, they have it, and
their solutions form a surface on which beta is a smooth function of two coordinates. Its contour beta = 0 are both branches;
they cross at its saddle point, to which Newton's method converges to rounding: unlike on a branch nothing is singular there.
E. L. Allgower, K. Georg, "Numerical Continuation Methods", Springer 1990, section 8.3 (unfolding); W. Govaerts, "Numerical
Methods for Bifurcations of Dynamical Equilibria", SIAM 2000, section 4.1 (the algebraic branching equation).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.errors import RunError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem, EndValues, Reference
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.equations import CurvePoint

_CROSSING = 1e-7  # of beta, in units of the states' sizes: branches that pass one another more closely cross
_STEP = 1e-4  # arclength: of central differences of the slopes of beta, which are right to about 1e-10
_TOLERANCE = 1e-11  # of both coordinates, arclengths
_MOST_STEPS = 60  # evaluations
_FARTHEST = 1.0  # of the way between both neighbours: largest distance of a branch point beyond either


@dataclass(frozen=True, eq=False)
class _Surface:
    """Surface of solutions with an open gap near one of them, by two coordinates: arclengths along two directions.

    curve: of orbits. problem_at: the equations with beta as first parameter, at a second coordinate. origin: unknowns, beta.
    directions (2, len(origin)).
    """

    curve: Curve
    problem_at: Callable[[float], BoundaryValueProblem]
    origin: np.ndarray
    directions: np.ndarray

    @classmethod
    def from_point(cls, curve: Curve, point: CurvePoint) -> _Surface:
        """Set up the surface near a point of a curve of orbits, whose equations are nearly singular there."""
        problem = curve.problem
        assert isinstance(problem, BoundaryValueProblem)
        n, length = problem.n, len(point.unknowns)
        collocation_rows = length - problem.q - n
        sides = np.zeros((length, n))
        sides[collocation_rows : collocation_rows + n] = np.diag(problem.sizes[:n])
        # A nearly singular matrix answers any gap in one direction, and one gap most strongly.
        answers = problem.solution(point.jacobian, point.tangent / problem.scale**2, sides)[0] / problem.scale[:, None]
        left_vectors, _, right_vectors = np.linalg.svd(answers, full_matrices=False)
        second_direction, gap = left_vectors[:, 0] * problem.scale, right_vectors[0] * problem.sizes[:n]
        directions = np.stack([_with_gap(problem, point.tangent), _with_gap(problem, second_direction)])
        return cls(
            curve,
            partial(_unfolded_problem, problem, gap, point.unknowns, second_direction),
            _with_gap(problem, point.unknowns),
            directions,
        )

    def solution_at(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the solution at a place (2,) and its derivatives by both coordinates (2, k). Raises ``RunError``."""
        problem, along = self.problem_at(float(place[1])), self.directions[0]
        point, _ = replace(self.curve, problem=problem).correct(self.origin + place @ self.directions, along, 0.0)
        sides = np.zeros((len(point.unknowns), 2))
        sides[-1, 0] = sides[-2, 1] = 1.0
        return point.unknowns, problem.solution(problem.residual(point.unknowns)[1], along / problem.scale**2, sides)[0].T

    @property
    def gap_index(self) -> int:
        """Index of beta among the unknowns."""
        return len(self.origin) - 3


def orbit_branch_point(curve: Curve, near: CurvePoint, a: CurvePoint, b: CurvePoint) -> tuple[np.ndarray, np.ndarray, float]:
    """Locate the branch point between two neighbouring orbits of a branch.

    Parameters
    ----------
    curve : Curve
        Of orbits; its tolerance is that of the branch point.
    near : CurvePoint
        An orbit of it near the branch point, with the Jacobian there.
    a, b : CurvePoint
        The neighbours, on the same mesh.

    Returns
    -------
    unknowns : ndarray, (k,)
    tangents : ndarray, (2, k)
        Of the branch that was followed, and of the other.
    share : float
        Of the way to it.

    Raises
    ------
    RunError
        Where no two branches cross between them.
    """
    surface = _Surface.from_point(curve, near)
    place = _saddle_point(surface)
    with_gap, changes = surface.solution_at(place)
    i = surface.gap_index
    if not abs(with_gap[i]) < _CROSSING:
        raise RunError("there is no branch point: two branches pass one another")
    unknowns, way = np.delete(with_gap, i), b.unknowns - a.unknowns
    share = float((unknowns - a.unknowns) / curve.problem.scale @ (way / curve.problem.scale)) / curve.size(way) ** 2
    if not -_FARTHEST <= share <= 1 + _FARTHEST:
        raise RunError("no branch point was found between the two orbits")
    tangents = np.delete(_contours(surface, place) @ changes, i, axis=1)
    tangents /= np.array([[curve.size(t)] for t in tangents])
    along = tangents / curve.problem.scale @ (way / curve.problem.scale)
    order = np.argsort(-np.abs(along))
    return unknowns, (tangents * np.where(along < 0, -1.0, 1.0)[:, None])[order], share


def _saddle_point(surface: _Surface) -> np.ndarray:
    """Return the coordinates (2,) at which both slopes of beta vanish. Raises ``RunError``."""
    from scipy.optimize import root

    def slopes(place: np.ndarray) -> np.ndarray:
        return surface.solution_at(place)[1][:, surface.gap_index]

    options = {"xtol": _TOLERANCE, "eps": _STEP**2, "maxfev": _MOST_STEPS}
    solution = root(slopes, np.zeros(2), options=options)
    if not (solution.success or np.abs(solution.fun).max() < _TOLERANCE):
        raise RunError("no branch point was located: Newton's method does not converge")
    return np.asarray(solution.x)


def _contours(surface: _Surface, place: np.ndarray) -> np.ndarray:
    """Return the directions (2, 2) in both coordinates in which beta stays zero at its saddle point. Raises ``RunError``."""
    i, steps = surface.gap_index, _STEP * np.eye(2)
    second = np.array([surface.solution_at(place + h)[1][:, i] - surface.solution_at(place - h)[1][:, i] for h in steps]) / (
        2 * _STEP
    )
    a, b, c = second[0, 0], (second[0, 1] + second[1, 0]) / 2, second[1, 1]
    inside = b * b - a * c
    if not inside > 0:
        raise RunError("no two branches cross here: this is not a simple branch point")
    # a s^2 + 2 b s x + c x^2 = 0, each root by the formula that does not cancel.
    q = -(b + math.copysign(math.sqrt(inside), b))
    return np.array([(q, a), (c, q)])


def _with_gap(problem: BoundaryValueProblem, unknowns: np.ndarray) -> np.ndarray:
    """Insert a zero gap as the first of three parameters into unknowns, or a change of them."""
    return np.insert(unknowns, len(unknowns) - problem.q, 0.0)


def _unfolded_problem(
    problem: BoundaryValueProblem, gap: np.ndarray, unknowns: np.ndarray, direction: np.ndarray, coordinate: float
) -> BoundaryValueProblem:
    """Return the equations with an open gap (n,), scaled by the first parameter, at a distance from unknowns in a direction."""
    n, q, mesh = problem.n, problem.q, problem.mesh
    sizes = np.insert(problem.sizes, n, 1.0)
    (y, parameters), (change, changes) = problem.split(unknowns), problem.split(direction)
    y, change = ((mesh.basis.values @ mesh.pieces(node_values)).reshape(-1, n).T for node_values in (y, change))
    weighted_change, by_parameters = change / sizes[:n, None] ** 2, np.insert(changes / problem.sizes[n:] ** 2, 0, 0.0)
    base_parameters, phase = np.insert(parameters, 0, 0.0), problem.integrand
    assert phase is not None

    def field(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        g, derivatives = problem.field(np.delete(values, n, axis=0))
        return g, np.insert(derivatives, n, 0.0, axis=1)

    def ends(first: np.ndarray, last: np.ndarray, parameters: np.ndarray) -> EndValues:
        b, begin, end, by = problem.ends(first, last, parameters[1:])
        return b - parameters[0] * gap, begin, end, np.column_stack([-gap, by])

    def integrand(
        states: np.ndarray, parameters: np.ndarray, reference: Reference
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        h, by_states, by = phase(states, parameters[1:], reference)
        away = ((states - y) * weighted_change).sum(axis=0) + (parameters - base_parameters) @ by_parameters - coordinate
        row = np.broadcast_to(by_parameters[:, None], (q + 1, states.shape[1]))
        return (
            np.concatenate([h, away[None]]),
            np.concatenate([by_states, weighted_change[None]]),
            np.concatenate([np.insert(by, 0, 0.0, axis=1), row[None]]),
        )

    return replace(problem, field=field, q=q + 1, ends=ends, integrand=integrand, sizes=sizes)
