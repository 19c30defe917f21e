"""The drive that enforces a speed at any torque."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, Drive, si


class ConstantSpeed(Drive):
    """The body turns with a prescribed constant speed. The required torque is a result: Sperling et al., rollers (19)."""

    kind = "constant-speed"

    speed: SI[float] = si("rad/s", "speed", "Omega", help="speed with which the body turns, signed")
    angle: SI[float] = si("rad", "angle at t = 0", "phi_0", default=0.0)

    def prescribed_speed(self) -> sp.Expr:
        """The speed."""
        return self.symbol("speed")
