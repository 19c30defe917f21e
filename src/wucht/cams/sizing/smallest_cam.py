"""The smallest cam for a permitted pressure angle and a permitted curvature, of a follower with a roller."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wucht.cams.followers.roller_cam import RollerCam, RollerFollower
from wucht.cams.laws.programs import InfeasibleError
from wucht.cams.sizing.curvature import with_curvature
from wucht.cams.sizing.layout import Layout, nearest_in_cones
from wucht.cams.sizing.permitted import LARGEST_ANGLE, Size, Smallest
from wucht.errors import InputError, RunError
from wucht.numerics.angles import valleys

Angles = float | tuple[float, float]
_MET = 1e-6  # rad: a bound so near is reached
LEAST_DISTANCE = 1e-6  # m: a cam file wants a distance greater than zero, even of a law that is never zero
_SHARE = 1e-9  # of the tangents of the pressure angles, to which they are found where a shaft makes them smaller


@dataclass(frozen=True)
class SmallestCam(Smallest):
    """A cam with a roller, as small as it can be.

    follower: in the frame of ``followers``. base_radius, largest_radius: of the pitch curve in m; the contour's are less by the
    roller's radius. pressure_angle: the largest that is reached. binding: cam angles at which a permitted pressure angle is
    reached. Angles in rad.
    """

    follower: RollerFollower
    pressure_angle: float
    binding: tuple[float, ...]

    @property
    def placed(self) -> Mapping[str, float]:
        """See ``Smallest``."""
        return {key: getattr(self.follower, key) for key in self.follower.placing}

    def summary(self) -> dict[str, Any]:
        """See ``Smallest``."""
        return self._of_contour(self.follower.roller_radius) | {"max_pressure_angle": self.pressure_angle}


def check_length(name: str, value: float, or_zero: bool = False) -> None:
    """Raises ``InputError`` where a length in m is none, or not above zero."""
    if not (math.isfinite(value) and (value > 0 or (or_zero and value == 0))):
        raise InputError(name, value, f"must be {'zero or ' if or_zero else ''}greater than zero (in m)")


def tangents_of(permitted: Angles) -> tuple[float, float]:
    """Of pressure angles as the roller goes out and in. Raises ``InputError``."""
    both = permitted if isinstance(permitted, tuple) else (permitted, permitted)
    for angle in both:
        if not 0 < angle <= LARGEST_ANGLE:
            raise InputError("pressure_angle", angle, "must be greater than zero and at most 89 deg (in rad)")
    return math.tan(both[0]), math.tan(both[1])


def smallest_roller_cam(layout: Layout, least_radius: float | None, shaft_radius: float | None, smallest: Size) -> SmallestCam:
    """The smallest cam of a layout, see ``smallest_lever_cam``. Raises ``InputError``, ``RunError``."""
    roller = layout.guide.roller_radius
    check_length("roller_radius", roller, or_zero=True)
    if least_radius is not None:
        check_length("least_radius", least_radius, or_zero=roller > 0)
    target = layout.ends[0 if smallest == "base" else 1]

    def centre_for(layout: Layout) -> complex:
        nearest = nearest_in_cones(layout, target)
        return nearest if least_radius is None else with_curvature(layout, target, nearest, 1 / (roller + least_radius))

    try:
        centre = centre_for(layout)
    except InfeasibleError:
        swing, permitted = layout.swing, math.atan(min(layout.tangents))
        allowed = f"no cam has it: it must be greater than {math.degrees(swing) / 2:.6g} deg, half the lever's swing"
        raise InputError("pressure_angle", f"{math.degrees(permitted):.6g} deg", allowed) from None
    if shaft_radius is not None:
        check_length("shaft_radius", shaft_radius, or_zero=True)
        centre = _round_a_shaft(layout, centre, roller + shaft_radius, centre_for)
    return _described(layout, centre)


def _round_a_shaft(layout: Layout, centre: complex, base: float, centre_for: Callable[[Layout], complex]) -> complex:
    """The centre of a cam whose pitch curve has at least a base circle, and a rod's a distance greater than zero.

    Whatever has that base circle would do: the one with the smallest pressure angle is taken. The smaller that is, the larger
    is the smallest cam, without limit towards half the lever's swing.
    """

    def goes_round(centre: complex) -> bool:
        return abs(layout.ends[0] - centre) >= base and layout.guide.distance_from(centre) >= LEAST_DISTANCE

    if goes_round(centre):
        return centre
    found: complex | None = None
    low, high = math.tan(layout.swing / 2) / min(layout.tangents), 1.0  # of the tangents: at low the cam is infinitely large
    while high - low > _SHARE:
        share = (low + high) / 2
        try:
            tried = centre_for(replace(layout, tangents=(share * layout.tangents[0], share * layout.tangents[1])))
        except InfeasibleError:  # by rounding, so near to half the swing
            low = share
            continue
        low, high, found = (share, high, tried) if goes_round(tried) else (low, share, found)
    if found is None:
        raise RunError("no cam round a shaft of that radius was found: permit a smaller one", code="no-cam")
    return found


def _described(layout: Layout, centre: complex) -> SmallestCam:
    """The cam whose centre is O, turned and moved so that O is 0 and the pivot on +x, or the rod along +x."""
    follower = layout.guide.seen_from(centre)
    cam = RollerCam(layout.law, follower, layout.clockwise)

    def spare(phi: np.ndarray) -> np.ndarray:
        return np.asarray(np.arctan(layout.cones(phi)[2]) - np.abs(cam.pressure_angle(phi)))

    at, spares = valleys(spare)
    largest = -float(valleys(lambda phi: -np.abs(cam.pressure_angle(phi)))[1].min())
    sharpest, bends = valleys(lambda phi: -cam.pitch_curvature(phi))
    k = int(np.argmin(bends))
    radius = -1 / float(bends[k]) - follower.roller_radius if bends[k] < 0 else math.inf
    near, far = (abs(end - centre) for end in layout.ends)
    binding = tuple(float(x) for x in np.sort(at[spares < _MET]))
    return SmallestCam(near, far, radius, float(sharpest[k]), follower, largest, binding)
