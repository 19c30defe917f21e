"""The separately excited DC motor."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import Drive, si


class DCSeparate(Drive):
    """A DC motor whose flux does not depend on the armature's current: 002 (2.85)-(2.92). A negative voltage reverses it.

    Only k_M times the flux matters, in V s or N m/A; where a data sheet gives that product, motor_constant is 1.
    """

    kind = "dc-separate"

    voltage: float = si("V", "voltage of the armature", "U")
    armature_resistance: float = si("ohm", "resistance of the armature", "R_A", gt=0)
    motor_constant: float = si("", "motor constant", "k_M", gt=0)
    flux: float = si("Wb", "magnetic flux of the field", "Phi_E", ge=0)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.92), with k_M for the printed K_M, and without dividing by the flux, which may be zero."""
        U, R, k, flux = self.symbols("voltage", "armature_resistance", "motor_constant", "flux")
        return k * flux * (U - k * flux * speed) / R
