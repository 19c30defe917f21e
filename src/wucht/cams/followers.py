"""Followers: where the law of a motion puts the centre of a roller, or a flat face.

In the plane of the cam as complex numbers in m; the cam turns about 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wucht.cams.laws.law import Law


class RollerFollower(Protocol):
    """A follower with a roller."""

    @property
    def roller_radius(self) -> float:
        """In m."""
        ...

    def place(self, moved: np.ndarray) -> np.ndarray:
        """The centre of the roller where the law has a value (any shape)."""
        ...

    def rate(self, moved: np.ndarray) -> np.ndarray:
        """The derivative of the centre by the value of the law, there."""
        ...

    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of an order from 0 to 3 of the centre of the roller by the cam angle, at angles phi (any shape)."""
        ...


@dataclass(frozen=True)
class OscillatingRoller:
    """A roller on a lever that turns about a pivot; its law is an angle in rad, counter-clockwise.

    pivot: the distance of the pivot from the cam's centre, along +x; arm: of the lever; roller_radius: all in m. angle: of the
    lever where the law is zero, in rad from +x: between -pi and 0 the roller goes out as the law rises, between 0 and pi in.
    """

    pivot: float
    arm: float
    roller_radius: float
    angle: float

    def place(self, moved: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.asarray(self.pivot + self._arm(moved))

    def rate(self, moved: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.asarray(1j * self._arm(moved))

    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``RollerFollower``."""
        if order == 0:
            return self.place(law(phi))
        arm, s = self._arm(law(phi)), law(phi, 1)
        if order == 1:
            return np.asarray(1j * s * arm)
        q = law(phi, 2)
        if order == 2:
            return np.asarray((1j * q - s**2) * arm)
        return np.asarray((1j * law(phi, 3) - 3 * s * q - 1j * s**3) * arm)

    def _arm(self, moved: np.ndarray) -> np.ndarray:
        return np.asarray(self.arm * np.exp(1j * (self.angle + np.asarray(moved))))


@dataclass(frozen=True)
class TranslatingRoller:
    """A roller on a rod that slides along +x; its law is a displacement in m.

    distance: of the roller's centre from the cam's, along x, where the law is zero. offset: of the rod's axis, along +y.
    """

    distance: float
    roller_radius: float
    offset: float = 0.0

    def place(self, moved: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.asarray(self.distance + np.asarray(moved) + 1j * self.offset)

    def rate(self, moved: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.ones(np.shape(moved), complex)

    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``RollerFollower``."""
        return self.place(law(phi)) if order == 0 else law(phi, order) + 0j


@dataclass(frozen=True)
class FlatFaced:
    """A flat face, across the rod, that slides along +x; its law is a displacement in m.

    distance: of the face from the cam's centre where the law is zero, in m.
    """

    distance: float
