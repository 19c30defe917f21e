"""What the contour of a cam is like: its least radii, its pressure angle, what is cut away of it, and between which circles it
lies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import FlatFacedCam, RollerCam
from wucht.cams.undercut import CutAway, RadiusAt, check_face, check_roller, cut_away, cut_away_by_face, largest_wheel
from wucht.errors import InputError
from wucht.numerics.valleys import GRID, Arc, valleys
from wucht.numerics.zeros import RealFunction
from wucht.studies.cam_contour.spec import CamContour

_CALLED = {"cam": "the cam", "counter": "the counter cam", "outer": "the outer flank"}
AnyCam = RollerCam | FlatFacedCam


@dataclass(frozen=True)
class Extreme:
    """value: the largest or the least. phi: the cam angle in rad at which it is reached."""

    value: float
    phi: float


@dataclass(frozen=True)
class Shape:
    """Lengths in m, angles in rad.

    convex, hollow: the least radius of curvature where the material bulges and where it is hollow, None where it is nowhere.
    pressure_angle: the largest, as a magnitude. base, blank: the least and the largest distance of the contour from the cam's
    centre. Radii are those of what is left. undercut: arcs on which the contour runs backwards; missing: arcs that are cut
    away, those among them. largest_roller: with which nothing would be missing, infinite where every roller will do, None of a
    flat face. wheel: the largest that reaches all of the contour, None where every wheel does, or some is missing.
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


def shapes(cams: Mapping[str, AnyCam], spec: CamContour) -> dict[str, Shape]:
    """Of each cam. Raises ``InputError`` (follower..., study.wheel_radius) where one cannot be made."""
    found: dict[str, Shape] = {}
    for name, cam in cams.items():
        try:
            found[name] = _of_flat_face(cam, spec) if isinstance(cam, FlatFacedCam) else _of_roller(cam, spec, _CALLED[name])
        except InputError as error:
            counters = name == "counter" and error.where == "follower.roller_radius"
            where = "follower.counter.roller_radius" if counters else error.where
            given = millimetres(error.given) if isinstance(error.given, float) else error.given
            raise InputError(where, given, error.allowed) from None
    return found


def millimetres(length: float) -> str:
    """A length in m, for the user."""
    return f"{1e3 * length:.6g} mm"


def _of_roller(cam: RollerCam, spec: CamContour, name: str) -> Shape:
    left = cut_away(cam)
    sound = cam.follower.roller_radius < left.largest_roller
    if not sound and (not spec.allow_undercut or _nothing_is_left(left)):
        check_roller(cam, millimetres)
    wheel = largest_wheel(cam) if sound and left.hollow is not None else None
    if spec.wheel_radius is not None and wheel is not None and spec.wheel_radius > wheel.radius:
        where = f"{name} is too hollow for it at a cam angle of {np.degrees(wheel.phi):.4g} deg"
        raise InputError("study.wheel_radius", spec.wheel_radius, f"{where}: it must be less than {millimetres(wheel.radius)}")
    return _shape(cam, left, left.largest_roller, wheel)


def _of_flat_face(cam: FlatFacedCam, spec: CamContour) -> Shape:
    left = cut_away_by_face(cam)
    if not spec.allow_undercut or _nothing_is_left(left):
        check_face(cam, millimetres)
    return _shape(cam, left, None, None)


def _nothing_is_left(left: CutAway) -> bool:
    return bool(left.is_missing(GRID).all())


def _shape(cam: AnyCam, left: CutAway, largest_roller: float | None, wheel: RadiusAt | None) -> Shape:
    beyond = 2 * float(np.abs(cam.contour(GRID)).max())

    def distance(phi: np.ndarray, missing: float) -> np.ndarray:
        return np.where(left.is_missing(phi), missing, np.abs(cam.contour(phi)))

    angle = _least(lambda phi: -np.abs(cam.pressure_angle(phi)))
    base, blank = _least(lambda phi: distance(phi, beyond)), _least(lambda phi: -distance(phi, 0.0))
    return Shape(
        convex=left.convex,
        hollow=left.hollow,
        pressure_angle=Extreme(-angle.value, angle.phi),
        base=base,
        blank=Extreme(-blank.value, blank.phi),
        undercut=left.undercut,
        missing=left.missing,
        largest_roller=largest_roller,
        wheel=wheel,
    )


def _least(function: RealFunction) -> Extreme:
    at, values = valleys(function)
    k = int(np.argmin(values))
    return Extreme(float(values[k]), float(at[k]))
