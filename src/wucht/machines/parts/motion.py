"""A prescribed motion of the carrier."""

from __future__ import annotations

from typing import Any, Literal

import sympy as sp
from pydantic import Field, model_validator

from wucht.machines.parts.fields import Described, Parameter, si
from wucht.piecewise import Pieces, PiecewiseCubic, interpolated
from wucht.quantities import Unit
from wucht.system import TIME


class Motion(Described):
    """x = amplitude cos(frequency t), 001 (13), or a measured displacement as points (time, displacement).

    Between points the displacement is a cubic spline, so that its acceleration is continuous; before the first and after the
    last it holds still. In direction r the amplitude is an angle.
    """

    direction: Literal["x", "y", "r"] = Field(description="direction")
    amplitude: float | None = si("m", "amplitude", "x_0", None)
    frequency: float | None = si("rad/s", "angular frequency", "Omega", None, gt=0)
    points: tuple[tuple[float, float], ...] | None = Field(None, description="points (time, displacement)", min_length=4)

    @model_validator(mode="before")
    @classmethod
    def _as_angle(cls, given: Any) -> Any:
        if isinstance(given, dict) and given.get("direction") == "r" and given.get("amplitude") is not None:
            return given | {"amplitude": Unit("rad", "amplitude").parse(given["amplitude"])}
        return given

    @model_validator(mode="after")
    def _one_of_both(self) -> Motion:
        harmonic = self.amplitude is not None and self.frequency is not None
        if harmonic == (self.points is not None):
            raise ValueError("allowed is amplitude and frequency, or table = FILE (points = [[time, displacement], ...])")
        if self.points is not None and any(b[0] <= a[0] for a, b in zip(self.points, self.points[1:], strict=False)):
            raise ValueError("allowed are points whose times increase")
        return self

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """Amplitude and frequency; the amplitude in direction r is an angle."""
        found = super().parameters_at(path)
        if self.direction != "r":
            return found
        return tuple(Parameter(p.path, p.value, "rad" if p.unit == "m" else p.unit, p.symbol, p.what) for p in found)

    def velocity(self) -> sp.Expr:
        """The velocity over time."""
        if self.points is not None:
            return PiecewiseCubic(TIME, self._spline().derivative)
        amplitude, frequency = (sp.Symbol(f"carrier.motion.{n}", real=True) for n in ("amplitude", "frequency"))
        return -amplitude * frequency * sp.sin(frequency * TIME)

    def start(self) -> float:
        """The displacement at t = 0."""
        return float(self._spline()(0.0)) if self.points is not None else float(self.amplitude or 0.0)

    def _spline(self) -> Pieces:
        times, values = zip(*(self.points or ()), strict=True)
        return interpolated("motion", times, values, "spline")
