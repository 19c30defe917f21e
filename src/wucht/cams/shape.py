"""Properties by which the contour of a cam is assessed: its least radii, its pressure angle, the arcs that are cut away, and
the circles between which it lies."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.demands import format_millimetres
from wucht.cams.undercut import RadiusAt
from wucht.errors import InputError
from wucht.numerics.angles import GRID, Arc, valleys
from wucht.numerics.zeros_and_peaks import RealFunction

CAM_LABELS = {"cam": "cam", "counter": "counter cam", "outer": "outer flank"}
_GUIDES = {"rad": "lever", "m": "rod"}
COMMON = {"rad": math.radians(45), "m": math.radians(30)}  # pressure angles, at most, of followers that turn or slide


@dataclass(frozen=True)
class Extreme:
    """value: the largest or the least. phi: the cam angle in rad at which it is reached."""

    value: float
    phi: float


@dataclass(frozen=True)
class Shape:
    """Properties by which the contour of a cam is assessed; lengths in m, angles in rad.

    Attributes
    ----------
    convex, hollow : RadiusAt or None
        The least radius of curvature where the material bulges and where it is hollow, None where it is nowhere. These radii
        are of the remaining contour.
    pressure_angle : Extreme
        The largest, as a magnitude.
    base, blank : Extreme
        The least and the largest distance of the contour from the cam's centre.
    undercut : tuple of (float, float)
        Arcs on which the contour runs backwards.
    missing : tuple of (float, float)
        Arcs that are cut away, those among them.
    largest_roller : float or None
        With which nothing would be missing, infinite where every roller will do, None of a flat face.
    wheel : RadiusAt or None
        The largest that reaches all of the contour, None where every wheel does, or some is missing.
    part : str
        The element of the follower that touches the contour, as one word.
    face_length : float or None
        The least length of a flat face, None of other followers.
    """

    convex: RadiusAt | None
    hollow: RadiusAt | None
    pressure_angle: Extreme
    base: Extreme
    blank: Extreme
    undercut: tuple[Arc, ...]
    missing: tuple[Arc, ...]
    largest_roller: float | None
    wheel: RadiusAt | None
    part: str
    face_length: float | None = None


def shapes(cams: Mapping[str, Cam], *, allow_undercut: bool = False, wheel_radius: float | None = None) -> dict[str, Shape]:
    """Return the shape of each cam.

    Parameters
    ----------
    cams : mapping of str to Cam
        As ``follower.make_cams(law)`` returns them.
    allow_undercut : bool, optional
        Accept a contour that is partly cut away.
    wheel_radius : float, optional
        Of a grinding wheel that must reach all of the contours, in m.

    Returns
    -------
    dict of str to Shape

    Raises
    ------
    InputError
        (follower..., wheel_radius) Where one cannot be made.
    """
    result: dict[str, Shape] = {}
    for name, cam in cams.items():
        try:
            result[name] = _shape(cam, CAM_LABELS[name], allow_undercut, wheel_radius)
        except InputError as error:
            counters = name == "counter" and error.location == "follower.roller_radius"
            location = "follower.counter.roller_radius" if counters else error.location
            value = format_millimetres(error.value) if isinstance(error.value, float) else error.value
            raise InputError(location, value, error.explanation) from None
    return result


def _shape(cam: Cam, name: str, allow_undercut: bool, wheel_radius: float | None) -> Shape:
    cut_away, roller = cam.cut_away(), cam.roller_radius
    sound = roller is not None and roller < cut_away.largest_roller
    if not sound and (not allow_undercut or cut_away.is_missing(GRID).all()):
        cam.check(format_millimetres)
    wheel = cam.largest_wheel() if sound and cut_away.hollow is not None else None
    if wheel_radius is not None and wheel is not None and wheel_radius > wheel.radius:
        fault = f"the {name} is too hollow for it at a cam angle of {np.degrees(wheel.phi):.4g} deg"
        raise InputError("wheel_radius", wheel_radius, f"{fault}: it must be less than {format_millimetres(wheel.radius)}")
    beyond = 2 * float(np.abs(cam.contour(GRID)).max())

    def distance(phi: np.ndarray, missing: float) -> np.ndarray:
        return np.where(cut_away.is_missing(phi), missing, np.abs(cam.contour(phi)))

    angle = _least(lambda phi: -np.abs(cam.pressure_angle(phi)))
    base, blank = _least(lambda phi: distance(phi, beyond)), _least(lambda phi: -distance(phi, 0.0))
    return Shape(
        convex=cut_away.convex,
        hollow=cut_away.hollow,
        pressure_angle=Extreme(-angle.value, angle.phi),
        base=base,
        blank=Extreme(-blank.value, blank.phi),
        undercut=cut_away.undercut,
        missing=cut_away.missing,
        largest_roller=None if roller is None else cut_away.largest_roller,
        wheel=wheel,
        part=cam.part,
        face_length=None if cam.face is None else cam.face[1] - cam.face[0],
    )


def _least(function: RealFunction) -> Extreme:
    at, values = valleys(function)
    k = int(np.argmin(values))
    return Extreme(float(values[k]), float(at[k]))


def pressure_angle_remarks(shapes: Iterable[Shape], unit: str) -> list[str]:
    """Return a remark where a pressure angle is larger than usual. unit: of the follower's motion, rad or m."""
    angle, common = largest_pressure_angle(shapes), COMMON[unit]
    if angle.value <= common:
        return []
    statement = f"the pressure angle reaches {format_cam_angle(angle.value)} at a cam angle of {format_cam_angle(angle.phi)}"
    hint = "study.permitted finds the smallest cam for it"
    return [f"{statement}; with a {_GUIDES[unit]}, at most {format_cam_angle(common)} is common ({hint})"]


def largest_pressure_angle(shapes: Iterable[Shape]) -> Extreme:
    """Return the largest pressure angle of all cams."""
    return max((s.pressure_angle for s in shapes), key=lambda extreme: extreme.value)


def least_convex_radius(shapes: Iterable[Shape]) -> RadiusAt | None:
    """Return the least radius of curvature of all cams where they are convex; None where they are nowhere."""
    return min((s.convex for s in shapes if s.convex is not None), key=lambda at: at.radius, default=None)


def format_cam_angle(angle: float) -> str:
    """Return a cam angle in rad as text for the user."""
    turns = math.degrees(angle)
    return f"{turns if turns <= 360 else turns - 360:.4g}°"
