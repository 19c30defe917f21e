"""The motion that a milled cam makes: from the points of a contour to the motion of the follower that touches them.

It does not use the law the cam was made for, so it verifies the contour independently.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from wucht.errors import InputError

_DEGREE = 5  # of the spline through the points
_FEWEST = 2 * _DEGREE
MOST_STEPS = 40
EXACT = 1e-14  # of the cam's size: tolerance of a contact


class ContourFollower(Protocol):
    """A follower that touches a contour."""

    def place(self, value: np.ndarray) -> np.ndarray:
        """Return the position of its roller or face for a value of the law (any shape), complex or along x, in m."""
        ...

    def motion_on(self, contour: MilledContour, rotation: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """Return the value of its motion (K,) on a contour rotated by e^(i angle) (K,), near a guess (K,).

        Raises ``RunError`` where it does not touch near that.
        """
        ...


@dataclass(frozen=True, eq=False)
class MilledContour:
    """The contour through points (M,), complex in m, in order and the first not repeated.

    Raises ``InputError`` (points): too few of them.
    """

    points: np.ndarray

    def __post_init__(self) -> None:
        if len(self.points) < _FEWEST:
            raise InputError("points", len(self.points), f"a contour needs at least {_FEWEST} points")

    @cached_property
    def _spline(self) -> Any:
        """The periodic spline through the points over their numbers."""
        from scipy.interpolate import make_interp_spline

        closed_points = np.append(self.points, self.points[0])
        plane = np.column_stack([closed_points.real, closed_points.imag])
        return make_interp_spline(np.arange(len(closed_points)), plane, _DEGREE, bc_type="periodic")

    def __call__(self, at: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of the contour by the number of the point, complex."""
        x, y = self._spline(at, order, extrapolate="periodic").T
        return np.asarray(x + 1j * y)

    def nearest(self, places: np.ndarray) -> np.ndarray:
        """The number of the point nearest to each place (K,)."""
        from scipy.spatial import cKDTree

        points, targets = (np.column_stack([x.real, x.imag]) for x in (self.points, places))
        return np.asarray(cKDTree(points).query(targets)[1], float)


def milled_motion(
    points: np.ndarray, follower: ContourFollower, phi: np.ndarray, guess: np.ndarray, clockwise: bool = False
) -> np.ndarray:
    """Return the motion that a cam makes with a contour through points, at cam angles (K,).

    points (M,): complex in m, in order and the first not repeated. guess: an approximate motion (K,). clockwise: the sense in
    which the cam turns. Raises ``InputError`` (points): too few of them; ``RunError`` where there is no contact near the guess.
    """
    return follower.motion_on(MilledContour(points), np.exp((1j if clockwise else -1j) * phi), guess)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The scalar product of vectors in the complex plane."""
    return np.asarray((np.conj(a) * b).real)
