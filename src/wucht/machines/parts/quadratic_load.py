"""The load of a fan or a pump."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, Load, si
from wucht.piecewise import Pieces, PiecewiseCubic

# w |w|, with the breakpoint of its second derivative taken exactly.
SIGNED_SQUARE = Pieces("signedsquare", (0.0,), ((0, 0, -1, 0), (0, 0, 1, 0)))


class QuadraticLoad(Load):
    """torque = coefficient * speed * abs(speed)."""

    kind = "quadratic"

    coefficient: SI[float] = si("N m s^2", "coefficient of the load", "k_2", ge=0)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """Return a torque proportional to the square of the speed, against it."""
        return self.symbol("coefficient") * PiecewiseCubic(speed, SIGNED_SQUARE)
