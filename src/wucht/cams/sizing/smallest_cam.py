"""The smallest cam for a permitted pressure angle and a permitted curvature."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from wucht.cams.cam import FlatFacedCam, RollerCam
from wucht.cams.followers import FlatFaced, OscillatingRoller, TranslatingRoller
from wucht.cams.laws.law import Law
from wucht.cams.laws.programs import InfeasibleError
from wucht.cams.sizing.curvature import with_curvature
from wucht.cams.sizing.layout import Layout, nearest_in_cones
from wucht.errors import InputError, RunError
from wucht.numerics.valleys import TURN, valleys

Angles = float | tuple[float, float]
Size = Literal["base", "blank"]
_MET = 1e-6  # rad: a bound so near is reached
_LARGEST_ANGLE = math.radians(89)
_LEAST_DISTANCE = 1e-6  # m: a cam file wants a distance greater than zero, even of a law that is never zero
_SHARE = 1e-9  # of the tangents of the pressure angles, to which they are found where a shaft makes them smaller


@dataclass(frozen=True)
class SmallestCam:
    """A cam with a roller, as small as it can be.

    follower: in the frame of ``followers``. base_radius, largest_radius: of the pitch curve in m; the contour's are less by the
    roller's radius. pressure_angle: the largest that is reached. binding: cam angles at which a permitted pressure angle is
    reached. least_radius: of curvature of the contour in m where it is convex, negative where it is undercut, infinite where
    it is nowhere convex; sharpest: the cam angle there. Angles in rad.
    """

    follower: OscillatingRoller | TranslatingRoller
    base_radius: float
    largest_radius: float
    pressure_angle: float
    binding: tuple[float, ...]
    least_radius: float
    sharpest: float


@dataclass(frozen=True)
class SmallestFlatFacedCam:
    """A cam with a flat face, as small as it can be.

    base_radius, largest_radius: of the contour in m. least_radius: of curvature in m; sharpest: the cam angle there in rad.
    face: between which distances from the rod's axis the face is touched, in m along +y.
    """

    follower: FlatFaced
    base_radius: float
    largest_radius: float
    least_radius: float
    sharpest: float
    face: tuple[float, float]


def smallest_lever_cam(
    law: Law, arm: float, roller_radius: float, pressure_angle: Angles, *, clockwise: bool = False, outward: bool = True,
    least_radius: float | None = None, shaft_radius: float | None = None, smallest: Size = "base",
) -> SmallestCam:  # fmt: skip
    """The pivot's distance and the lever's angle that make the smallest cam for a lever.

    law: of the lever in rad. arm, roller_radius: in m. pressure_angle: the largest permitted one in rad, or two: for where the
    roller goes out, and for where it comes in. outward: the roller goes out as the law rises, else in. least_radius: the least
    permitted radius of curvature of the contour in m, where it is convex; 0 forbids undercut alone (that the roller cuts
    nothing elsewhere: ``undercut.check_roller``); None permits all. shaft_radius: of shaft or hub, the least base circle of the
    contour in m; where it binds the pressure angle is as small as it then can be; None permits all. smallest: the base circle,
    or the largest radius ("blank").

    Raises ``InputError``: pressure_angle, with the least that is possible; law, where it does not move; least_radius,
    shaft_radius, arm, roller_radius, where they are no lengths. ``RunError``: none was found, though there is one.
    """
    _positive("arm", arm)
    guide = OscillatingRoller(0.0, arm, roller_radius, 0.0)
    layout = Layout(law, guide, clockwise, -1 if outward else 1, _tangents(pressure_angle))
    return _smallest(layout, least_radius, shaft_radius, smallest)


def smallest_rod_cam(
    law: Law, roller_radius: float, pressure_angle: Angles, *, clockwise: bool = False,
    least_radius: float | None = None, shaft_radius: float | None = None, smallest: Size = "base",
) -> SmallestCam:  # fmt: skip
    """The distance and the offset that make the smallest cam for a rod; see ``smallest_lever_cam``. law: in m.

    With a shaft_radius the distance is greater than zero, even of a law that is never zero.
    """
    guide = TranslatingRoller(0.0, roller_radius)
    return _smallest(Layout(law, guide, clockwise, -1, _tangents(pressure_angle)), least_radius, shaft_radius, smallest)


def smallest_flat_faced_cam(
    law: Law, least_radius: float, *, clockwise: bool = False, shaft_radius: float = 0.0
) -> SmallestFlatFacedCam:
    """The least distance of a flat face, greater than zero. Its contour's radius of curvature is distance + psi + psi''.

    law: in m. least_radius: of curvature that is permitted, in m. shaft_radius: the least base circle, in m: a contour that is
    bent little enough need not even go round the shaft. Raises ``InputError`` (least_radius, shaft_radius).
    """
    for name, value in (("least_radius", least_radius), ("shaft_radius", shaft_radius)):
        _positive(name, value, or_zero=True)
    at, bends = valleys(lambda phi: law(phi) + law(phi, 2))
    k, lowest, highest = int(np.argmin(bends)), float(valleys(law)[1].min()), -float(valleys(lambda p: -law(p))[1].min())
    distance = max(least_radius - float(bends[k]), shaft_radius - lowest, _LEAST_DISTANCE)
    cam = FlatFacedCam(law, FlatFaced(distance), clockwise)
    face = float(valleys(cam.contact)[1].min()), -float(valleys(lambda p: -cam.contact(p))[1].min())
    reached = distance + float(bends[k])
    return SmallestFlatFacedCam(cam.follower, distance + lowest, distance + highest, reached, float(at[k]), face)


def _positive(name: str, value: float, or_zero: bool = False) -> None:
    if not (math.isfinite(value) and (value > 0 or (or_zero and value == 0))):
        raise InputError(name, value, f"must be {'zero or ' if or_zero else ''}greater than zero (in m)")


def _tangents(permitted: Angles) -> tuple[float, float]:
    both = permitted if isinstance(permitted, tuple) else (permitted, permitted)
    for angle in both:
        if not 0 < angle <= _LARGEST_ANGLE:
            raise InputError("pressure_angle", angle, "must be greater than zero and at most 89 deg (in rad)")
    return math.tan(both[0]), math.tan(both[1])


def _smallest(layout: Layout, least_radius: float | None, shaft_radius: float | None, smallest: Size) -> SmallestCam:
    roller = layout.guide.roller_radius
    _positive("roller_radius", roller, or_zero=True)
    if least_radius is not None:
        _positive("least_radius", least_radius, or_zero=roller > 0)
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
        _positive("shaft_radius", shaft_radius, or_zero=True)
        centre = _round_a_shaft(layout, centre, roller + shaft_radius, centre_for)
    return _described(layout, centre)


def _round_a_shaft(layout: Layout, centre: complex, base: float, centre_for: Callable[[Layout], complex]) -> complex:
    """The centre of a cam whose pitch curve has at least a base circle, and a rod's a distance greater than zero.

    Whatever has that base circle would do: the one with the smallest pressure angle is taken. The smaller that is, the larger
    is the smallest cam, without limit towards half the lever's swing.
    """

    def goes_round(centre: complex) -> bool:
        distance = math.inf if isinstance(layout.guide, OscillatingRoller) else -centre.real
        return abs(layout.ends[0] - centre) >= base and distance >= _LEAST_DISTANCE

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
        raise RunError("no cam round a shaft of that radius was found: permit a smaller one")
    return found


def _described(layout: Layout, centre: complex) -> SmallestCam:
    """The cam whose centre is O, turned and moved so that O is 0 and the pivot on +x, or the rod along +x."""
    guide = layout.guide
    follower: OscillatingRoller | TranslatingRoller
    if isinstance(guide, OscillatingRoller):
        angle = math.remainder(math.pi - float(np.angle(centre)), TURN)
        follower = replace(guide, pivot=abs(centre), angle=angle)
    else:
        follower = replace(guide, distance=-centre.real, offset=-centre.imag)
    cam = RollerCam(layout.law, follower, layout.clockwise)

    def spare(phi: np.ndarray) -> np.ndarray:
        return np.asarray(np.arctan(layout.cones(phi)[2]) - np.abs(cam.pressure_angle(phi)))

    at, spares = valleys(spare)
    largest = -float(valleys(lambda phi: -np.abs(cam.pressure_angle(phi)))[1].min())
    sharpest, bends = valleys(lambda phi: -cam.pitch_curvature(phi))
    k = int(np.argmin(bends))
    radius = -1 / float(bends[k]) - guide.roller_radius if bends[k] < 0 else math.inf
    near, far = (abs(end - centre) for end in layout.ends)
    binding = tuple(float(x) for x in np.sort(at[spares < _MET]))
    return SmallestCam(follower, near, far, largest, binding, radius, float(sharpest[k]))
