"""The three-phase induction motor in the steady state."""

from __future__ import annotations

import math
from typing import Any, Literal

import sympy as sp
from pydantic import model_validator

from wucht.machines.parts.base import Drive, si


class Induction(Drive):
    """A three-phase induction motor by its equivalent circuit without the magnetising current: 002 (2.106)-(2.121).

    The voltage is that of a phase. Rotor quantities refer to the stator. Reactances are those at ``rated_frequency`` and grow
    in proportion to the frequency, so that it may be changed while the motor runs; without that key they are those at the
    given ``frequency``. A schedule of the frequency begins a little above zero: without a field that turns there is no slip.
    ``sense`` = -1 is the motor with two phases exchanged: it turns backwards.
    """

    kind = "induction"

    voltage: float = si("V", "voltage of a phase", "U_1")
    frequency: float = si("Hz", "frequency of the mains", "f", gt=0)
    pole_pairs: float = si("", "number of pole pairs", "p", ge=1)
    stator_resistance: float = si("ohm", "resistance of the stator", "R_1", ge=0)
    rotor_resistance: float = si("ohm", "resistance of the rotor", "R_2", gt=0)
    stator_reactance: float = si("ohm", "leakage reactance of the stator", "X_1", ge=0)
    rotor_reactance: float = si("ohm", "leakage reactance of the rotor", "X_2", ge=0)
    rated_frequency: float = si("Hz", "frequency at which the reactances hold", "f_r", gt=0)
    sense: Literal[1, -1] = 1

    @model_validator(mode="before")
    @classmethod
    def _reactances_hold_at_the_frequency(cls, given: Any) -> Any:
        if isinstance(given, dict) and given.get("rated_frequency") is None and "frequency" in given:
            return {**given, "rated_frequency": given["frequency"]}
        return given

    def check(self) -> None:
        """A whole number of pole pairs; a leakage, without which a torque would grow without bound."""
        if self.pole_pairs != round(self.pole_pairs):
            raise ValueError("pole_pairs", "must be a whole number of pole pairs")
        if self.stator_reactance + self.rotor_reactance == 0:
            raise ValueError("rotor_reactance", "must be more than 0 ohm where the stator's reactance is 0")

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.119), multiplied out by the slip and the synchronous speed, neither of which it then divides by.

        With the slip speed d = w_s - w, s = d/w_s and T = 3 R_2 U^2 d/((R_1 d + R_2 w_s)^2 + (X d)^2).
        """
        U, f, p, R1, R2, X1, X2, rated = self.symbols(
            "voltage", "frequency", "pole_pairs", "stator_resistance", "rotor_resistance", "stator_reactance",
            "rotor_reactance", "rated_frequency",
        )  # fmt: skip
        synchronous = self.sense * 2 * sp.pi * f / p
        slip_speed = synchronous - speed
        X = (X1 + X2) * f / rated
        return 3 * R2 * U**2 * slip_speed / ((R1 * slip_speed + R2 * synchronous) ** 2 + (X * slip_speed) ** 2)

    def synchronous_speed(self) -> float:
        """The speed of the field in rad/s, 2 pi f/p; negative with ``sense`` = -1."""
        return self.sense * 2 * math.pi * self.frequency / self.pole_pairs

    def breakdown(self) -> tuple[float, float, float]:
        """Slip, speed in rad/s and torque in N m at which the motor pulls out: 002 (2.121) and (2.120).

        The printed (2.120) has a factor R_2 too many; it is 3 U^2/(2 w_s (R_1 + sqrt(R_1^2 + X^2))).
        """
        X = (self.stator_reactance + self.rotor_reactance) * self.frequency / self.rated_frequency
        impedance = math.hypot(self.stator_resistance, X)
        slip, synchronous = self.rotor_resistance / impedance, self.synchronous_speed()
        torque = 3 * self.voltage**2 / (2 * synchronous * (self.stator_resistance + impedance))
        return slip, synchronous * (1 - slip), torque
