"""The question of a motion law."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.studies.spec import Spec, Whole


class CamLaw(Spec):
    """The motion that the output of a cam drive is to make, over the cam angle."""

    kind: ClassVar[str] = "cam-law"
    solves: ClassVar[str] = "motion over the cam angle: no speed is assumed"
    subject: ClassVar[str] = "wucht.studies.cam_drives:CAM_DRIVE"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("cam_angle", "position"), ("cam_angle", "acceleration"))

    points: Whole = Field(720, ge=16, le=1_000_000, description="number of cam angles of the law, evenly spaced over a turn")
    orders: Whole = Field(20, ge=1, le=500, description="number of harmonics shown of a law that has no end of them")
