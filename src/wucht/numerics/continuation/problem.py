"""What is followed: n equations F(u) = 0 of n + 1 unknowns, whose solutions form a curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from wucht.errors import RunError

Residual = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""u (n+1,) -> F (n,), dF/du (n, n+1)."""


@dataclass(frozen=True, eq=False)
class CurvePoint:
    """A solution.

    u (n+1,): the unknowns, parameters last. tangent (n+1,): du/ds, s being the arclength. jacobian: dF/du, (n, n+1) or as the
    problem keeps it. length: s. orientation: the sign of the determinant of dF/du with the tangent as its last row. bend
    (n+1,): about d^2u/ds^2, where the point before is known.
    """

    u: np.ndarray
    tangent: np.ndarray
    jacobian: Any
    length: float
    orientation: int
    bend: np.ndarray | None = None


class Problem(Protocol):
    """F(u) = 0 as ``Curve`` needs it: functions of u alone.

    scale (n+1,): by how much each unknown changes when it changes much: the unit of arclength.
    """

    @property
    def scale(self) -> np.ndarray: ...  # noqa: D102

    def residual(self, u: np.ndarray) -> tuple[np.ndarray, Any]:
        """F (n,) and its Jacobian."""

    def solution(self, jacobian: Any, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
        """x (n+1, k) with [jacobian; row] x = sides (n+1, k), and the determinant's sign. Raises ``RunError`` if singular."""

    def renewed(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """The same equations as they are best written near a point, and the point as they have it."""

    def outline(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers by which two solutions are seen to be one, in units of their scale, and the period of those on a circle."""


def bordered_solution(jacobian: np.ndarray, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
    """``Problem.solution`` for a Jacobian that is a full matrix."""
    from scipy.linalg.lapack import dgesv

    matrix = np.empty((len(row), len(row)), order="F")
    matrix[:-1], matrix[-1] = jacobian, row
    factors, pivots, solved, failed = dgesv(matrix, sides, overwrite_a=1)
    if failed:
        raise RunError("the equations are singular here")
    changes = 0  # counted by hand: for a few unknowns three times as fast as arrays
    for i, (pivot, swapped) in enumerate(zip(factors.diagonal().tolist(), pivots.tolist(), strict=True)):
        changes += (pivot < 0) != (swapped != i)
    return solved, -1 if changes % 2 else 1


@dataclass(frozen=True, eq=False)
class Functions:
    """A problem given as a function.

    Parameters
    ----------
    given : callable
        u (n+1,) -> F (n,), dF/du (n, n+1).
    scale : ndarray, (n+1,)
        By how much each unknown changes when it changes much.
    turns : ndarray, (n+1,), optional
        The period of unknowns that are angles, 0 of others.
    """

    given: Residual
    scale: np.ndarray
    turns: np.ndarray | None = None
    solution: Callable[[Any, np.ndarray, np.ndarray], tuple[np.ndarray, int]] = field(default=bordered_solution, repr=False)

    def residual(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ``Problem``."""
        return self.given(u)

    def renewed(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """See ``Problem``: nothing changes."""
        return self, point

    def outline(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ``Problem``: the unknowns."""
        return u / self.scale, np.zeros(len(u)) if self.turns is None else self.turns / self.scale
