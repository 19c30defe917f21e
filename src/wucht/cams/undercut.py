"""Where the contour of a cam is cut away, and how sharply what remains is bent.

Locally a contour folds where the pitch curve is bent more sharply than the roller. But the roller may also, while it runs
elsewhere, cut into a part that is finished. Both are one question to the pitch curve: how large is the largest ball that
touches it at p, on the side of the contour, and holds no other point of it? Through another point q of the curve passes
the ball of radius |q - p|^2/(2 m . (q - p)), m being the normal to that side; towards q = p this is the radius of curvature.
The contour of p is missing where the least of these over q is less than the roller's radius. (The shrinking ball: J. Ma,
S. W. Bae, S. Choi, The Visual Computer 28 (2012) 7-19.) The same ball on the other side of a contour is the largest wheel.

A flat face leaves what lies behind it at all cam angles. The ball of radius r that touches the face from behind at the contour
point c of phi stays behind the face at psi, at the distance h(psi) from the cam's centre, where
r (1 - cos(psi - phi)) <= h(psi) - c . n(psi); towards psi = phi this is the radius of curvature. The contour of phi is missing
where the least of these r over psi is negative.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wucht.cams.cam import FlatFacedCam, RollerCam
from wucht.cams.followers import OscillatingRoller
from wucht.errors import InputError
from wucht.numerics.valleys import GRID, STEP, TURN, Arc, arcs_below_zero, narrowed, valleys
from wucht.numerics.zeros import RealFunction

_NEAREST = 16  # golden sections of two steps: to 1e-6 rad, and what is least to the square of it
_SHRINKINGS = 60  # at most; a few are enough
_STRAIGHT_EDGE = 1e4  # diameters of the curve: a ball so large is a straight edge, and sets no limit
_BETWEEN = 1.02  # times the smallest ball: those at the angles of the grid beside it are no larger
_LEAF = 128  # points that the tree compares one by one: from the centre of a ball many are about as far
_EDGE = 1e-12  # of 1: so little is left at an edge
_STRAIGHT = 1e-9  # 1/diameter of the curve: less is no curvature
_ROWS = 256  # cam angles at a time that are held against all faces

Written = Callable[[float], str]


@dataclass(frozen=True)
class RadiusAt:
    """radius: in m. phi: the cam angle in rad."""

    radius: float
    phi: float


@dataclass(frozen=True)
class CutAway:
    """What a roller or a face leaves of a contour.

    undercut: arcs of the cam angle, (begin, end) in rad, on which the contour runs backwards. missing: arcs on which it is cut
    away, by the roller next to it (they hold those of ``undercut``) or elsewhere. convex, hollow: the least radius of curvature
    of what is left where its material bulges and where it is hollow, None where it is nowhere; beside arcs that are missing
    there is an edge besides. largest_roller: in m, with which nothing would be missing; infinite where that holds of every
    roller, or there is a face.
    """

    undercut: tuple[Arc, ...]
    missing: tuple[Arc, ...]
    convex: RadiusAt | None
    hollow: RadiusAt | None
    largest_roller: float

    def is_missing(self, phi: np.ndarray) -> np.ndarray:
        """Whether the contour is cut away at cam angles (N,)."""
        return _within(self.missing, phi)

    @property
    def elsewhere(self) -> tuple[Arc, ...]:
        """Those missing arcs in which nothing is undercut: the roller cuts into them from another cam angle alone."""
        folds = np.array([begin for begin, _ in self.undercut])
        return tuple(arc for arc in self.missing if not _within((arc,), folds).any())


@dataclass(frozen=True, eq=False)
class _Side:
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
        return points, widest, cKDTree(_plane(points), _LEAF)

    def limit(self, ball: float) -> float:
        """The radius of a ball as a limit: infinite where the ball is a straight edge."""
        return ball if ball < self._samples[1] * (1 - _EDGE) else math.inf

    def tightest(self) -> RadiusAt | None:
        """The least of the largest balls, None where none is a limit."""
        at, balls = self.narrowest()
        k = int(np.argmin(balls))
        return RadiusAt(float(balls[k]), float(at[k])) if math.isfinite(self.limit(float(balls[k]))) else None

    def largest_ball(self, phi: np.ndarray) -> np.ndarray:
        """The radius in m (N,) of the largest ball that touches the curve at phi (N,) and holds no other point of it; at most
        that of a straight edge."""
        points, widest, tree = self._samples
        at, normal, bend = self.curve(phi), self.normal(phi), self.bend(phi)
        radius = 1 / np.maximum(bend, 1 / widest)
        touched, k = np.full(len(phi), -1), np.arange(len(phi))
        for _ in range(_SHRINKINGS):
            _, j = tree.query(_plane(at[k] + radius[k] * normal[k]))
            smaller = _ball(at[k], normal[k], points[j], np.abs(_wrapped(GRID[j] - phi[k])) > STEP / 2)
            shrinks = smaller < radius[k] * (1 - _EDGE)
            k, j = k[shrinks], j[shrinks]
            if not len(k):
                break
            radius[k], touched[k] = smaller[shrinks], j
        k = np.flatnonzero(touched >= 0)
        if len(k):
            near = GRID[touched[k]]

            def through(other: np.ndarray) -> np.ndarray:
                apart = np.abs(_wrapped(other - phi[k])) > STEP / 2
                return _ball(at[k], normal[k], self.curve(other), apart)

            radius[k] = np.minimum(radius[k], through(narrowed(through, near - STEP, near + STEP, _NEAREST)))
        return np.asarray(radius)

    def narrowest(self, radius: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Where the largest ball is smallest, and how large it is there; also where it has a minimum below a radius."""
        balls = self.largest_ball(GRID)
        return valleys(self.largest_ball, balls, _BETWEEN * max(radius, float(balls.min())))


def _ball(at: np.ndarray, normal: np.ndarray, through: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """The radius of the ball that touches at a point and passes through another one; infinite where there is none."""
    chord = through - at
    depth = np.where(apart, (normal.conj() * chord).real, 0.0)
    return np.asarray(np.divide(np.abs(chord) ** 2, 2 * depth, out=np.full(len(at), np.inf), where=depth > 0))


def _plane(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points.real, points.imag])


def _wrapped(angle: np.ndarray) -> np.ndarray:
    return np.asarray(np.mod(angle + math.pi, TURN) - math.pi)


def _within(arcs: tuple[Arc, ...], phi: np.ndarray) -> np.ndarray:
    inside = [np.mod(phi - begin, TURN) <= end - begin for begin, end in arcs]
    return np.asarray(np.any(inside, axis=0)) if inside else np.zeros(len(phi), bool)


def _material(cam: RollerCam) -> int:
    """The sign by which the curvature is positive where the material bulges."""
    return -1 if cam.outer else 1


def _roller_side(cam: RollerCam) -> _Side:
    sign = _material(cam)
    return _Side(cam.pitch, lambda phi: -sign * cam.normal(phi), lambda phi: sign * cam.pitch_curvature(phi))


def cut_away(cam: RollerCam) -> CutAway:
    """What is cut away of a cam, and the least radii of what is left.

    The curve is looked at at 4096 angles, and between them where it matters: what is cut away on less than 0.09 deg, by a
    depth of some (distance of the samples)^2/(8 r), tens of nanometres, may be missed.
    """
    side, radius, sign = _roller_side(cam), cam.follower.roller_radius, _material(cam)
    at, balls = side.narrowest(radius)
    missing = arcs_below_zero(lambda phi: side.largest_ball(phi) - radius, at) if balls.min() < radius else ()

    def bulge(phi: np.ndarray) -> np.ndarray:
        return np.where(_within(missing, phi), 0.0, sign * cam.curvature(phi))

    return CutAway(
        arcs_below_zero(lambda phi: cam.undercut(phi) - _EDGE),
        missing,
        _least_radius(cam.pitch, lambda phi: -bulge(phi)),
        _least_radius(cam.pitch, bulge),
        side.limit(float(balls.min())),
    )


def cut_away_by_face(cam: FlatFacedCam) -> CutAway:
    """What a flat face cuts away of its cam, and the least radius of what is left; see ``cut_away``."""
    at, radii = valleys(cam.radius)
    folds = at[radii < 0]  # no arc is missing without one
    missing = arcs_below_zero(_ball_behind_faces(cam), folds) if len(folds) else ()

    def bulge(phi: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            return np.where(_within(missing, phi), 0.0, -1 / cam.radius(phi))

    return CutAway(arcs_below_zero(cam.radius), missing, _least_radius(cam.contour, bulge), None, math.inf)


def _ball_behind_faces(cam: FlatFacedCam) -> RealFunction:
    """The radius of the largest ball that touches the face at phi (N,) from behind and stays behind it at all other angles;
    negative where the contour point itself does not."""
    normals, heights = _plane(cam.normal(GRID)), cam.follower.distance + cam.law(GRID)

    def radius(phi: np.ndarray) -> np.ndarray:
        contour, normal = cam.contour(phi), cam.normal(phi)
        near = np.empty(len(phi))
        for rows in np.array_split(np.arange(len(phi)), len(phi) // _ROWS + 1):
            room = heights - _plane(contour[rows]) @ normals.T
            turned = 1 - _plane(normal[rows]) @ normals.T
            apart = turned > 1 - math.cos(STEP / 2)
            near[rows] = GRID[np.argmin(np.divide(room, turned, out=np.full(room.shape, np.inf), where=apart), axis=1)]

        def behind(other: np.ndarray) -> np.ndarray:
            room = cam.follower.distance + cam.law(other) - (contour * cam.normal(other).conj()).real
            turned = 2 * np.sin((other - phi) / 2) ** 2
            apart = np.abs(_wrapped(other - phi)) > STEP / 2
            return np.asarray(np.divide(room, turned, out=np.full(len(phi), np.inf), where=apart))

        nearest = behind(narrowed(behind, near - STEP, near + STEP, _NEAREST))
        return np.asarray(np.minimum(cam.radius(phi), nearest))

    return radius


def _least_radius(curve: Callable[[np.ndarray], np.ndarray], bend: RealFunction) -> RadiusAt | None:
    at, bends = valleys(bend)
    k = int(np.argmin(bends))
    straight = -_STRAIGHT / np.abs(curve(GRID)).max()
    return RadiusAt(float(-1 / bends[k]), float(at[k])) if bends[k] < straight else None


def largest_roller(cam: RollerCam) -> RadiusAt | None:
    """The largest roller on this pitch curve that cuts nothing away, and at which cam angle a larger one would first; None
    where none would."""
    return _roller_side(cam).tightest()


def largest_wheel(cam: RollerCam) -> RadiusAt | None:
    """The largest grinding wheel or cutter that reaches all of the contour, and where a larger one would not; None: all do.

    It runs on the side of the roller. Raises ``InputError`` (follower.roller_radius) as ``check_roller`` does: a contour that
    is cut away has no such wheel.
    """
    check_roller(cam)
    sign = _material(cam)
    return _Side(cam.contour, lambda phi: sign * cam.normal(phi), lambda phi: -sign * cam.curvature(phi)).tightest()


def check_wheel(cam: RollerCam, radius: float) -> None:
    """Raises ``InputError`` (wheel_radius, follower.roller_radius) where a wheel of a radius in m cannot make the contour."""
    largest = largest_wheel(cam)
    if largest is not None and radius > largest.radius:
        where = f"the contour is too hollow for it at a cam angle of {math.degrees(largest.phi):.4g} deg"
        raise InputError("wheel_radius", radius, f"{where}: take at most {_metres(_short_of(largest.radius, -1))}")


def _metres(length: float) -> str:
    return f"{length:.5g} m"


def check_roller(cam: RollerCam, written: Written = _metres) -> None:
    """Raises ``InputError`` (follower.roller_radius) where the roller would cut a part of the contour away, or leave an edge.

    It says which roller would not, to five digits. written: how the sentence writes a length.
    """
    largest = largest_roller(cam)
    if largest is not None and cam.follower.roller_radius >= largest.radius:
        key = "follower.pivot" if isinstance(cam.follower, OscillatingRoller) else "follower.distance"
        where = f"the roller would cut the contour away at a cam angle of {math.degrees(largest.phi):.4g} deg"
        what = f"take a roller radius of at most {written(_short_of(largest.radius, -1))}, or a larger cam ({key})"
        raise InputError("follower.roller_radius", cam.follower.roller_radius, f"{where}: {what}")


def check_face(cam: FlatFacedCam, written: Written = _metres) -> None:
    """Raises ``InputError`` (follower.distance) where a flat face would cut a part of the contour away, or leave an edge.

    written: how the sentence writes a length.
    """
    at, radii = valleys(cam.radius)
    k = int(np.argmin(radii))
    if radii[k] <= 0:
        where = f"the face would cut the contour away at a cam angle of {math.degrees(at[k]):.4g} deg"
        least = _short_of(cam.follower.distance - float(radii[k]), 1)
        raise InputError("follower.distance", cam.follower.distance, f"{where}: take at least {written(least)}")


def _short_of(bound: float, direction: int) -> float:
    """A number of five digits on one side of a bound, above (1) or below (-1), never the bound itself."""
    digit = 10.0 ** (math.floor(math.log10(abs(bound))) - 4) if bound else 1e-9
    return digit * ((math.floor if direction > 0 else math.ceil)(bound / digit) + direction)
