"""Cams: the contour that gives a follower its motion, with exact derivatives, curvature and pressure angle.

Curves are parametrised by the angle phi by which the cam has turned, in the plane that turns with it, as complex numbers in m.
Seen from the cam, a follower of a cam that turns counter-clockwise goes round it clockwise.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wucht.cams.laws import Law
from wucht.cams.milled_cam import ContourFollower
from wucht.cams.undercut import CutAway, RadiusAt
from wucht.cams.workshop.closed_curve import CamCurve
from wucht.numerics.angles import Arc

LengthFormat = Callable[[float], str]


def format_metres(length: float) -> str:
    """Return a length in m as text for the user."""
    return f"{length:.5g} m"


@dataclass(frozen=True)
class Cam(ABC):
    """A cam with its follower: the contour, its curvature and its pressure angle over the cam angle, exactly.

    ``follower.make_cams(law)`` makes them. Curves are complex numbers in m in the plane that turns with the cam.

    Parameters
    ----------
    law : Law
        Of the follower.
    follower : Follower
    clockwise : bool, optional
        The sense in which the cam turns.
    outer : bool, optional
        True for the outer flank of a groove.

    Attributes
    ----------
    part : str
        The element of the follower that touches the contour, as one word.
    """

    law: Law
    follower: ContourFollower
    clockwise: bool = False
    outer: bool = False

    part: ClassVar[str] = "follower"

    @property
    def _sense(self) -> int:
        return -1 if self.clockwise else 1

    @property
    def material(self) -> int:
        """The sign by which the curvature is positive where the material bulges."""
        return -1 if self.outer else 1

    @property
    def roller_radius(self) -> float | None:
        """Radius of the roller in m, None where there is no roller."""
        return None

    @property
    def mating_curvature(self) -> float:
        """Curvature of the mating element in 1/m: 0 of a flat face. Raises ``InputError`` where it is an edge."""
        return 0.0

    @property
    def face(self) -> Arc | None:
        """Least and greatest distance in m along +y from the rod's axis at which a flat face is touched; None without one."""
        return None

    @property
    def pitch_curve(self) -> CamCurve | None:
        """The path of the roller's centre round the cam, as ``contour``; None where there is no roller."""
        return None

    @abstractmethod
    def contour(self, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of an order from 0 to 2 of the contour by phi (any shape), complex in m."""

    @abstractmethod
    def normal(self, phi: np.ndarray) -> np.ndarray:
        """Unit normal of the contour, away from the cam's centre."""

    @abstractmethod
    def curvature(self, phi: np.ndarray) -> np.ndarray:
        """Curvature of the contour in 1/m: positive where it is convex, infinite at an edge, undefined where undercut."""

    @abstractmethod
    def pressure_angle(self, phi: np.ndarray) -> np.ndarray:
        """Angle between the contact force and the motion of the follower at the contact, in rad, from -pi/2 to pi/2."""

    @abstractmethod
    def undercut(self, phi: np.ndarray) -> np.ndarray:
        """Margin of the contour against undercut: 1 where it is straight or the roller a point, 0 where it has an edge, below
        that it is undercut."""

    @abstractmethod
    def grip(self, phi: np.ndarray) -> np.ndarray:
        """Work of a unit of contact force on the follower for a unit of its law (N,): m on a lever, a number on a rod or face.

        Negative where the contact drives the follower against the sense of its law.
        """

    @abstractmethod
    def cut_away(self) -> CutAway:
        """Return the arcs that are cut away of the cam, and the least radii of the remaining contour."""

    @abstractmethod
    def check(self, format_length: LengthFormat = format_metres) -> None:
        """Raise ``InputError`` where the follower would cut a part of the contour away, or leave an edge, naming a value
        that would not. format_length: formats a length for the message."""

    def largest_wheel(self) -> RadiusAt | None:
        """The largest grinding wheel or cutter that reaches all of the contour, and where a larger one would not; None: all
        do."""
        return None


def value_past_limit(limit: float, direction: int) -> float:
    """Return a number of five digits on one side of a limit, above (1) or below (-1), never the limit itself."""
    digit = 10.0 ** (math.floor(math.log10(abs(limit))) - 4) if limit else 1e-9
    return digit * ((math.floor if direction > 0 else math.ceil)(limit / digit) + direction)
