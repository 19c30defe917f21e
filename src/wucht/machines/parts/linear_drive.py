"""The drive whose torque falls linearly with speed."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, Drive, si


class LinearDrive(Drive):
    """torque = slope (no_load_speed - speed). Drozdetskaya (2.94), (3.27), (4.5)."""

    kind = "linear"

    slope: SI[float] = si("N m s", "slope of the torque-speed curve", "b_M", ge=0)
    no_load_speed: SI[float] = si("rad/s", "no-load speed", "omega_0", help="speed at which the torque is zero")

    def no_load_path(self) -> str:
        """Return the path of ``no_load_speed``."""
        return f"{self.path}.no_load_speed"

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.94)."""
        slope, no_load = self.symbols("slope", "no_load_speed")
        return slope * (no_load - speed)
