"""The load of a viscous fluid or a generator on a resistor."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, Load, si


class ViscousLoad(Load):
    """torque = coefficient * speed."""

    kind = "viscous"

    coefficient: SI[float] = si("N m s", "coefficient of the load", "k_1", ge=0)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """Proportional to the speed."""
        return self.symbol("coefficient") * speed
