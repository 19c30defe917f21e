"""The equivalent circuit of an induction motor, one phase, in numbers: what it draws and what torque it gives."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass


@dataclass(frozen=True)
class EquivalentCircuit:
    """Stator R_1 + j X_1 in series with j X_m beside the rotor R_2/s + j X_2, at one voltage and frequency of the mains.

    voltage: of a phase, in V. synchronous: speed of the field in rad/s. Resistances and reactances in ohm, those of the rotor
    referred to the stator; magnetising: infinite where its current is left out. Source: any textbook, as A. E. Fitzgerald et
    al., Electric Machinery, chapter 6, whose Thevenin form gives torque and breakdown.
    """

    voltage: float
    synchronous: float
    stator_resistance: float
    rotor_resistance: float
    stator_reactance: float
    rotor_reactance: float
    magnetising: float = math.inf

    @property
    def source(self) -> tuple[float, complex]:
        """Voltage in V and inner impedance in ohm of the mains with stator and magnetising branch, as the rotor sees them."""
        stator = complex(self.stator_resistance, self.stator_reactance)
        if math.isinf(self.magnetising):
            return self.voltage, stator
        share = 1j * self.magnetising / (stator + 1j * self.magnetising)
        return self.voltage * abs(share), stator * share

    def torque(self, slip: float) -> float:
        """The torque in N m at a slip other than 0."""
        voltage, inner = self.source
        load = self.rotor_resistance / slip
        return 3 * voltage**2 * load / (self.synchronous * abs(inner + complex(load, self.rotor_reactance)) ** 2)

    def breakdown(self) -> tuple[float, float]:
        """Slip and torque in N m at which the motor pulls out."""
        voltage, inner = self.source
        impedance = abs(inner + 1j * self.rotor_reactance)
        return self.rotor_resistance / impedance, 3 * voltage**2 / (2 * self.synchronous * (inner.real + impedance))

    def drawn(self, slip: float) -> complex:
        """Active power in W + j reactive power in var that the motor draws at a slip; iron and friction losses not counted."""
        rotor = complex(self.rotor_resistance / slip, self.rotor_reactance)
        parallel = rotor if math.isinf(self.magnetising) else rotor * 1j * self.magnetising / (rotor + 1j * self.magnetising)
        return 3 * self.voltage**2 / (complex(self.stator_resistance, self.stator_reactance) + parallel).conjugate()

    def current(self, slip: float) -> float:
        """The current of a phase in A at a slip."""
        return abs(self.drawn(slip)) / (3 * self.voltage)

    def power_factor(self, slip: float) -> float:
        """Cos phi at a slip, without iron losses."""
        return math.cos(cmath.phase(self.drawn(slip)))
