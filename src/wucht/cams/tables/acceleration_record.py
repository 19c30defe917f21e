"""The table [study.acceleration]: a record of the acceleration of the output, for comparison."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wucht.cams.drive import CamDrive
from wucht.cams.laws import Law
from wucht.cams.measured_acceleration import MeasuredAcceleration
from wucht.errors import InputError
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import Channel
from wucht.schema import SI, TableModel, Unit, si
from wucht.schema.key_values import Whole

MOST_ORDERS = 250
Count = Annotated[Whole, Field(ge=1, le=MOST_ORDERS)]
_UNITS = {"rad": Unit("rad/s^2", "angular acceleration"), "m": Unit("m/s^2", "acceleration")}


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

    def compare(self, drive: CamDrive, law: Law, default_count: int) -> MeasuredAcceleration:
        """Compare the record with the motion that the cam for a law makes. default_count: of the orders that are fitted.

        Raises ``InputError`` for a record that cannot be read, has another dimension, is shorter than a turn or has gaps, too
        few samples or no orders.
        """
        recording = read_recording(drive.folder / self.file)
        channel = self._to_si(recording.channel(self.column).correct(self.unit, self.scale), drive.motion_law.unit)
        fit = drive.speed_fit
        default_zero = 0.0 if fit is None else fit.origin
        zero = default_zero if self.zero is None else self.zero
        try:
            return MeasuredAcceleration.of(channel, self.orders or default_count, law, drive.shaft_motion, zero)
        except InputError as error:
            if error.location != "acceleration":
                raise
            raise InputError("study.acceleration.column", self.column, error.explanation) from None

    def _to_si(self, channel: Channel, unit: str) -> Channel:
        """Convert the record to the output's unit/s^2. Raises ``InputError``, at the key of the unit if that is given."""
        if self.radius is not None and unit != "rad":
            raise InputError("study.acceleration.radius", self.radius, "the output slides: there is no circle about an axis")
        try:
            channel_si = channel.to_si(_UNITS[unit if self.radius is None else "m"])
        except InputError as error:
            requirement = error.explanation
            if self.radius is None and unit == "rad" and _is_straight(channel):
                requirement = (
                    "the output turns: give study.acceleration.radius, the distance of the sensor from the output's axis"
                )
            is_given_unit = self.unit is not None and error.value == self.unit
            raise InputError("study.acceleration.unit" if is_given_unit else error.location, error.value, requirement) from None
        return channel_si if self.radius is None else channel_si.with_scale(1 / self.radius, "rad/s^2")


def _is_straight(channel: Channel) -> bool:
    """True if its unit is that of an acceleration along a path."""
    try:
        channel.to_si(_UNITS["m"])
    except InputError:
        return False
    return bool(channel.unit)
