"""Cams: the contour that gives a follower its motion, with exact derivatives, curvature and pressure angle.

Curves are parametrised by the angle phi by which the cam has turned, in the plane that turns with it, as complex numbers in m.
A cam that turns counter-clockwise sees its follower go round it clockwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wucht.cams.followers import FlatFaced, RollerFollower
from wucht.cams.laws.law import Law


class Cam(Protocol):
    """A cam with its follower."""

    def contour(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of an order from 0 to 2 of the contour by phi (any shape), complex in m."""
        ...

    def curvature(self, phi: np.ndarray) -> np.ndarray:
        """Of the contour, in 1/m: positive where it is convex; infinite at an edge, and of no use where it is undercut."""
        ...

    def pressure_angle(self, phi: np.ndarray) -> np.ndarray:
        """Between the contact force and the motion of the follower at the contact, in rad, from -pi/2 to pi/2."""
        ...

    def undercut(self, phi: np.ndarray) -> np.ndarray:
        """How far from undercut the contour is: 1 where it is straight or the roller a point, 0 where it has an edge, below
        that it is undercut."""
        ...


@dataclass(frozen=True)
class RollerCam:
    """A disc on which a roller runs, or one flank of a groove.

    law: of the follower. clockwise: the sense in which the cam turns. outer: the outer flank of a groove, not the inner one.
    """

    law: Law
    follower: RollerFollower
    clockwise: bool = False
    outer: bool = False

    @property
    def _sense(self) -> int:
        return -1 if self.clockwise else 1

    @property
    def _inward(self) -> float:
        """How far the contour lies inside the pitch curve."""
        return -self.follower.roller_radius if self.outer else self.follower.roller_radius

    def pitch(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of an order from 0 to 3 of the pitch curve, on which the centre of the roller goes round the cam."""
        turned = -1j * self._sense
        centres = (self.follower.centre(self.law, phi, k) for k in range(order + 1))
        sums = sum(math.comb(order, k) * turned ** (order - k) * z for k, z in enumerate(centres))
        return np.asarray(np.exp(turned * np.asarray(phi)) * sums)

    def normal(self, phi: np.ndarray) -> np.ndarray:
        """The normal of both curves, of modulus 1, that points away from the cam's centre."""
        slope = self.pitch(phi, 1)
        return np.asarray(1j * self._sense * slope / np.abs(slope))

    def pitch_curvature(self, phi: np.ndarray) -> np.ndarray:
        """Of the pitch curve, in 1/m, positive where it is convex."""
        slope = self.pitch(phi, 1)
        return np.asarray(-self._sense * (slope.conj() * self.pitch(phi, 2)).imag / np.abs(slope) ** 3)

    def contour(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``Cam``. The normal n of the pitch curve p turns as n' = kappa p'."""
        if order == 0:
            return np.asarray(self.pitch(phi) - self._inward * self.normal(phi))
        slope, shrunk = self.pitch(phi, 1), self.undercut(phi)
        if order == 1:
            return np.asarray(shrunk * slope)
        return np.asarray(shrunk * self.pitch(phi, 2) - self._inward * self._curvature_slope(phi) * slope)

    def _curvature_slope(self, phi: np.ndarray) -> np.ndarray:
        """The derivative of the pitch curve's curvature by phi."""
        slope, size = self.pitch(phi, 1), np.abs(self.pitch(phi, 1))
        second = slope.conj() * self.pitch(phi, 2)
        third = slope.conj() * self.pitch(phi, 3)
        return np.asarray(self._sense * (3 * second.imag * second.real / size**5 - third.imag / size**3))

    def curvature(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.pitch_curvature(phi) / self.undercut(phi))

    def undercut(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``."""
        return np.asarray(1 - self._inward * self.pitch_curvature(phi))

    def pressure_angle(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``."""
        normal = self.normal(phi) * np.exp(1j * self._sense * np.asarray(phi))
        from_motion = normal / self.follower.rate(self.law(phi))
        with np.errstate(divide="ignore"):
            return np.asarray(np.arctan(from_motion.imag / from_motion.real))


@dataclass(frozen=True)
class FlatFacedCam:
    """A disc on which a flat face slides. law: of the face. clockwise: the sense in which the cam turns."""

    law: Law
    follower: FlatFaced
    clockwise: bool = False

    @property
    def _sense(self) -> int:
        return -1 if self.clockwise else 1

    def contour(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``Cam``. The face is its tangent: it is the envelope of the faces."""
        turned, i = np.exp(-1j * self._sense * np.asarray(phi)), 1j * self._sense
        if order == 0:
            return np.asarray(turned * (self.follower.distance + self.law(phi) - i * self.law(phi, 1)))
        radius = self.radius(phi)
        if order == 1:
            return np.asarray(-i * turned * radius)
        return np.asarray(-i * turned * (self.law(phi, 1) + self.law(phi, 3) - i * radius))

    def radius(self, phi: np.ndarray) -> np.ndarray:
        """Of curvature of the contour, in m: h + h'', h being the distance of the face from the cam's centre."""
        return np.asarray(self.follower.distance + self.law(phi) + self.law(phi, 2))

    def normal(self, phi: np.ndarray) -> np.ndarray:
        """Of the contour, of modulus 1, away from the cam."""
        return np.asarray(np.exp(-1j * self._sense * np.asarray(phi)))

    def curvature(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``."""
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.radius(phi))

    def undercut(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``: the radius of curvature as a share of the distance."""
        return np.asarray(self.radius(phi) / self.follower.distance)

    def pressure_angle(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``: none, the face is across its motion."""
        return np.zeros(np.shape(phi))

    def contact(self, phi: np.ndarray) -> np.ndarray:
        """How far from the rod's axis the face is touched, in m, along +y: the face must be as long."""
        return np.asarray(-self._sense * self.law(phi, 1))
