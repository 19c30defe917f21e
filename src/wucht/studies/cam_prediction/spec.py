"""Spec of the study of a prediction."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.schema import SI, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import Interval, Spec, Whole


class CamPrediction(Spec):
    """Motion of a camshaft with its output, drive and loads, and the cam that is clean on it, without a measurement."""

    kind: ClassVar[str] = "cam-prediction"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("the cam that does it, checked and ready to mill", {"study.kind": "cam-contour"}),
    )
    subject: ClassVar[str] = "wucht.studies.cam_drives:CAM_DRIVE"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("tau", "speed"), ("tau", "drive_torque"))

    points: Whole = Field(
        default=720, ge=16, le=100_000, description="number of points over the time and the cam angle of a turn"
    )
    orders: Whole = Field(default=20, ge=1, le=200, description=(
        "of a law with infinitely many orders, a third of those that the result has; all of them are compared with the law's"
    ))  # fmt: skip
    cuts: Whole = Field(default=5, ge=0, le=50, description=(
        "number of cams cut one after the other for comparison, each for the speed measured with the one before"
    ))  # fmt: skip
    simulate: Whole = Field(
        default=20, ge=0, le=1000, description="number of turns of the confirming simulation in time, 0 for none"
    )
    speeds: SI[Interval | None] = si("rad/s", "mean speed", default=None, help=(
        "range of the mean speed over which the vibration in the dwell of an elastic output is shown, by default from half the "
        "mean speed to one and a half times it"
    ))  # fmt: skip
    speed_points: Whole = Field(default=160, ge=2, le=10_000, description="number of speeds in the range `speeds`")
    dwell: SI[Interval | None] = si("rad", "start and end of the dwell", default=None, help=(
        "start and end of the arc on which an elastic output is to rest; by default the dwells of the law"
    ))  # fmt: skip
