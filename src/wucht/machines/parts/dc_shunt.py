"""The DC motor with its field winding parallel to the armature."""

from __future__ import annotations

from typing import ClassVar, Literal

import sympy as sp

from wucht.machines.parts.base import Drive, si


class DCShunt(Drive):
    """A DC motor whose field and armature are fed by one source: 002 (2.95)-(2.99).

    Its no-load speed R_E/(k_M L_E) does not depend on the voltage, whose sign does not matter, as field and armature change it
    together. ``sense`` = -1 is the motor with its field reconnected: it turns backwards.
    """

    kind: ClassVar[str] = "dc-shunt"

    voltage: float = si("V", "voltage", "U")
    armature_resistance: float = si("ohm", "resistance of the armature", "R_A", gt=0)
    field_resistance: float = si("ohm", "resistance of the field circuit", "R_E", gt=0)
    field_inductance: float = si("H", "inductance of the field winding", "L_E", gt=0)
    motor_constant: float = si("", "motor constant", "k_M", gt=0)
    sense: Literal[1, -1] = 1

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.99)."""
        U, RA, RE, L, k = self.symbols(
            "voltage", "armature_resistance", "field_resistance", "field_inductance", "motor_constant"
        )
        return k * L * U**2 / (RA * RE**2) * (self.sense * RE - k * L * speed)
