"""Prediction of the next orbit of a branch that follows the places where the orbit changes fast as they move in its period.

An orbit that waits long at some places changes fast in between. The waits change along the branch, and with them the instants
of the fast parts in tau = t/T. The tangent is a sum xi y' + v of a shift xi(tau) along the orbit and the rest v: each place of
the orbit is moved in tau by -step xi, and its states are changed by step v.
"""

from __future__ import annotations

import numpy as np

from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.continuation.equations import CurvePoint, Problem

_SLOW = 0.05  # of the mean square of the speed: where the orbit is slower, the tangent is no shift along it
_INVERSIONS = 3  # steps of the fixed point iteration for the place that is moved to a node


def predicted_orbit(problem: Problem, here: CurvePoint, step: float) -> np.ndarray:
    """Return a guess of the unknowns of the orbit a step farther along the curve.

    Parameters
    ----------
    problem : BoundaryValueProblem
        Of a periodic orbit.
    here : CurvePoint
        An orbit, with its tangent.
    step : float
        Length along the curve.
    """
    assert isinstance(problem, BoundaryValueProblem) and problem.winding is not None
    mesh, weights, winding = problem.mesh, 1 / problem.sizes[: problem.n] ** 2, problem.winding
    (y, parameters), (change, by_parameters) = problem.split(here.unknowns), problem.split(here.tangent)
    slopes = mesh.slopes(y)
    squares = (slopes**2 * weights).sum(axis=1)
    shift = (change * slopes * weights).sum(axis=1) / (squares + _SLOW * (squares @ mesh.shares))
    shift[-1] = shift[0]
    states = y + step * (change - shift[:, None] * slopes)
    places = mesh.nodes
    for _ in range(_INVERSIONS):
        places = mesh.nodes + step * mesh.interpolate(shift[:, None], places % 1.0)[:, 0]
    turns = np.floor(places)
    guess = mesh.interpolate(states, places - turns) + turns[:, None] * winding
    guess[-1] = guess[0] + winding
    return np.concatenate([guess.ravel(), parameters + step * by_parameters])
