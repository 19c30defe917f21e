"""A roller on a rod, and its cams: a disc or a groove."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field, StrictBool

from wucht.cams.followers.follower import Outline
from wucht.cams.followers.roller_cam import RollerFollower
from wucht.cams.laws import Law
from wucht.cams.sizing.layout import Layout
from wucht.cams.sizing.size_limits import CamLimits, Size, SmallestCam
from wucht.cams.sizing.smallest_cam import Angles, smallest_roller_cam, tangents_of
from wucht.schema import SI, si


class TranslatingRoller(RollerFollower):
    """A roller on a rod."""

    # It slides along +x, its axis beside the cam's centre by ``offset`` along +y.

    kind: ClassVar[str] = "translating-roller"
    placing: ClassVar[tuple[str, ...]] = ("distance", "offset")

    distance: SI[float] = si("m", "distance of the roller's centre where the law is zero", gt=0)
    roller_radius: SI[float] = si("m", "radius of the roller", gt=0)
    offset: SI[float] = si("m", "offset of the rod's axis", default=0.0)
    groove: StrictBool = Field(default=False, description="groove for the roller, true or false")

    def place(self, value: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.asarray(self.distance + np.asarray(value) + 1j * self.offset)

    def rate(self, value: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.ones(np.shape(value), complex)

    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``RollerFollower``."""
        return self.place(law(phi)) if order == 0 else law(phi, order) + 0j

    def outline(self, law: Law) -> Outline:
        """See ``Follower``."""
        return Outline(rod_offset=self.offset)

    def smallest_cam(self, law: Law, limits: CamLimits, size: Size) -> SmallestCam | None:
        """See ``Follower``."""
        if limits.pressure_angle is None:
            return None
        return smallest_rod_cam(
            law, self.roller_radius, limits.pressure_angle, clockwise=self.clockwise,
            least_radius=limits.least_radius or 0.0, shaft_radius=limits.shaft_radius or 0.0, size=size,
        )  # fmt: skip

    def swing(self, low: float, high: float) -> float:
        """See ``Guide``."""
        return 0.0

    def distance_from(self, centre: complex) -> float:
        """See ``Guide``."""
        return -centre.real

    def relative_to(self, centre: complex) -> TranslatingRoller:
        """See ``Guide``."""
        return self.model_copy(update={"distance": -centre.real, "offset": -centre.imag})


def smallest_rod_cam(
    law: Law, roller_radius: float, pressure_angle: Angles, *, clockwise: bool = False,
    least_radius: float | None = None, shaft_radius: float | None = None, size: Size = "base",
) -> SmallestCam:  # fmt: skip
    """Return the distance and the offset that make the smallest cam for a rod; see ``smallest_lever_cam``. law: in m.

    With a shaft_radius the distance is greater than zero, even of a law that is never zero.
    """
    guide = TranslatingRoller.model_construct(distance=0.0, roller_radius=roller_radius)
    return smallest_roller_cam(Layout(law, guide, clockwise, -1, tangents_of(pressure_angle)), least_radius, shaft_radius, size)
