"""What a milled cam does: from the points of a contour to the motion of the follower that touches them.

It knows nothing of the law the cam was made for, so that it proves what was made.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wucht.cams.followers import FlatFaced, RollerFollower
from wucht.errors import InputError, RunError

_DEGREE = 5  # of the spline through the points
_FEWEST = 2 * _DEGREE
_MOST_STEPS = 40
_EXACT = 1e-14  # of the cam's size


@dataclass(frozen=True, eq=False)
class MilledCam:
    """A cam with a contour through points (M,), complex in m, in order and the first not repeated.

    follower: what runs on it. clockwise: the sense in which the cam turns. Raises ``InputError`` (points): too few of them.
    """

    points: np.ndarray
    follower: RollerFollower | FlatFaced
    clockwise: bool = False

    def __post_init__(self) -> None:
        if len(self.points) < _FEWEST:
            raise InputError("points", len(self.points), f"a contour needs at least {_FEWEST} points")

    @cached_property
    def _spline(self) -> Any:
        """The periodic spline through the points over their numbers."""
        from scipy.interpolate import make_interp_spline

        closed = np.append(self.points, self.points[0])
        plane = np.column_stack([closed.real, closed.imag])
        return make_interp_spline(np.arange(len(closed)), plane, _DEGREE, bc_type="periodic")

    def _contour(self, at: np.ndarray, order: int) -> np.ndarray:
        """The derivative of the contour by the number of the point, complex."""
        x, y = self._spline(at, order, extrapolate="periodic").T
        return np.asarray(x + 1j * y)

    def motion(self, phi: np.ndarray, nearly: np.ndarray) -> np.ndarray:
        """The value of the follower's motion at cam angles (K,).

        nearly: about what it is (K,), for the contact that is looked for. Raises ``RunError`` where there is none near it.
        """
        turned = np.exp((1j if self.clockwise else -1j) * phi)
        if isinstance(self.follower, FlatFaced):
            return self._of_flat_face(self.follower, turned, nearly)
        return self._of_roller(self.follower, turned, nearly)

    def _of_roller(self, follower: RollerFollower, turned: np.ndarray, nearly: np.ndarray) -> np.ndarray:
        """The roller is at its radius from the contour, and that along the normal: Newton's method in both unknowns."""
        moved, at = np.array(nearly, float), self._nearest(turned * follower.place(nearly))
        size = float(np.abs(self.points).max())
        for _ in range(_MOST_STEPS):
            c, c1, c2 = (self._contour(at, k) for k in (0, 1, 2))
            off, rate = turned * follower.place(moved) - c, turned * follower.rate(moved)
            gap = np.abs(off) - follower.roller_radius
            along = _dot(c1, off)
            gap_moved, gap_at = _dot(off, rate) / np.abs(off), -along / np.abs(off)
            along_moved, along_at = _dot(c1, rate), _dot(c2, off) - np.abs(c1) ** 2
            determinant = gap_moved * along_at - gap_at * along_moved
            moved = moved - (gap * along_at - gap_at * along) / determinant
            at = at - (gap_moved * along - gap * along_moved) / determinant
            if np.abs(gap).max() <= _EXACT * size:
                return np.asarray(moved)
        raise RunError("the follower does not touch the contour near the motion that was expected")

    def _of_flat_face(self, follower: FlatFaced, turned: np.ndarray, nearly: np.ndarray) -> np.ndarray:
        """The face is where the contour reaches furthest."""
        foot = turned * (follower.distance + nearly)
        at = np.argmax((turned.conj()[:, None] * self.points[None, :]).real, axis=1).astype(float)
        for _ in range(_MOST_STEPS):
            c1, c2 = (self._contour(at, k) for k in (1, 2))
            step = _dot(turned, c1) / _dot(turned, c2)
            at = at - step
            if np.abs(step).max() <= _EXACT * len(self.points):
                return np.asarray(_dot(turned, self._contour(at, 0)) - follower.distance)
        raise RunError(f"the face does not touch the contour near {np.abs(foot).max():.3g} m from its centre")

    def _nearest(self, places: np.ndarray) -> np.ndarray:
        """The number of the point nearest to each place (K,)."""
        from scipy.spatial import cKDTree

        points, wanted = (np.column_stack([x.real, x.imag]) for x in (self.points, places))
        return np.asarray(cKDTree(points).query(wanted)[1], float)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The scalar product of vectors in the complex plane."""
    return np.asarray((np.conj(a) * b).real)
