"""The smallest cam for what is permitted."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

from wucht.cams.cam import FlatFacedCam
from wucht.cams.drive import CamDrive
from wucht.cams.followers import OscillatingRoller
from wucht.cams.laws.law import Law
from wucht.cams.sizing.smallest_cam import (
    Size,
    SmallestCam,
    SmallestFlatFacedCam,
    smallest_flat_faced_cam,
    smallest_lever_cam,
    smallest_rod_cam,
)
from wucht.cams.tables.follower import FlatFacedTable, FollowerTable, OscillatingRollerTable, TranslatingRollerTable
from wucht.cams.undercut import check_roller
from wucht.errors import InputError
from wucht.studies.cam_contour.shapes import millimetres
from wucht.studies.cam_contour.spec import Permitted

Smallest = SmallestCam | SmallestFlatFacedCam


def smallest_cam(law: Law, follower: FollowerTable | None, permitted: Permitted | None, size: Size) -> Smallest | None:
    """Of the follower's law; None where nothing is permitted that it could be found by.

    Where no least radius is permitted nothing is to be undercut, and without a shaft the base circle is not to be negative.
    Raises ``InputError`` (study.permitted...), ``RunError``.
    """
    if permitted is None:
        return None
    try:
        if isinstance(follower, FlatFacedTable):
            return _of_face(law, follower, permitted)
        return _of_roller(law, follower, permitted, size)
    except InputError as error:
        raise error.within("study.permitted") if error.where in Permitted.model_fields else error from None


def _of_face(law: Law, follower: FlatFacedTable, permitted: Permitted) -> SmallestFlatFacedCam | None:
    radius, shaft = permitted.least_radius, permitted.shaft_radius
    if permitted.pressure_angle is not None:
        raise InputError("pressure_angle", None, "a flat face has none: its cam is found by least_radius or shaft_radius")
    if radius is None and shaft is None:
        return None
    return smallest_flat_faced_cam(law, radius or 0.0, clockwise=follower.clockwise, shaft_radius=shaft or 0.0)


def _of_roller(law: Law, follower: FollowerTable | None, permitted: Permitted, size: Size) -> SmallestCam | None:
    angle, radius, shaft = permitted.pressure_angle, permitted.least_radius or 0.0, permitted.shaft_radius or 0.0
    if angle is None:
        return None
    if isinstance(follower, OscillatingRollerTable):
        return smallest_lever_cam(
            law, follower.arm, follower.roller_radius, angle, clockwise=follower.clockwise,
            outward=_outward(law, follower.follower()), least_radius=radius, shaft_radius=shaft, smallest=size,
        )  # fmt: skip
    if isinstance(follower, TranslatingRollerTable):
        return smallest_rod_cam(
            law, follower.roller_radius, angle, clockwise=follower.clockwise,
            least_radius=radius, shaft_radius=shaft, smallest=size,
        )  # fmt: skip
    return None


def placed(found: Smallest) -> dict[str, float]:
    """The keys of the follower that make it the smallest cam, in SI."""
    return {key: value for key, value in asdict(found.follower).items() if key not in ("arm", "roller_radius")}


def obstacles(drive: CamDrive, output: Law, found: Smallest) -> list[str]:
    """What must be known before the smallest cam is made, in sentences. output: the law that it is to make."""
    told, follower = list[str](), drive.follower
    if isinstance(follower, OscillatingRollerTable) and follower.counter is not None:
        told.append(
            "the smallest cam is that of the main lever: for its pivot the lever of the counter cam must be chosen anew"
        )
        follower = follower.model_copy(update={"counter": None})
    if follower is None:
        return told
    made = replace(drive, follower=follower.model_copy(update=placed(found)))
    try:
        for cam in made.cams(output).values():
            if not isinstance(cam, FlatFacedCam):
                check_roller(cam, millimetres)
    except InputError as error:
        told.append(f"the smallest cam that is permitted cannot be made: {error.allowed}")
    return told


def _outward(law: Law, lever: OscillatingRoller) -> bool:
    """Whether the roller goes out as the law rises."""
    return math.sin(lever.angle + float(law(0.0))) < 0
