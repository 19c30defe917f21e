"""A prescribed motion of the carrier."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import sympy as sp
from pydantic import Field, ValidationInfo, field_validator, model_validator

from wucht.errors import FieldError
from wucht.piecewise import Pieces, PiecewiseCubic, interpolated
from wucht.schema import Described, Parameter, Unit, is_pairs, si
from wucht.system import TIME

SHAKING = sp.symbols("carrier.motion.amplitude carrier.motion.frequency", real=True)


class PrescribedMotion(Described):
    """x = amplitude cos(frequency t), 001 (13), or a measured displacement as points (time, displacement).

    Between points the displacement is a cubic spline, so that its velocity and acceleration are continuous; before the first
    and after the last it holds still, so the spline begins and ends with zero velocity.
    """

    direction: Literal["x", "y", "r"] = Field(title="direction", description="direction of the motion, r: of the rotation")
    amplitude: float | None = si("m", "amplitude", "x_0", None, help="amplitude of a harmonic motion, in direction r an angle")
    frequency: float | None = si("rad/s", "angular frequency", "Omega", None, gt=0, help="frequency of a harmonic motion")
    points: tuple[tuple[float, float], ...] | None = Field(
        None, min_length=4, title="points (time, displacement)", description="points (time, displacement) of a measured motion"
    )

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, given: Any, info: ValidationInfo) -> Any:
        """Amplitude and displacements are lengths, in direction r angles; points may have units."""
        length, name = "rad" if info.data.get("direction") == "r" else "m", info.field_name
        if given is None or name == "direction":
            return given
        if name != "points":
            return (Unit("rad/s", "angular frequency") if name == "frequency" else Unit(length, "amplitude")).parse(given)
        if not is_pairs(given):
            raise ValueError("must be points = [[time, displacement], ...]")
        units = Unit("s", "time"), Unit(length, "displacement")
        return [[u.parse(x) for u, x in zip(units, point, strict=True)] for point in given]

    @model_validator(mode="after")
    def _one_of_both(self) -> PrescribedMotion:
        given = [self.amplitude is not None, self.frequency is not None, self.points is not None]
        if given not in ([True, True, False], [False, False, True]):
            sentence = "give amplitude and frequency, or table = FILE (points = [[time, displacement], ...])"
            raise FieldError(sentence, code="either-or")
        if self.points is not None and any(b[0] <= a[0] for a, b in zip(self.points, self.points[1:], strict=False)):
            raise ValueError("must be points whose times increase")
        return self

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """Amplitude and frequency; the amplitude in direction r is an angle."""
        length = "rad" if self.direction == "r" else "m"
        return tuple(replace(p, unit=length if p.unit == "m" else p.unit) for p in super().parameters_at(path))

    def velocity(self) -> sp.Expr:
        """The velocity over time."""
        if self.points is not None:
            return PiecewiseCubic(TIME, self._spline().derivative)
        amplitude, frequency = SHAKING
        return -amplitude * frequency * sp.sin(frequency * TIME)

    def start(self) -> float:
        """The displacement at t = 0."""
        return float(self._spline()(0.0)) if self.points is not None else float(self.amplitude or 0.0)

    def _spline(self) -> Pieces:
        times, values = zip(*(self.points or ()), strict=True)
        return interpolated("motion", times, values, "spline")
