"""The smallest cam for what is permitted."""

from __future__ import annotations

import math

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
from wucht.errors import InputError
from wucht.studies.cam_contour.spec import Permitted

Smallest = SmallestCam | SmallestFlatFacedCam


def smallest_cam(law: Law, follower: FollowerTable | None, permitted: Permitted | None, size: Size) -> Smallest | None:
    """Of the follower's law; None where nothing is permitted that it could be found by.

    Where no least radius is permitted, nothing is to be undercut. Raises ``InputError`` (study.permitted...), ``RunError``.
    """
    if permitted is None:
        return None
    angle, radius = permitted.pressure_angle, permitted.least_radius
    try:
        if isinstance(follower, FlatFacedTable):
            if angle is not None:
                raise InputError("pressure_angle", None, "a flat face has none: its cam is found by least_radius")
            return None if radius is None else smallest_flat_faced_cam(law, radius, clockwise=follower.clockwise)
        if angle is None:
            return None
        if isinstance(follower, OscillatingRollerTable):
            return smallest_lever_cam(
                law, follower.arm, follower.roller_radius, angle, clockwise=follower.clockwise,
                outward=_outward(law, follower.follower()), least_radius=radius or 0.0, smallest=size,
            )  # fmt: skip
        if isinstance(follower, TranslatingRollerTable):
            return smallest_rod_cam(
                law, follower.roller_radius, angle, clockwise=follower.clockwise, least_radius=radius or 0.0, smallest=size
            )
    except InputError as error:
        raise error.within("study.permitted") if error.where in ("pressure_angle", "least_radius") else error from None
    return None


def _outward(law: Law, lever: OscillatingRoller) -> bool:
    """Whether the roller goes out as the law rises."""
    return math.sin(lever.angle + float(law(0.0))) < 0
