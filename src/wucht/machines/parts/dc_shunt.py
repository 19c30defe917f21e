"""The DC motor with its field winding parallel to the armature."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, si
from wucht.machines.parts.dc_series import SelfExcited


class DCShunt(SelfExcited):
    """A DC motor whose field and armature are fed by one source. Drozdetskaya (2.95)-(2.99).

    Its no-load speed R_E/(k_M L_E) does not depend on the voltage, whose sign does not matter, as field and armature change it
    together.
    """

    kind = "dc-shunt"

    field_resistance: SI[float] = si("ohm", "resistance of the field circuit", "R_E", gt=0)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.99)."""
        U, RA, RE, L, k = self.circuit()
        return k * L * U**2 / (RA * RE**2) * (self.sense * RE - k * L * speed)

    def circuit_loss(self, speed: sp.Expr) -> sp.Expr:
        """Return the heat in armature and field, R_A I_A^2 + R_E I_E^2 with I_E = U/R_E and R_A I_A = U - k_M L_E I_E w."""
        U, RA, RE, L, k = self.circuit()
        return (U - self.sense * k * L * U / RE * speed) ** 2 / RA + U**2 / RE
