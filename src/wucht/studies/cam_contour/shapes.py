"""What the contour of a cam is like: its least radii, its pressure angle, what is cut away of it, and between which circles it
lies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import FlatFacedCam, RollerCam
from wucht.cams.undercut import RadiusAt, check_face, check_roller, cut_away, largest_wheel
from wucht.errors import InputError
from wucht.numerics.valleys import Arc, arcs_below_zero, valleys
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
    centre. undercut: arcs on which the contour runs backwards; missing: arcs that are cut away, those among them.
    largest_roller: with which nothing would be missing, None of a flat face. wheel: the largest that reaches all of the
    contour, None where nothing is hollow or some is missing.
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
            own = "follower.counter.roller_radius"
            if name == "counter" and error.where == "follower.roller_radius":
                raise InputError(own, error.given, error.allowed) from None
            raise
    return found


def _of_roller(cam: RollerCam, spec: CamContour, name: str) -> Shape:
    left = cut_away(cam)
    sound = cam.follower.roller_radius < left.largest_roller
    if not sound and not spec.allow_undercut:
        check_roller(cam)
    wheel = largest_wheel(cam) if sound and left.hollow is not None else None
    if spec.wheel_radius is not None and wheel is not None and spec.wheel_radius > wheel.radius:
        where = f"{name} is too hollow for it at a cam angle of {np.degrees(wheel.phi):.4g} deg"
        largest = f"it must be less than {1e3 * wheel.radius:.6g} mm"
        raise InputError("study.wheel_radius", f"{1e3 * spec.wheel_radius:.6g} mm", f"{where}: {largest}")
    return Shape(
        left.convex, left.hollow, *_extremes(cam), left.undercut, left.missing, left.largest_roller, wheel,
    )  # fmt: skip


def _of_flat_face(cam: FlatFacedCam, spec: CamContour) -> Shape:
    if not spec.allow_undercut:
        check_face(cam)
    undercut = arcs_below_zero(cam.radius)
    at, radii = valleys(lambda phi: np.where(cam.radius(phi) > 0, cam.radius(phi), np.inf))
    k = int(np.argmin(radii))
    return Shape(RadiusAt(float(radii[k]), float(at[k])), None, *_extremes(cam), undercut, undercut, None, None)


def _extremes(cam: AnyCam) -> tuple[Extreme, Extreme, Extreme]:
    """The largest pressure angle, the least and the largest radius."""
    angle = _least(lambda phi: -np.abs(cam.pressure_angle(phi)))
    blank = _least(lambda phi: -np.abs(cam.contour(phi)))
    return Extreme(-angle.value, angle.phi), _least(lambda phi: np.abs(cam.contour(phi))), Extreme(-blank.value, blank.phi)


def _least(function: RealFunction) -> Extreme:
    at, values = valleys(function)
    k = int(np.argmin(values))
    return Extreme(float(values[k]), float(at[k]))
