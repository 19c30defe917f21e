"""The DC motor by its catalogue: nominal voltage, stall torque, no-load speed."""

from __future__ import annotations

from typing import Any

import sympy as sp
from pydantic import model_validator

from wucht.machines.parts.base import SI, Drive, si


class DC(Drive):
    """A DC motor with permanent magnets by nominal voltage, stall torque and no-load speed. A negative voltage reverses it.

    T = T_s (U/U_n - w/w_0): the line through the stall torque and the no-load speed at the nominal voltage, shifted by another
    one. It is that of a motor with k Phi = U_n/w_0 and R_A = U_n^2/(w_0 T_s) whose friction is in the no-load speed
    (A. E. Fitzgerald et al., Electric Machinery, chapter 7); MuJoCo takes a ``dcmotor`` by the same three numbers.
    """

    kind = "dc"

    nominal_voltage: SI[float] = si("V", "nominal voltage", "U_n", gt=0, help="voltage for which the data sheet holds")
    stall_torque: SI[float] = si("N m", "stall torque", "T_s", gt=0, help="torque at standstill and the nominal voltage")
    no_load_speed: SI[float] = si("rad/s", "no-load speed", "w_0", gt=0, help="speed without load at the nominal voltage")
    voltage: SI[float | None] = si("V", "voltage of the armature", "U_A", default=None, help=(
        "voltage of the armature, by default the nominal one; a negative one reverses the motor"
    ))  # fmt: skip

    @model_validator(mode="before")
    @classmethod
    def _nominal_by_default(cls, table: Any) -> Any:
        if not isinstance(table, dict) or table.get("voltage") is not None or "nominal_voltage" not in table:
            return table
        return {**table, "voltage": table["nominal_voltage"]}

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """T_s (U/U_n - w/w_0)."""
        nominal, stall, no_load, U = self.symbols("nominal_voltage", "stall_torque", "no_load_speed", "voltage")
        return stall * (U / nominal - speed / no_load)

    def circuit_loss(self, speed: sp.Expr) -> sp.Expr:
        """Return the heat in the armature, R_A I_A^2, of the motor whose line this is."""
        nominal, stall, no_load, U = self.symbols("nominal_voltage", "stall_torque", "no_load_speed", "voltage")
        return stall * no_load * (U / nominal - speed / no_load) ** 2
