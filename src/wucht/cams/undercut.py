"""Arcs of a cam's contour that are cut away, and the curvature of the rest.

Locally a contour folds where the pitch curve is bent more sharply than the roller. But the roller may also, while it runs
elsewhere, cut into a part that is finished. Both are one question to the pitch curve: how large is the largest ball that
touches it at p, on the side of the contour, and holds no other point of it? Through another point q of the curve passes
the ball of radius |q - p|^2/(2 m . (q - p)), m being the normal to that side; towards q = p this is the radius of curvature.
The contour of p is missing where the least of these over q is less than the roller's radius. (The shrinking ball: J. Ma,
S. W. Bae, S. Choi, The Visual Computer 28 (2012) 7-19.) The same ball on the other side of a contour is the largest wheel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wucht.numerics.angles import GRID, STEP, TURN, Arc, refine_minima, valleys
from wucht.numerics.zeros_and_peaks import RealFunction

NEAREST = 16  # golden sections of two steps: to 1e-6 rad, and what is least to the square of it
_SHRINKINGS = 60  # at most; a few are enough
_STRAIGHT_EDGE = 1e4  # diameters of the curve: a ball so large is a straight edge, and sets no limit
_BETWEEN = 1.02  # times the smallest ball: those at the angles of the grid beside it are no larger
_LEAF = 128  # points that the tree compares one by one: from the centre of a ball many are about as far
EDGE = 1e-12  # of 1: so little is left at an edge
_STRAIGHT = 1e-9  # 1/diameter of the curve: less is no curvature


@dataclass(frozen=True)
class RadiusAt:
    """radius: in m. phi: the cam angle in rad."""

    radius: float
    phi: float


@dataclass(frozen=True)
class CutAway:
    """Contour that a roller or a face leaves.

    undercut: arcs of the cam angle, (begin, end) in rad, on which the contour runs backwards. missing: arcs on which it is cut
    away, by the roller next to it (they hold those of ``undercut``) or elsewhere. convex, hollow: the least radius of curvature
    of the rest where its material bulges and where it is hollow, None where it is nowhere; beside arcs that are missing
    there is an edge besides. largest_roller: in m, with which nothing would be missing; infinite where every roller fits,
    or there is a face.
    """

    undercut: tuple[Arc, ...]
    missing: tuple[Arc, ...]
    convex: RadiusAt | None
    hollow: RadiusAt | None
    largest_roller: float

    def is_missing(self, phi: np.ndarray) -> np.ndarray:
        """Return True where the contour is cut away, at cam angles (N,)."""
        return is_on_arcs(self.missing, phi)

    @property
    def remote_arcs(self) -> tuple[Arc, ...]:
        """Missing arcs without undercut: the roller cuts into them from other cam angles alone."""
        folds = np.array([begin for begin, _ in self.undercut])
        return tuple(arc for arc in self.missing if not is_on_arcs((arc,), folds).any())


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a closed curve. curve: complex in m over phi. normal: of modulus 1, to that side. bend: the curvature,
    positive where the curve bends to that side; all (N,) -> (N,)."""

    curve: Callable[[np.ndarray], np.ndarray]
    normal: Callable[[np.ndarray], np.ndarray]
    bend: RealFunction

    @cached_property
    def _samples(self) -> tuple[np.ndarray, float, Any]:
        from scipy.spatial import cKDTree

        points = self.curve(GRID)
        widest = _STRAIGHT_EDGE * 2 * float(np.abs(points - points.mean()).max())
        return points, widest, cKDTree(plane_coordinates(points), _LEAF)

    def limit(self, ball: float) -> float:
        """Return the radius of a ball as a limit: infinite where the ball is a straight edge."""
        return ball if ball < self._samples[1] * (1 - EDGE) else math.inf

    def tightest(self) -> RadiusAt | None:
        """Return the least of the largest balls, None where none is a limit."""
        at, balls = self.narrowest()
        k = int(np.argmin(balls))
        return RadiusAt(float(balls[k]), float(at[k])) if math.isfinite(self.limit(float(balls[k]))) else None

    def largest_ball(self, phi: np.ndarray) -> np.ndarray:
        """Return the radius in m (N,) of the largest ball that touches the curve at phi (N,) and holds no other point of it; at
        most that of a straight edge."""
        points, widest, tree = self._samples
        at, normal, bend = self.curve(phi), self.normal(phi), self.bend(phi)
        radius = 1 / np.maximum(bend, 1 / widest)
        contact_index, k = np.full(len(phi), -1), np.arange(len(phi))
        for _ in range(_SHRINKINGS):
            _, j = tree.query(plane_coordinates(at[k] + radius[k] * normal[k]))
            smaller = _ball_radius(at[k], normal[k], points[j], np.abs(signed_angle(GRID[j] - phi[k])) > STEP / 2)
            shrinks = smaller < radius[k] * (1 - EDGE)
            k, j = k[shrinks], j[shrinks]
            if not len(k):
                break
            radius[k], contact_index[k] = smaller[shrinks], j
        k = np.flatnonzero(contact_index >= 0)
        if len(k):
            near = GRID[contact_index[k]]

            def ball_through(angle: np.ndarray) -> np.ndarray:
                apart = np.abs(signed_angle(angle - phi[k])) > STEP / 2
                return _ball_radius(at[k], normal[k], self.curve(angle), apart)

            radius[k] = np.minimum(radius[k], ball_through(refine_minima(ball_through, near - STEP, near + STEP, NEAREST)))
        return np.asarray(radius)

    def narrowest(self, radius: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return the angles of the smallest among the largest balls, and their radii; also minima below a radius."""
        balls = self.largest_ball(GRID)
        return valleys(self.largest_ball, balls, _BETWEEN * max(radius, float(balls.min())))


def _ball_radius(at: np.ndarray, normal: np.ndarray, point: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """Return the radius of the ball that touches at one point and passes through another; infinite where there is none."""
    chord = point - at
    depth = np.where(apart, (normal.conj() * chord).real, 0.0)
    return np.asarray(np.divide(np.abs(chord) ** 2, 2 * depth, out=np.full(len(at), np.inf), where=depth > 0))


def plane_coordinates(points: np.ndarray) -> np.ndarray:
    """Return complex points (N,) as rows x, y (N, 2)."""
    return np.column_stack([points.real, points.imag])


def signed_angle(angle: np.ndarray) -> np.ndarray:
    """Return an angle from -pi to pi."""
    return np.asarray(np.mod(angle + math.pi, TURN) - math.pi)


def is_on_arcs(arcs: tuple[Arc, ...], phi: np.ndarray) -> np.ndarray:
    """Return True where cam angles (N,) lie on one of several arcs."""
    inside = [np.mod(phi - begin, TURN) <= end - begin for begin, end in arcs]
    return np.asarray(np.any(inside, axis=0)) if inside else np.zeros(len(phi), bool)


def least_radius(curve: Callable[[np.ndarray], np.ndarray], bend: RealFunction) -> RadiusAt | None:
    """Return the least radius of a curve that bends by -bend, and its angle; None where it is nowhere bent."""
    at, bends = valleys(bend)
    k = int(np.argmin(bends))
    straight = -_STRAIGHT / np.abs(curve(GRID)).max()
    return RadiusAt(float(-1 / bends[k]), float(at[k])) if bends[k] < straight else None
