"""The DC motor with its field winding in series with the armature."""

from __future__ import annotations

from typing import Literal

import sympy as sp
from pydantic import Field

from wucht.machines.parts.base import SI, Drive, si


class SelfExcited(Drive):
    """A DC motor that makes its field itself."""

    voltage: SI[float] = si("V", "voltage", "U_S", help="voltage of the source, whose sign does not matter")
    armature_resistance: SI[float] = si("ohm", "resistance of the armature", "R_A", gt=0)
    field_resistance: SI[float] = si("ohm", "resistance of the field winding", "R_E", ge=0)
    field_inductance: SI[float] = si("H", "inductance of the field winding", "L_E", gt=0)
    motor_constant: SI[float] = si("", "motor constant", "k_M", gt=0, help="motor constant k_M: torque over flux and current")
    sense: Literal[1, -1] = Field(
        default=1, description="sense of rotation; -1: the field is reconnected, the motor turns backwards"
    )

    def circuit(self) -> tuple[sp.Symbol, ...]:
        """U, R_A, R_E, L_E, k_M."""
        return self.symbols("voltage", "armature_resistance", "field_resistance", "field_inductance", "motor_constant")


class DCSeries(SelfExcited):
    """A DC motor whose current makes its field. Without load its speed grows without bound: Drozdetskaya (2.100)-(2.105).

    The sign of the voltage does not matter, as it changes field and current together. With ``sense`` = -1 the torque is
    -torque(-speed) of the other.

    Turned backwards by its load, it brakes with a growing torque, and at speed = -R/(k_M L_E) nothing limits its current any
    more: there the formula has a pole and means nothing beyond. A real motor saturates before.
    """

    kind = "dc-series"

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.104), with k_M for the printed k_E."""
        U, RA, RE, L, k = self.circuit()
        return self.sense * k * L * U**2 / (RA + RE + self.sense * k * L * speed) ** 2

    def circuit_loss(self, speed: sp.Expr) -> sp.Expr:
        """Return the heat in both windings, (R_A + R_E) I^2."""
        U, RA, RE, L, k = self.circuit()
        return (RA + RE) * U**2 / (RA + RE + self.sense * k * L * speed) ** 2
