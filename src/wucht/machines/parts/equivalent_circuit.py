"""The equivalent circuit of an induction motor, one phase, in numbers: what it draws and what torque it gives."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import sympy as sp

_BEND = 0.8  # of the law of deep bars: where the resistance is half way between a direct current and standstill, squared
_SLIPS = np.geomspace(1e-3, 1.0, 200)  # among which that of the breakdown is looked for

FrequencyT = TypeVar("FrequencyT", float, np.ndarray, sp.Expr)


def displacement(frequency: FrequencyT) -> FrequencyT:
    """How far current displacement has raised the rotor's resistance, from 0 to 1 at standstill and rated frequency.

    frequency: of the rotor over the rated one. The law 1.8 b^2/(b^2 + 0.8) is that of deep bars,
    xi (sinh 2 xi + sin 2 xi)/(cosh 2 xi - cos 2 xi) with xi^2 in proportion to the frequency (P. L. Alger, Induction Machines),
    within 0.1 where they double to triple their resistance; even, and smooth at the synchronous speed.
    """
    return (1 + _BEND) * frequency**2 / (frequency**2 + _BEND)


@dataclass(frozen=True)
class EquivalentCircuit:
    """Stator R_1 + j X_1 in series with j X_m beside the rotor R_2/s + j X_2, at one voltage and frequency of the mains.

    voltage: of a phase, in V. synchronous: speed of the field in rad/s. Resistances and reactances in ohm, those of the rotor
    referred to the stator; magnetising: infinite where its current is left out. standstill: the rotor's resistance at
    standstill and rated frequency, where its bars displace the current; None where they do not. share: of the frequency in the
    rated one. Source: any textbook, as A. E. Fitzgerald et al., Electric Machinery, chapter 6, whose Thevenin form gives torque
    and breakdown.
    """

    voltage: float
    synchronous: float
    stator_resistance: float
    rotor_resistance: float
    stator_reactance: float
    rotor_reactance: float
    magnetising: float = math.inf
    standstill: float | None = None
    share: float = 1.0

    def rotor(self, slip: float) -> float:
        """The resistance of the rotor in ohm at a slip."""
        if self.standstill is None:
            return self.rotor_resistance
        return self.rotor_resistance + (self.standstill - self.rotor_resistance) * float(displacement(slip * self.share))

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
        load = self.rotor(slip) / slip
        return 3 * voltage**2 * load / (self.synchronous * abs(inner + complex(load, self.rotor_reactance)) ** 2)

    def breakdown(self) -> tuple[float, float]:
        """Slip and torque in N m at which the motor pulls out: the largest torque from standstill on."""
        if self.standstill is not None:
            return self._largest()
        voltage, inner = self.source
        impedance = abs(inner + 1j * self.rotor_reactance)
        return self.rotor_resistance / impedance, 3 * voltage**2 / (2 * self.synchronous * (inner.real + impedance))

    def _largest(self) -> tuple[float, float]:
        from scipy.optimize import minimize_scalar

        torques = [self.torque(float(s)) for s in _SLIPS]
        at = int(np.argmax(torques))
        if at == len(_SLIPS) - 1:
            return 1.0, torques[-1]
        around = float(_SLIPS[max(at - 1, 0)]), float(_SLIPS[at + 1])
        found = minimize_scalar(lambda s: -self.torque(s), bounds=around, method="bounded", options={"xatol": 1e-12})
        return float(found.x), -float(found.fun)

    def drawn(self, slip: float) -> complex:
        """Active power in W + j reactive power in var that the motor draws at a slip; iron and friction losses not counted."""
        rotor = complex(self.rotor(slip) / slip, self.rotor_reactance)
        parallel = rotor if math.isinf(self.magnetising) else rotor * 1j * self.magnetising / (rotor + 1j * self.magnetising)
        return 3 * self.voltage**2 / (complex(self.stator_resistance, self.stator_reactance) + parallel).conjugate()

    def current(self, slip: float) -> float:
        """The current of a phase in A at a slip."""
        return abs(self.drawn(slip)) / (3 * self.voltage)

    def power_factor(self, slip: float) -> float:
        """Cos phi at a slip, without iron losses."""
        return math.cos(cmath.phase(self.drawn(slip)))
