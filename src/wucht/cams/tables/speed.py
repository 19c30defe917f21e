"""The table [speed] of a cam file: the uneven speed of the camshaft, by coefficients or by a record."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from wucht.cams.shaft_motion import ShaftMotion, shaft_motion_over_time, with_period
from wucht.errors import InputError
from wucht.measurements.order_fit import OrderFit, checked_orders, fit_orders
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import Recording
from wucht.measurements.shaft_signal import ShaftSignal, shaft_signal
from wucht.numerics.fourier_series import FourierSeries
from wucht.schema import SI, Composite, TableModel, composite, si


class SpeedTable(TableModel):
    """The speed of the camshaft over one turn: by coefficients, or from a record."""

    mean: SI[float | None] = si("rad/s", "mean speed", default=None, gt=0, help="mean speed of the camshaft, order 0")
    cosine: SI[tuple[float, ...] | None] = si(
        "rad/s", "cosine coefficient", default=None, help="coefficients of the cosines of the speed, order 1 first"
    )
    sine: SI[tuple[float, ...] | None] = si("rad/s", "sine coefficient", default=None, help="sines of the speed, order 1 first")
    over: Literal["time", "angle"] = Field(
        default="time", description="variable of the orders: the time of a turn, or its angle, as order tracking gives them"
    )
    period: SI[float | None] = si("s", "time of a turn", default=None, gt=0, help="time of a turn, to check the mean")
    file: str | None = Field(
        default=None, title="file of the record", description="record of the speed, the angle or encoder pulses"
    )
    column: str | None = Field(default=None, description="column of the record")
    quantity: Literal["speed", "angle", "pulses"] | None = Field(default=None, description="what the column is a record of")
    unit: str | None = Field(default=None, min_length=1, title="unit of the column's numbers", description=(
        "unit of the column's numbers, instead of the one that the file states"
    ))  # fmt: skip
    scale: SI[float | None] = si("", "factor for the column's numbers", default=None, help=(
        "factor for the column's numbers; -1 where they count against the cam's rotation"
    ))  # fmt: skip
    orders: Composite[tuple[int, ...]] = composite(default=(), description="orders that are kept")
    pulses_per_turn: int | None = Field(default=None, ge=1, description="number of encoder pulses a turn")
    index: str | None = Field(default=None, description="column of the index pulse")
    hysteresis: SI[float | None] = si(
        "",
        "hysteresis of the pulses as a share of their swing",
        default=None,
        ge=0,
        lt=0.5,
        help="hysteresis of pulses recorded as a signal, as a share of its swing",
    )

    @classmethod
    def error_location(cls) -> str:
        """Return its path in a file."""
        return "speed"

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        coefficients = [key for key in ("mean", "cosine", "sine") if getattr(self, key) is not None]
        if self.file is not None and coefficients:
            raise ValueError(coefficients[0], "give either a file or coefficients")
        if self.file is None and self.mean is None:
            raise ValueError("mean", "give the mean speed with its coefficients, or file = RECORD")
        if self.file is not None and (self.column is None or not self.orders):
            raise ValueError("column" if self.column is None else "orders", "a record needs a column, and the orders to keep")
        return self

    @model_validator(mode="after")
    def _check_record(self) -> Self:
        for key in ("unit", "scale", "hysteresis"):
            if self.file is None and getattr(self, key) is not None:
                raise ValueError(key, "applies to a record: give its file, too")
        if self.scale == 0:
            raise ValueError("scale", "must not be 0: all numbers would be 0")
        if self.orders:
            try:
                checked_orders(self.orders)
            except InputError as error:
                raise ValueError("orders", error.explanation) from None
        return self

    def record_fit(self, folder: Path) -> OrderFit | None:
        """Return the orders of the record, None without one. folder: that of the cam file. Raises ``InputError``.

        Their phases count from where the cam stands at its zero: at the index pulse, where a measured angle is zero, else at
        0 s of the record.
        """
        if self.file is None or self.column is None:
            return None
        signal = self._signal(read_recording(folder / self.file), self.column)
        fit = fit_orders(signal, self.orders)
        # A speed alone does not determine the angle of the cam: its zero is then that of the record's clock.
        has_measured_zero = signal.quantity == "angle" and not len(signal.index)
        return fit.with_origin(fit.time_of_angle()) if has_measured_zero else fit

    def _signal(self, recording: Recording, column: str) -> ShaftSignal:
        """Return the signal of a column. Raises ``InputError``, for a unit at its key."""
        encoder = self.pulses_per_turn, self.index
        try:
            return shaft_signal(recording, column, self.quantity, *encoder, self.unit, self.scale, self.hysteresis)
        except InputError as error:
            if self.unit is None or error.value != self.unit:
                raise
            raise InputError("speed.unit", self.unit, error.explanation) from None

    def shaft(self, fit: OrderFit | None) -> ShaftMotion:
        """Return the motion of the shaft. Raises ``InputError`` where it stops or turns back, or the mean is not 2 pi/T."""
        if fit is not None:
            return _shaft_motion(fit)
        speed = FourierSeries.of(self.mean or 0.0, self.cosine or (), self.sine or ())
        if self.over == "angle":
            return ShaftMotion(shaft_motion_over_time(speed, max(4 * speed.count, 16)).speed.without_rounding())
        return ShaftMotion(speed) if self.period is None else with_period(speed, self.period)


def _shaft_motion(fit: OrderFit) -> ShaftMotion:
    """Return the motion with the orders of a record. Raises ``InputError`` where the shaft would stand still or turn back."""
    least = fit.speed.bounds[0]
    if not least > 0:
        requirement = (
            f"with these orders the shaft would stand still or turn back: their speed falls to {least:.4g} rad/s, of "
            f"{fit.speed.mean:.4g} rad/s on average; check the unit and the offset of the record, and the orders"
        )
        raise InputError(fit.location, None, requirement)
    return ShaftMotion(fit.speed)
