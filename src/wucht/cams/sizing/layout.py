"""Possible centres of a cam for its pressure angles: cones, and the nearest point of their intersection.

Relative to the guide of the follower, a lever's pivot or a rod, the roller's centre runs along a path q(psi), and the cam's
centre O is unknown. The contact normal has the direction of O - A, A = q + i q' (q' by the cam angle; q - i q' for a cam that
turns clockwise), and the pressure angle is that between it and the direction w in which the roller comes in. It is at most
alpha where O lies in the cone

    |Im((O - A) w*)| <= tan alpha Re((O - A) w*),

two half-planes, linear in O (cam-mathematics, "smallest cam", whose formula this is for a lever; for a rod it is
tan alpha = (e + s')/(D + s)). All cones together are a convex set K.

Swing. The cones of the two end positions, apart along the chord of the roller's path, open to different sides of the normal of
this chord where alpha < swing/2, and K is empty; where alpha is larger, all cones have a direction in common, and a centre far
away will do. So the pressure angle must be larger than half the lever's swing, and need not be more.

Base circle. On a lever O lies, for all cam angles, on that side of the line through pivot and roller to which the roller comes
in; so |O - q| falls as it does, and the least |O - q| of the cycle is that at the innermost position, the largest that at the
outermost. Either is the distance of O from a given point: the smallest cam is the nearest point of K, a convex problem in
two variables. Between the sampled angles K is enforced by exchange, as restrictions are in ``laws.synthesis``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from wucht.cams.followers.roller_cam import RollerFollower
from wucht.cams.laws import Law
from wucht.cams.laws.cone_programme import InfeasibleError
from wucht.errors import InputError, RunError
from wucht.numerics.angles import GRID, STEP, TURN, refine_minima, valleys
from wucht.numerics.zeros_and_peaks import RealFunction

EXACT = 1e-11  # of the size of the cam
_FIRST = np.arange(16) * (TURN / 16)
_BETWEEN = 0.01  # of the largest value of a function: so much lower it may be between the angles of the grid
_MOST_EXCHANGES = 60


class Guide(Protocol):
    """A follower with its pivot or its rod in the origin, or at its final place."""

    @property
    def roller_radius(self) -> float:
        """Radius of the roller in m."""
        ...

    def place(self, value: np.ndarray) -> np.ndarray:
        """Return the centre of the roller for a value of the law."""
        ...

    def rate(self, value: np.ndarray) -> np.ndarray:
        """The derivative of that by the value of the law."""
        ...

    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of an order from 0 to 3 of the centre of the roller by the cam angle."""
        ...

    def swing(self, low: float, high: float) -> float:
        """Return the angle in rad by which it turns between two values of its law."""
        ...

    def distance_from(self, centre: complex) -> float:
        """Return the key ``distance`` that it has with a cam about this centre, infinite where it has none."""
        ...

    def relative_to(self, centre: complex) -> RollerFollower:
        """Return it turned and moved so that the centre of its cam is 0 and its pivot on +x, or the rod along +x."""
        ...


@dataclass(frozen=True, eq=False)
class Layout:
    """guide: the follower with its pivot or rod in the origin. inward: the sense of the law in which the roller comes in.
    tangents: of the pressure angles that are permitted as it goes out and as it comes in."""

    law: Law
    guide: Guide
    clockwise: bool
    inward: int
    tangents: tuple[float, float]

    @property
    def turn(self) -> complex:
        """The quarter turn in the sense in which the cam turns."""
        return -1j if self.clockwise else 1j

    def cones(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return apex A, axis w and tangent of the half angle (N,)."""
        rate = self.guide.rate(self.law(phi))
        out = -self.inward * self.law(phi, 1)
        away, back = self.tangents
        tangent = np.where(out > 0, away, np.where(out < 0, back, min(away, back)))
        apex = self.guide.centre(self.law, phi) + self.turn * self.guide.centre(self.law, phi, 1)
        return apex, self.inward * rate / np.abs(rate), tangent

    @cached_property
    def grid_cones(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The cones at the angles of the grid."""
        return self.cones(GRID)

    @cached_property
    def size(self) -> float:
        """The distance of the farthest apex, in m."""
        return float(np.abs(self.grid_cones[0]).max())

    @cached_property
    def range(self) -> tuple[float, float]:
        """The least and the greatest value of the law."""
        low, high = float(valleys(self.law)[1].min()), -float(valleys(lambda p: -self.law(p))[1].min())
        if not high > low:
            raise InputError("law", None, "it does not move: without a pressure angle no cam can be sized")
        return low, high

    @property
    def ends(self) -> tuple[complex, complex]:
        """The roller's centre at the innermost and the outermost position."""
        inner, outer = self.guide.place(np.array(self.range[::-1] if self.inward > 0 else self.range))
        return complex(inner), complex(outer)

    @property
    def swing(self) -> float:
        """Angle in rad by which the axes of the cones turn."""
        return self.guide.swing(*self.range)

    def half_planes(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return normals a and bounds b (2 N,): Re(O a*) <= b, the normals of modulus 1."""
        apex, axis, tangent = self.cones(phi)
        a = np.concatenate([(1j - tangent) * axis, (-1j - tangent) * axis]) / np.tile(np.hypot(1, tangent), 2)
        return a, (np.tile(apex, 2) * a.conj()).real

    def violated_angles(self, centre: complex) -> np.ndarray:
        """Return the cam angles at which O lies farthest outside of the cones, as local maxima."""

        def inside(cones: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
            apex, axis, tangent = cones
            off = (centre - apex) * axis.conj()
            return np.asarray((tangent * off.real - np.abs(off.imag)) / np.hypot(1, tangent))

        return minima_below(inside(self.grid_cones), lambda phi: inside(self.cones(phi)), -EXACT * max(self.size, abs(centre)))

    def bends(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return A and A'/(+-i) (N,), on which the curvature depends."""
        first, second = (self.guide.centre(self.law, phi, order) for order in (1, 2))
        return self.guide.centre(self.law, phi) + self.turn * first, first / self.turn + second


def pitch_curvature(v: np.ndarray, apex_slope: np.ndarray) -> np.ndarray:
    """Return the curvature of the pitch curve in 1/m from V = A - O and A'/(+-i)."""
    return np.asarray((np.abs(v) ** 2 - (v.conj() * apex_slope).real) / np.abs(v) ** 3)


def minima_below(values: np.ndarray, function: RealFunction, limit: float) -> np.ndarray:
    """Return the minima of a function below a limit; values: on the grid, between whose angles they may be lower."""
    near = values < limit + _BETWEEN * np.abs(values).max()
    i = np.flatnonzero((values < np.roll(values, 1)) & (values <= np.roll(values, -1)) & near)
    if not len(i):
        return np.zeros(0)
    at = refine_minima(function, GRID[i] - STEP, GRID[i] + STEP)
    return np.asarray(at[function(at) < limit])


def nearest_in_cones(layout: Layout, target: complex) -> complex:
    """Return the point of K that is nearest to a target. Raises ``InfeasibleError``."""
    phi = _FIRST
    if math.atan(min(layout.tangents)) <= layout.swing / 2:
        raise InfeasibleError
    for _ in range(_MOST_EXCHANGES):
        centre = _nearest_point(target, *layout.half_planes(phi), layout.size)
        violations = layout.violated_angles(centre)
        if not len(violations):
            return centre
        phi = np.append(phi, violations)
    raise RunError(
        f"the cam's size has not converged after {_MOST_EXCHANGES} steps of the exchange algorithm: its law may jump"
    )


def _nearest_point(target: complex, a: np.ndarray, b: np.ndarray, size: float) -> complex:
    """Return the point with Re(O a*) <= b (m,) nearest to a target: itself, its foot on a line, or an intersection of two."""
    beyond = (target * a.conj()).real - b
    i, j = np.triu_indices(len(a), 1)
    area = (a[i].conj() * a[j]).imag
    meet = np.divide(1j * (b[j] * a[i] - b[i] * a[j]), area, out=np.full(len(i), np.nan + 0j), where=np.abs(area) > EXACT)
    candidates = np.concatenate([[target], target - beyond * a, meet])
    candidates = candidates[np.argsort(np.abs(candidates - target))]
    for part in np.array_split(candidates, max(1, len(candidates) // 128)):
        beyond = (np.multiply.outer(part, a.conj()).real - b).max(axis=1)
        feasible = np.flatnonzero(beyond <= EXACT / 10 * np.maximum(size, np.abs(part)))
        if len(feasible):
            return complex(part[feasible[0]])
    raise InfeasibleError
