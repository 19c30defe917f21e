"""A new law and a new follower are one class each: a cubic rise, and a knife edge on a rod with an offset.

wucht list knife-edge --import examples/own_cam.py
wucht run FILE --import examples/own_cam.py     # a cam file with [law] kind = "cubic" and [follower] kind = "knife-edge"
"""

from typing import ClassVar

import numpy as np

from wucht.cams import Law, Outline, RiseTable, RollerFollower, StandardLaw, polynomial_law
from wucht.extending import SI, si


class Cubic(RiseTable):
    """Rise, rest and return: s = 3 x^2 - 2 x^3, whose acceleration jumps at both ends."""

    kind: ClassVar[str] = "cubic"

    def rise_law(self) -> StandardLaw:
        """Return the share of the stroke over the share of the arc."""
        return polynomial_law(np.array([0.0, 1.0]), np.array([[0.0, 0.0, 3.0, -2.0]]))


class KnifeEdge(RollerFollower):
    """A knife edge on a rod: a roller of the radius 0."""

    kind: ClassVar[str] = "knife-edge"
    placing: ClassVar[tuple[str, ...]] = ("distance", "offset")
    roller_radius: ClassVar[float] = 0.0

    distance: SI[float] = si("m", "distance of the edge from the cam's centre, along x, where the law is zero", gt=0)
    offset: SI[float] = si("m", "offset of the rod's axis", default=0.0)

    def place(self, value: np.ndarray) -> np.ndarray:
        """Return the position of the edge for a value of the law."""
        return np.asarray(self.distance + np.asarray(value) + 1j * self.offset)

    def rate(self, value: np.ndarray) -> np.ndarray:
        """Return the derivative of this position with respect to the value of the law."""
        return np.ones(np.shape(value), complex)

    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """Return the derivative of an order of this position with respect to the cam angle."""
        return self.place(law(phi)) if order == 0 else law(phi, order) + 0j

    def outline(self, law: Law) -> Outline:
        """Return the elements that are drawn."""
        return Outline(rod_offset=self.offset)


FILE = """
title = "A knife edge on a cam with a cubic law"

[study]
kind = "cam-contour"

[law]
kind = "cubic"
stroke = "20 mm"
rise = ["30 deg", "150 deg"]

[follower]
kind = "knife-edge"
distance = "50 mm"
offset = "10 mm"
"""
