"""The synchronous motor: the speed of the mains at any torque."""

from __future__ import annotations

from typing import Literal

import sympy as sp
from pydantic import Field

from wucht.errors import FieldError
from wucht.machines.parts.base import SI, Drive, si


class Synchronous(Drive):
    """The body turns with the prescribed speed 2 pi f/p: the ideal kinematic characteristic. Drozdetskaya (2.80).

    The required torque is a result.
    """

    kind = "synchronous"

    frequency: SI[float] = si("Hz", "frequency of the mains", "f", ge=0)
    pole_pairs: SI[float] = si("", "number of pole pairs", "p", ge=1)
    angle: SI[float] = si("rad", "angle at t = 0", "phi_0", default=0.0)
    sense: Literal[1, -1] = Field(default=1, description="sense of rotation; -1 turns the body backwards")

    def check(self) -> None:
        """Check for a whole number of pole pairs."""
        if self.pole_pairs != round(self.pole_pairs):
            raise FieldError("pole_pairs", "must be a whole number of pole pairs", code="whole-number")

    def prescribed_speed(self) -> sp.Expr:
        """The synchronous speed: below 002 (2.106)."""
        return self.sense * 2 * sp.pi * self.symbol("frequency") / self.symbol("pole_pairs")
