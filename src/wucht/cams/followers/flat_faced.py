"""A flat face across a rod, and its cams.

A flat face leaves what lies behind it at all cam angles. The ball of radius r that touches the face from behind at the contour
point c of phi stays behind the face at psi, at the distance h(psi) from the cam's centre, where
r (1 - cos(psi - phi)) <= h(psi) - c . n(psi); towards psi = phi this is the radius of curvature. The contour of phi is missing
where the least of these r over psi is negative.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wucht.cams.cam import Cam, LengthFormat, format_metres, value_past_limit
from wucht.cams.followers.follower import Follower, Outline
from wucht.cams.laws import Law
from wucht.cams.milled_cam import EXACT, MOST_STEPS, MilledContour, dot
from wucht.cams.sizing.size_limits import CamLimits, Size, SmallestCam
from wucht.cams.sizing.smallest_cam import LEAST_DISTANCE, check_length
from wucht.cams.undercut import NEAREST, CutAway, is_on_arcs, least_radius, plane_coordinates, signed_angle
from wucht.errors import InputError, RunError
from wucht.numerics.angles import GRID, STEP, Arc, arcs_below_zero, refine_minima, valleys
from wucht.schema import SI, si

_ROWS = 256  # cam angles at a time that are held against all faces


class FlatFaced(Follower):
    """A flat face across a rod."""

    kind: ClassVar[str] = "flat-faced"
    placing: ClassVar[tuple[str, ...]] = ("distance",)

    distance: SI[float] = si("m", "distance of the face from the cam's centre where the law is zero", gt=0)

    def make_cams(self, law: Law) -> dict[str, Cam]:
        """See ``Follower``."""
        return {"cam": FlatFacedCam(law, self, self.clockwise)}

    def place(self, value: np.ndarray) -> np.ndarray:
        """See ``Follower``."""
        return np.asarray(self.distance + value)

    def motion_on(self, contour: MilledContour, rotation: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """See ``ContourFollower``. The face is where the contour reaches furthest."""
        foot = rotation * (self.distance + guess)
        at = np.argmax((rotation.conj()[:, None] * contour.points[None, :]).real, axis=1).astype(float)
        for _ in range(MOST_STEPS):
            c1, c2 = (contour(at, k) for k in (1, 2))
            step = dot(rotation, c1) / dot(rotation, c2)
            at = at - step
            if np.abs(step).max() <= EXACT * len(contour.points):
                return np.asarray(dot(rotation, contour(at, 0)) - self.distance)
        raise RunError(f"the face does not touch the contour near {np.abs(foot).max():.3g} m from its centre")

    def outline(self, law: Law) -> Outline:
        """See ``Follower``."""
        contact_offsets = -law(np.linspace(0, 2 * np.pi, 721), 1) * (-1 if self.clockwise else 1)
        return Outline(face_from=contact_offsets.min(), face_to=contact_offsets.max(), face_at=self.distance + float(law(0.0)))

    def smallest_cam(self, law: Law, limits: CamLimits, size: Size) -> SmallestCam | None:
        """See ``Follower``."""
        radius, shaft = limits.least_radius, limits.shaft_radius
        if limits.pressure_angle is not None:
            raise InputError("pressure_angle", None, "a flat face has none: its cam is sized by least_radius or shaft_radius")
        if radius is None and shaft is None:
            return None
        return smallest_flat_faced_cam(law, radius or 0.0, clockwise=self.clockwise, shaft_radius=shaft or 0.0)


@dataclass(frozen=True)
class FlatFacedCam(Cam):
    """A disc on which a flat face slides. law: of the face. clockwise: the sense in which the cam turns."""

    follower: FlatFaced

    part: ClassVar[str] = "face"

    def contour(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``Cam``. The face is its tangent: it is the envelope of the faces."""
        rotation, i = np.exp(-1j * self._sense * np.asarray(phi)), 1j * self._sense
        if order == 0:
            return np.asarray(rotation * (self.follower.distance + self.law(phi) - i * self.law(phi, 1)))
        radius = self.radius(phi)
        if order == 1:
            return np.asarray(-i * rotation * radius)
        return np.asarray(-i * rotation * (self.law(phi, 1) + self.law(phi, 3) - i * radius))

    def radius(self, phi: np.ndarray) -> np.ndarray:
        """Radius of curvature of the contour in m: h + h'', h being the distance of the face from the cam's centre."""
        return np.asarray(self.follower.distance + self.law(phi) + self.law(phi, 2))

    def normal(self, phi: np.ndarray) -> np.ndarray:
        """Unit normal of the contour, away from the cam."""
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
        """Distance in m along +y from the rod's axis at which the face is touched: the face must be as long."""
        return np.asarray(-self._sense * self.law(phi, 1))

    @property
    def face(self) -> Arc:
        """See ``Cam``: the face must be as long as the range of ds/dphi; R. L. Norton, Cam Design and Manufacturing Handbook,
        2nd ed., Industrial Press 2009, chapter 7."""
        return float(valleys(self.contact)[1].min()), -float(valleys(lambda phi: -self.contact(phi))[1].min())

    def grip(self, phi: np.ndarray) -> np.ndarray:
        """See ``Cam``."""
        return np.ones(len(phi))

    def cut_away(self) -> CutAway:
        """Return the arcs that a flat face cuts away of its cam, and the least radius of the rest; see ``Cam``."""
        at, radii = valleys(self.radius)
        folds = at[radii < 0]  # no arc is missing without one
        missing = arcs_below_zero(self._ball_radius, folds) if len(folds) else ()

        def bulge(phi: np.ndarray) -> np.ndarray:
            with np.errstate(divide="ignore"):
                return np.where(is_on_arcs(missing, phi), 0.0, -1 / self.radius(phi))

        return CutAway(arcs_below_zero(self.radius), missing, least_radius(self.contour, bulge), None, math.inf)

    def _ball_radius(self, phi: np.ndarray) -> np.ndarray:
        """The radius of the largest ball that touches the face at phi (N,) from behind and stays behind it at all other
        angles; negative where the contour point itself does not."""
        normals, heights = plane_coordinates(self.normal(GRID)), self.follower.distance + self.law(GRID)
        contour, normal = self.contour(phi), self.normal(phi)
        near = np.empty(len(phi))
        for rows in np.array_split(np.arange(len(phi)), len(phi) // _ROWS + 1):
            room = heights - plane_coordinates(contour[rows]) @ normals.T
            versine = 1 - plane_coordinates(normal[rows]) @ normals.T
            apart = versine > 1 - math.cos(STEP / 2)
            near[rows] = GRID[np.argmin(np.divide(room, versine, out=np.full(room.shape, np.inf), where=apart), axis=1)]

        def ball_radius(angle: np.ndarray) -> np.ndarray:
            room = self.follower.distance + self.law(angle) - (contour * self.normal(angle).conj()).real
            versine = 2 * np.sin((angle - phi) / 2) ** 2
            apart = np.abs(signed_angle(angle - phi)) > STEP / 2
            return np.asarray(np.divide(room, versine, out=np.full(len(phi), np.inf), where=apart))

        nearest = ball_radius(refine_minima(ball_radius, near - STEP, near + STEP, NEAREST))
        return np.asarray(np.minimum(self.radius(phi), nearest))

    def check(self, format_length: LengthFormat = format_metres) -> None:
        """See ``Cam``: ``InputError`` (follower.distance)."""
        at, radii = valleys(self.radius)
        k = int(np.argmin(radii))
        if radii[k] <= 0:
            fault = f"the face would cut the contour away at a cam angle of {math.degrees(at[k]):.4g} deg"
            least = value_past_limit(self.follower.distance - float(radii[k]), 1)
            raise InputError("follower.distance", self.follower.distance, f"{fault}: take at least {format_length(least)}")


def smallest_flat_faced_cam(
    law: Law, least_radius: float, *, clockwise: bool = False, shaft_radius: float = 0.0
) -> SmallestCam:
    """The least distance of a flat face, greater than zero. Its contour's radius of curvature is distance + psi + psi''.

    law: in m. least_radius: of curvature that is permitted, in m. shaft_radius: the least base circle, in m: a contour that is
    bent little enough need not even go round the shaft. Raises ``InputError`` (least_radius, shaft_radius).
    """
    for name, value in (("least_radius", least_radius), ("shaft_radius", shaft_radius)):
        check_length(name, value, or_zero=True)
    at, bends = valleys(lambda phi: law(phi) + law(phi, 2))
    k, lowest, highest = int(np.argmin(bends)), float(valleys(law)[1].min()), -float(valleys(lambda p: -law(p))[1].min())
    distance = max(least_radius - float(bends[k]), shaft_radius - lowest, LEAST_DISTANCE)
    cam = FlatFacedCam(law, FlatFaced(distance=distance), clockwise)
    least = distance + float(bends[k])
    return SmallestCam(cam.follower, distance + lowest, distance + highest, least, float(at[k]), face=cam.face)
