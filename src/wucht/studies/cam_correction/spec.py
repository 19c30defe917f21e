"""The question of a cam's correction."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from wucht.schema import Described, si
from wucht.studies.spec import Spec, Whole

_MOST_ORDERS = 250
Count = Annotated[Whole, Field(ge=1, le=_MOST_ORDERS)]


class Acceleration(Described):
    """A record of the acceleration of the output, to compare with.

    file, column: of the record; a column without a unit is in rad/s^2, or m/s^2 of an output that slides. unit: of the column's
    numbers, instead of the one that the file states. scale: a factor for them, such as -1. orders: how many are fitted to it.
    cam: with which one it was measured. zero: the time on the record's clock at which the cam angle is zero; by default that of
    the record of the speed, or 0 s. radius: of a sensor that measures along a circle about the output's axis.
    """

    file: str = Field(min_length=1, description="file of the record")
    column: str = Field(min_length=1, description="column of the record")
    unit: str | None = Field(None, min_length=1, description="unit of the column's numbers")
    scale: float | None = si("", "factor for the column's numbers", default=None)
    orders: Count | None = Field(None, description="number of orders")
    cam: Literal["original", "corrected"] = Field("original", description="cam with which it was measured")
    zero: float | None = si("s", "time at which the cam angle is zero", default=None)
    radius: float | None = si("m", "distance of the sensor from the output's axis", default=None, gt=0)


class CamCorrection(Spec):
    """The cam that gives the output its motion law over time although the camshaft does not turn evenly.

    points: cam angles, evenly spaced over a turn, at which cam table and contours are given. orders: how many are shown; by
    default three times those of the law. acceleration: a record to compare with. chord_tolerance, decimals: of lists for the
    workshop: what the chords between the points, and coordinates rounded to so many decimals of a mm, leave is looked at.
    """

    kind: ClassVar[str] = "cam-correction"
    solves: ClassVar[str] = "rigid parts; the camshaft turns as its table [speed] says"
    subject: ClassVar[str] = "wucht.studies.cam_drives:CAM_DRIVE"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("cam_angle", "moved"), ("cam_angle", "pressure_angle"))
    headline: ClassVar[tuple[str, ...]] = ("min_curvature_radius", "max_pressure_angle")

    points: Whole = Field(1440, ge=36, le=20_000, description="number of cam angles")
    orders: Count | None = Field(None, description="number of orders shown")
    acceleration: Acceleration | None = Field(None, description="record of the output's acceleration")
    chord_tolerance: float = si("m", "chord tolerance", default=1e-6, gt=0)
    decimals: Whole = Field(5, ge=0, le=12, description="number of decimals in mm")

    def asked_of(self, subject: Any) -> dict[str, Any]:
        """See ``Spec``: a changed record of the acceleration is another question."""
        asked = self.asked()
        if self.acceleration is not None:
            asked["acceleration"]["contents"] = subject.contents(self.acceleration.file)
        return asked
