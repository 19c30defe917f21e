"""A solution of a boundary value problem as a point of a curve of such."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.problem import CurvePoint


@dataclass(frozen=True, eq=False)
class Collocated:
    """A solution by collocation. curve: as it is followed, with the problem on the solution's mesh. point: of the curve."""

    curve: Curve
    point: CurvePoint

    @property
    def problem(self) -> BoundaryValueProblem:
        """The boundary value problem on the solution's mesh."""
        assert isinstance(self.curve.problem, BoundaryValueProblem)
        return self.curve.problem

    @property
    def tau(self) -> np.ndarray:
        """Where the states are kept (K,), from 0 to 1: in shares of the period, or of the time."""
        return self.problem.mesh.nodes

    @property
    def states(self) -> np.ndarray:
        """There (n, K)."""
        return self.problem.split(self.point.u)[0].T

    def at(self, tau: np.ndarray) -> np.ndarray:
        """The states (n, K) at places (K,) of [0, 1]."""
        return self.problem.mesh.at(self.states.T, np.asarray(tau, float)).T
