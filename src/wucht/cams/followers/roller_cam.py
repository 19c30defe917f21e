"""Followers with a roller, and their cams: a disc on which the roller runs, or a flank of a groove."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from wucht.cams.cam import Cam, LengthFormat, format_metres, value_past_limit
from wucht.cams.followers.follower import Follower
from wucht.cams.laws import Law
from wucht.cams.milled_cam import EXACT, MOST_STEPS, MilledContour, dot
from wucht.cams.undercut import EDGE, CutAway, RadiusAt, Side, is_on_arcs, least_radius
from wucht.cams.workshop.closed_curve import CamCurve
from wucht.errors import InputError, RunError
from wucht.numerics.angles import arcs_below_zero


class RollerFollower(Follower):
    """A follower with a roller, or with an edge: a roller of the radius 0.

    In the plane of the cam as complex numbers in m; the cam turns about 0. Without keys for a groove it has one cam.
    """

    if TYPE_CHECKING:
        roller_radius: float

    @abstractmethod
    def place(self, value: np.ndarray) -> np.ndarray:
        """The centre of the roller where the law has a value (any shape)."""

    @abstractmethod
    def rate(self, value: np.ndarray) -> np.ndarray:
        """The derivative of the centre by the value of the law, there."""

    @abstractmethod
    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of an order from 0 to 3 of the centre of the roller by the cam angle, at angles phi (any shape)."""

    def make_cams(self, law: Law) -> dict[str, Cam]:
        """See ``Follower``."""
        cam = RollerCam(law, self, self.clockwise)
        return {"cam": cam, "outer": replace(cam, outer=True)} if getattr(self, "groove", False) else {"cam": cam}

    def motion_on(self, contour: MilledContour, rotation: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """See ``ContourFollower``. The roller is at its radius from the contour, along the normal: Newton's method in both
        unknowns."""
        value, at = np.array(guess, float), contour.nearest(rotation * self.place(guess))
        size = float(np.abs(contour.points).max())
        if not self.roller_radius:
            return self._motion_of_edge(contour, rotation, value, at, EXACT * size)
        for _ in range(MOST_STEPS):
            c, c1, c2 = (contour(at, k) for k in (0, 1, 2))
            off, rate = rotation * self.place(value) - c, rotation * self.rate(value)
            gap = np.abs(off) - self.roller_radius
            along = dot(c1, off)
            gap_by_value, gap_by_point = dot(off, rate) / np.abs(off), -along / np.abs(off)
            along_by_value, along_by_point = dot(c1, rate), dot(c2, off) - np.abs(c1) ** 2
            determinant = gap_by_value * along_by_point - gap_by_point * along_by_value
            value = value - (gap * along_by_point - gap_by_point * along) / determinant
            at = at - (gap_by_value * along - gap * along_by_value) / determinant
            if np.abs(gap).max() <= EXACT * size:
                return np.asarray(value)
        raise RunError("the follower does not touch the contour near the expected motion", code="no-contact")

    def _motion_of_edge(
        self, contour: MilledContour, rotation: np.ndarray, value: np.ndarray, at: np.ndarray, exact: float
    ) -> np.ndarray:
        """Return the motion where the roller is a point: it lies on the contour."""
        for _ in range(MOST_STEPS):
            c, c1 = contour(at), contour(at, 1)
            off, rate = rotation * self.place(value) - c, rotation * self.rate(value)
            determinant = (rate.conj() * c1).imag
            value = value - (off.conj() * c1).imag / determinant
            at = at + (rate.conj() * off).imag / determinant
            if np.abs(off).max() <= exact:
                return np.asarray(value)
        raise RunError("the edge does not touch the contour near the expected motion", code="no-contact")


@dataclass(frozen=True)
class RollerCam(Cam):
    """A disc on which a roller runs, or one flank of a groove.

    law: of the follower. clockwise: the sense in which the cam turns. outer: the outer flank of a groove, not the inner one.
    """

    follower: RollerFollower

    part: ClassVar[str] = "roller"

    @property
    def roller_radius(self) -> float:
        """See ``Cam``."""
        return self.follower.roller_radius

    @property
    def mating_curvature(self) -> float:
        """See ``Cam``."""
        if not self.roller_radius:
            raise InputError("width", None, "an edge has no Hertzian pressure: give no width of the contact")
        return 1 / self.roller_radius

    @property
    def pitch_curve(self) -> CamCurve:
        """See ``Cam``."""
        return self.pitch

    @property
    def _inward(self) -> float:
        """Distance of the contour inside the pitch curve."""
        return -self.follower.roller_radius if self.outer else self.follower.roller_radius

    def pitch(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of an order from 0 to 3 of the pitch curve, on which the centre of the roller goes round the cam."""
        quarter_turn = -1j * self._sense
        centres = (self.follower.centre(self.law, phi, k) for k in range(order + 1))
        sums = sum(math.comb(order, k) * quarter_turn ** (order - k) * z for k, z in enumerate(centres))
        return np.asarray(np.exp(quarter_turn * np.asarray(phi)) * sums)

    def normal(self, phi: np.ndarray) -> np.ndarray:
        """The normal of both curves, of modulus 1, that points away from the cam's centre."""
        slope = self.pitch(phi, 1)
        return np.asarray(1j * self._sense * slope / np.abs(slope))

    def pitch_curvature(self, phi: np.ndarray) -> np.ndarray:
        """Curvature of the pitch curve in 1/m, positive where it is convex."""
        slope = self.pitch(phi, 1)
        return np.asarray(-self._sense * (slope.conj() * self.pitch(phi, 2)).imag / np.abs(slope) ** 3)

    def contour(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``Cam``. The normal n of the pitch curve p turns as n' = kappa p'."""
        if order == 0:
            return np.asarray(self.pitch(phi) - self._inward * self.normal(phi))
        slope, factor = self.pitch(phi, 1), self.undercut(phi)
        if order == 1:
            return np.asarray(factor * slope)
        return np.asarray(factor * self.pitch(phi, 2) - self._inward * self._curvature_slope(phi) * slope)

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

    def grip(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``."""
        normal = self.normal(phi) * np.exp(1j * self._sense * phi)
        return np.asarray(self.material * (normal.conj() * self.follower.rate(self.law(phi))).real)

    @property
    def _roller_side(self) -> Side:
        sign = self.material
        return Side(self.pitch, lambda phi: -sign * self.normal(phi), lambda phi: sign * self.pitch_curvature(phi))

    def cut_away(self) -> CutAway:
        """Return the arcs that are cut away of a cam, and the least radii of the rest.

        The curve is sampled at 4096 angles, and refined between them where it matters: a cut shorter than 0.09 deg, of a
        depth of some (distance of the samples)^2/(8 r), tens of nanometres, may be missed.
        """
        side, radius, sign = self._roller_side, self.roller_radius, self.material
        at, balls = side.narrowest(radius)
        missing = arcs_below_zero(lambda phi: side.largest_ball(phi) - radius, at) if balls.min() < radius else ()

        def bulge(phi: np.ndarray) -> np.ndarray:
            return np.where(is_on_arcs(missing, phi), 0.0, sign * self.curvature(phi))

        return CutAway(
            arcs_below_zero(lambda phi: self.undercut(phi) - EDGE),
            missing,
            least_radius(self.pitch, lambda phi: -bulge(phi)),
            least_radius(self.pitch, bulge),
            side.limit(float(balls.min())),
        )

    def largest_roller(self) -> RadiusAt | None:
        """The largest roller on this pitch curve that cuts nothing away, and at which cam angle a larger one would first; None
        where none would."""
        return self._roller_side.tightest()

    def largest_wheel(self) -> RadiusAt | None:
        """See ``Cam``. It runs on the side of the roller. Raises ``InputError`` (follower.roller_radius) as ``check`` does: a
        contour that is cut away has no such wheel."""
        self.check()
        sign = self.material
        return Side(self.contour, lambda phi: sign * self.normal(phi), lambda phi: -sign * self.curvature(phi)).tightest()

    def check_wheel(self, radius: float) -> None:
        """Raise ``InputError`` (wheel_radius, follower.roller_radius) where a wheel of a radius in m cannot grind all of it."""
        largest = self.largest_wheel()
        if largest is not None and radius > largest.radius:
            fault = f"the contour is too hollow for it at a cam angle of {math.degrees(largest.phi):.4g} deg"
            raise InputError(
                "wheel_radius", radius, f"{fault}: take at most {format_metres(value_past_limit(largest.radius, -1))}"
            )

    def check(self, format_length: LengthFormat = format_metres) -> None:
        """See ``Cam``: ``InputError`` (follower.roller_radius), naming the largest admissible roller, to five digits."""
        largest = self.largest_roller()
        if largest is not None and self.roller_radius >= largest.radius:
            key = "".join(f" (follower.{key})" for key in self.follower.placing[:1])
            fault = f"the roller would cut the contour away at a cam angle of {math.degrees(largest.phi):.4g} deg"
            remedy = (
                f"take a roller radius of at most {format_length(value_past_limit(largest.radius, -1))}, or a larger cam{key}"
            )
            raise InputError("follower.roller_radius", self.roller_radius, f"{fault}: {remedy}")
