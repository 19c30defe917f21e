"""The question of a prediction."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.schema import si
from wucht.studies.spec import Interval, Spec, Whole


class CamPrediction(Spec):
    """How a camshaft turns with its output, its drive and its loads, and the cam that is clean on it, without a measurement.

    points: of the time of a turn, and of the cam angle, evenly spaced. orders: N of a law that has no end of harmonics: those
    above are looked at, what the law itself has of them being as clean as it gets. cuts: how many cams are tried that are cut
    one after the other, each for the speed measured with the one before. simulate: turns of the simulation in time that
    confirms the prediction, 0 for none.

    With an elastic output: speeds: range of the mean speed over which the vibration in the dwell is shown, by default from half
    the mean speed to one and a half times it; speed_points: in it. dwell: begin and end of where the output is to rest; by
    default the arcs on which the law says so.
    """

    kind: ClassVar[str] = "cam-prediction"
    subject: ClassVar[str] = "wucht.studies.cam_drives:CAM_DRIVE"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("tau", "speed"), ("tau", "drive_torque"))
    headline: ClassVar[tuple[str, ...]] = ("fluctuation", "mean_power")

    points: Whole = Field(720, ge=16, le=100_000, description="number of points of a turn")
    orders: Whole = Field(20, ge=1, le=200, description="number of harmonics of a law without end")
    cuts: Whole = Field(5, ge=0, le=50, description="number of cams cut one after the other")
    simulate: Whole = Field(20, ge=0, le=1000, description="number of turns that are simulated")
    speeds: Interval | None = si("rad/s", "mean speed", default=None)
    speed_points: Whole = Field(160, ge=2, le=10_000, description="number of speeds")
    dwell: Interval | None = si("rad", "begin and end of the dwell", default=None)
