"""Spec of the study of a cam's correction."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from wucht.schema import SI, Composite, TableModel, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import Spec, Whole

MOST_ORDERS = 250
Count = Annotated[Whole, Field(ge=1, le=MOST_ORDERS)]


class Acceleration(TableModel):
    """Record of the acceleration of the output, for comparison."""

    file: str = Field(min_length=1, description="file of the record")
    column: str = Field(min_length=1, title="column of the record", description=(
        "column of the record; without a unit it is in rad/s^2, or m/s^2 of an output that slides"
    ))  # fmt: skip
    unit: str | None = Field(default=None, min_length=1, title="unit of the column's numbers", description=(
        "unit of the column's numbers, instead of the one that the file states"
    ))  # fmt: skip
    scale: SI[float | None] = si(
        "", "factor for the column's numbers", default=None, help="factor for the column's numbers, such as -1"
    )
    orders: Count | None = Field(default=None, title="number of orders", description="number of orders fitted to the record")
    cam: Literal["original", "corrected"] = Field(default="original", description="cam of the measurement")
    zero: SI[float | None] = si("s", "time at which the cam angle is zero", default=None, help=(
        "time on the record's clock at which the cam angle is zero; by default that of the record of the speed, or 0 s"
    ))  # fmt: skip
    radius: SI[float | None] = si("m", "distance of the sensor from the output's axis", default=None, gt=0, help=(
        "distance of the sensor from the output's axis, where it measures along a circle about this axis"
    ))  # fmt: skip


class CamCorrection(Spec):
    """Cam that gives the output its motion law over time although the camshaft does not turn evenly."""

    kind: ClassVar[str] = "cam-correction"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("the cam that does it, checked and ready to mill", {"study.kind": "cam-contour"}),
    )
    solves: ClassVar[str] = "rigid parts; the camshaft turns as its table [speed] says"
    subject: ClassVar[str] = "wucht.studies.cam_drives:CAM_DRIVE"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("cam_angle", "moved"), ("cam_angle", "pressure_angle"))

    points: Whole = Field(default=1440, ge=36, le=20_000, description=(
        "number of cam angles, evenly spaced over a turn, at which cam table and contours are given"
    ))  # fmt: skip
    orders: Count | None = Field(
        default=None,
        title="number of orders shown",
        description=(
            "number of orders shown; by default three times those of the law, and all that are not negligible with the "
            "original cam; the summary lists these in any case"
        ),
    )
    acceleration: Composite[Acceleration | None] = composite(
        default=None, description="record of the output's acceleration to compare with, a table `[study.acceleration]`"
    )
    chord_tolerance: SI[float] = si("m", "chord tolerance", default=1e-6, gt=0, help=(
        "chord tolerance of lists for the workshop: the residual with chords between their points is computed"
    ))  # fmt: skip
    decimals: Whole = Field(default=5, ge=0, le=12, description=(
        "number of decimals in mm of lists for the workshop: the residual with coordinates rounded so is computed"
    ))  # fmt: skip

    def table_for(self, subject: Any) -> dict[str, Any]:
        """Return the question, see ``Spec``: a changed record of the acceleration is another one."""
        question = self.to_table()
        if self.acceleration is not None:
            question["acceleration"]["contents"] = subject.contents(self.acceleration.file)
        return question
