"""The equivalent circuit of an induction motor, one phase, in numbers: its power and torque; fitted to a nameplate.

Rated torque at rated speed and breakdown torque are met exactly: for a resistance R_1 of the stator both give R_2 and X in
closed form, from T_b = 3 V^2/(2 w_s (R_1 + sqrt(R_1^2 + X^2))) and T_n = 3 V^2 (R_2/s)/(w_s ((R_1 + R_2/s)^2 + X^2)), with
voltage and impedance of the source seen by the rotor. With R_1 = 0 that is the formula of M. Kloss, Archiv fuer
Elektrotechnik 5 (1916) 59-87.
R_1 is the one with which the starting torque comes out, as far as the losses allow it; where that is
not enough, the rotor's bars displace the current: its resistance at standstill does the rest. The reactive power at the rated
point gives X_m. The leakage is shared equally by stator and rotor (IEEE Std 112, motors of design A and D).

Assumptions. The torque on the shaft is the circuit's: friction and windage are counted among the losses that the efficiency
has besides the windings'. The cage takes s/(1 - s) of the shaft's power. Of all other losses (stator winding, iron, friction,
windage, stray) the winding takes at most half: of all losses the winding takes 25 to 40, the cage 15 to 25 %
(U.S. Department of Energy, Determining Electric Motor Load and Efficiency).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import sympy as sp

from wucht.machines.parts.nameplate import LARGE, InductionNameplate, fit_errors

_BEND = 0.8  # of the law of deep bars: where the resistance is half way between a direct current and standstill, squared
_SLIPS = np.geomspace(1e-3, 1.0, 200)  # among which the slip of the breakdown is searched

FrequencyT = TypeVar("FrequencyT", float, np.ndarray, sp.Expr)
_WINDING = 0.5  # of the losses outside the cage: the most that the stator's winding takes
_MOST = 0.9  # of the largest resistance of the stator: upper end of the search


def displacement(frequency: FrequencyT) -> FrequencyT:
    """Return the rise of the rotor's resistance by current displacement, from 0 to 1 at standstill and rated frequency.

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
        """Return the resistance of the rotor in ohm at a slip."""
        if self.standstill is None:
            return self.rotor_resistance
        return self.rotor_resistance + (self.standstill - self.rotor_resistance) * float(displacement(slip * self.share))

    @property
    def source(self) -> tuple[float, complex]:
        """Voltage in V and inner impedance in ohm of the mains with stator and magnetising branch, at the rotor's terminals."""
        stator = complex(self.stator_resistance, self.stator_reactance)
        if math.isinf(self.magnetising):
            return self.voltage, stator
        share = 1j * self.magnetising / (stator + 1j * self.magnetising)
        return self.voltage * abs(share), stator * share

    def torque(self, slip: float) -> float:
        """Return the torque in N m at a slip other than 0."""
        voltage, inner = self.source
        load = self.rotor(slip) / slip
        return 3 * voltage**2 * load / (self.synchronous * abs(inner + complex(load, self.rotor_reactance)) ** 2)

    def breakdown(self) -> tuple[float, float]:
        """Return slip and torque in N m at which the motor pulls out: the largest torque from standstill on."""
        if self.standstill is not None:
            return self._largest_torque()
        voltage, inner = self.source
        impedance = abs(inner + 1j * self.rotor_reactance)
        return self.rotor_resistance / impedance, 3 * voltage**2 / (2 * self.synchronous * (inner.real + impedance))

    def _largest_torque(self) -> tuple[float, float]:
        from scipy.optimize import minimize_scalar

        torques = [self.torque(float(s)) for s in _SLIPS]
        at = int(np.argmax(torques))
        if at == len(_SLIPS) - 1:
            return 1.0, torques[-1]
        around = float(_SLIPS[max(at - 1, 0)]), float(_SLIPS[at + 1])
        optimum = minimize_scalar(lambda s: -self.torque(s), bounds=around, method="bounded", options={"xatol": 1e-12})
        return float(optimum.x), -float(optimum.fun)

    def complex_power(self, slip: float) -> complex:
        """Return active power in W + j reactive power in var drawn at a slip; iron and friction losses not counted."""
        rotor = complex(self.rotor(slip) / slip, self.rotor_reactance)
        parallel = rotor if math.isinf(self.magnetising) else rotor * 1j * self.magnetising / (rotor + 1j * self.magnetising)
        return 3 * self.voltage**2 / (complex(self.stator_resistance, self.stator_reactance) + parallel).conjugate()

    def current(self, slip: float) -> float:
        """Return the current of a phase in A at a slip."""
        return abs(self.complex_power(slip)) / (3 * self.voltage)

    def power_factor(self, slip: float) -> float:
        """Return cos phi at a slip, without iron losses."""
        return math.cos(cmath.phase(self.complex_power(slip)))


def fitted_circuit(plate: InductionNameplate, stator_resistance: float | None = None) -> EquivalentCircuit:
    """Return the circuit at rated voltage and frequency. stator_resistance: of a phase in ohm, where it was measured."""
    most = _loss_limited_resistance(plate)
    if plate.starting_ratio is None:
        r1 = stator_resistance if stator_resistance is not None else most if plate.other_losses is not None else 0.0
        return _with_resistance(plate, r1)
    starting = plate.starting_ratio * plate.torque

    def missing(r1: float) -> float:
        return _with_resistance(plate, r1).torque(1.0) - starting

    single = _with_resistance(plate, _nearest_zero(missing, most) if stator_resistance is None else stator_resistance)
    return single if single.torque(1.0) > (1 - 1e-9) * starting else _with_deep_bars(plate, single)


def largest_resistance(plate: InductionNameplate) -> float:
    """Return the resistance of the stator in ohm with which the breakdown torque would leave no leakage."""
    return _breakdown_impedance(plate, plate.phase_voltage) / 2


def _loss_limited_resistance(plate: InductionNameplate) -> float:
    """Return the largest resistance of the stator with which its winding takes no more than its part of the losses."""
    most, losses = _MOST * largest_resistance(plate), plate.other_losses
    if losses is None:
        return most

    def excess(r1: float) -> float:
        current = plate.phase_current or _with_resistance(plate, r1).current(plate.slip)
        return 3 * current**2 * r1 - _WINDING * losses

    return _nearest_zero(excess, most)


def _nearest_zero(function: Callable[[float], float], most: float) -> float:
    """Return the zero of a function between 0 and ``most``, else the end at which it is nearer to zero."""
    from scipy.optimize import brentq

    ends = function(0.0), function(most)
    if ends[0] * ends[1] > 0:
        return 0.0 if abs(ends[0]) <= abs(ends[1]) else most
    return float(brentq(function, 0.0, most, xtol=1e-14 * most, rtol=1e-14))


def _breakdown_impedance(plate: InductionNameplate, voltage: float) -> float:
    """Return R_1 + sqrt(R_1^2 + X^2) of the breakdown torque, at the voltage at the rotor's terminals."""
    return 3 * voltage**2 / (2 * plate.synchronous * plate.breakdown_ratio * plate.torque)


def _with_resistance(plate: InductionNameplate, r1: float) -> EquivalentCircuit:
    """Return the circuit with a resistance of the stator, and the magnetising reactance where the power factor is known."""
    from scipy.optimize import root

    bare = _rotor_of(plate, EquivalentCircuit(plate.phase_voltage, plate.synchronous, r1, 0.0, 0.0, 0.0))
    half = bare.rotor_reactance / 2
    bare = replace(bare, stator_reactance=half, rotor_reactance=half)
    if plate.cosine is None:
        return bare
    tangent = math.tan(math.acos(plate.cosine))

    def target_reactive_power(c: EquivalentCircuit) -> float:
        """The reactive power in var: iron losses change the active one alone, so that of the plate counts where it is known."""
        return tangent * (c.complex_power(plate.slip).real if plate.input_power is None else plate.input_power)

    lacking = target_reactive_power(bare) - bare.complex_power(plate.slip).imag
    if lacking <= 0:  # the leakage alone draws more
        return bare

    def misfit(logarithms: list[float]) -> list[float]:
        """Return the misfit of equal leakages, and of the reactive power."""
        x1, xm = (math.exp(min(max(x, -50.0), 50.0)) for x in logarithms)
        c = _rotor_of(plate, replace(bare, stator_reactance=x1, magnetising=xm))
        return [c.rotor_reactance / x1 - 1, c.complex_power(plate.slip).imag / target_reactive_power(c) - 1]

    solution = root(misfit, [math.log(half), math.log(3 * plate.phase_voltage**2 / lacking)], options={"xtol": 1e-14})
    x1, xm = map(math.exp, solution.x)
    if max(map(abs, misfit(list(solution.x)))) > 1e-8:
        return bare
    return replace(_rotor_of(plate, replace(bare, stator_reactance=x1, magnetising=xm)), rotor_reactance=x1)


def _with_deep_bars(plate: InductionNameplate, single: EquivalentCircuit) -> EquivalentCircuit:
    """Return the circuit with this stator whose rotor displaces the current, so that it has the starting torque of the plate.

    The single cage where there is no solution.
    """
    from scipy.optimize import root

    target = _targets(plate)
    has_magnetising = not math.isinf(single.magnetising)
    reactive = (
        single.complex_power(plate.slip).imag / single.complex_power(plate.slip).real if plate.input_power is None else None
    )

    def circuit_of(logarithms: Sequence[float]) -> EquivalentCircuit:
        r2, x, more, *xm = (math.exp(min(max(v, -50.0), 50.0)) for v in logarithms)
        return replace(
            single, rotor_resistance=r2, stator_reactance=x, rotor_reactance=x, standstill=r2 * (1 + more),
            magnetising=xm[0] if xm else math.inf,
        )  # fmt: skip

    def misfit(logarithms: Sequence[float]) -> list[float]:
        c = circuit_of(logarithms)
        torques = (c.torque(plate.slip), c.breakdown()[1], c.torque(1.0))
        errors = [f / t - 1 for f, t in zip(torques, target, strict=True)]
        if has_magnetising:
            power = c.complex_power(plate.slip)
            reactive_power = power.real * reactive if reactive is not None else single.complex_power(plate.slip).imag
            errors.append(power.imag / reactive_power - 1)
        return errors

    begin = [single.rotor_resistance, single.stator_reactance, 1.0, *([single.magnetising] if has_magnetising else [])]
    solution = root(misfit, [math.log(v) for v in begin], options={"xtol": 1e-12})
    return circuit_of(solution.x) if max(map(abs, misfit(solution.x))) < 1e-7 else single


def _targets(plate: InductionNameplate) -> tuple[float, float, float]:
    """Return rated, breakdown and starting torque in N m."""
    return plate.torque, plate.breakdown_ratio * plate.torque, (plate.starting_ratio or 0.0) * plate.torque


def _rotor_of(plate: InductionNameplate, c: EquivalentCircuit) -> EquivalentCircuit:
    """Return the circuit with the R_2 and X_2 that give rated and breakdown torque, for any branch of the stator."""
    voltage, inner = c.source
    whole, resistance = _breakdown_impedance(plate, voltage), inner.real
    reactance = math.sqrt(max(whole * (whole - 2 * resistance), 0.0))
    conductance = plate.torque * plate.synchronous / (3 * voltage**2)  # y/((R + y)^2 + X^2) of y = R_2/s
    a, b = 1 - 2 * conductance * whole, 1 + 2 * conductance * (whole - 2 * resistance)
    y = (1 - 2 * conductance * resistance + math.sqrt(max(a * b, 0.0))) / (2 * conductance)
    return replace(c, rotor_resistance=plate.slip * y, rotor_reactance=reactance - inner.imag)


def _errors(plate: InductionNameplate, c: EquivalentCircuit) -> dict[str, tuple[float, str]]:
    comparisons = {
        "torque at rated speed": (plate.torque, c.torque(plate.slip), "N m"),
        "breakdown torque": (plate.breakdown_ratio * plate.torque, c.breakdown()[1], "N m"),
    }
    if plate.starting_ratio is not None:
        comparisons["starting torque"] = plate.starting_ratio * plate.torque, c.torque(1.0), "N m"
    active = c.complex_power(plate.slip).real if plate.input_power is None else plate.input_power
    if plate.cosine is not None and not math.isinf(c.magnetising):
        comparisons["power factor"] = plate.cosine, active / math.hypot(active, c.complex_power(plate.slip).imag), ""
    if plate.current is not None and plate.efficiency is not None and plate.power_factor is not None:
        by_current = math.sqrt(3) * plate.voltage * plate.current * plate.power_factor
        comparisons["input power by current"] = plate.power / plate.efficiency, by_current, "W"
    return fit_errors(comparisons)


def fit_text(plate: InductionNameplate, c: EquivalentCircuit) -> str:
    """Return the circuit, and its deviations from the plate, as text."""
    leakage = f"leakage {c.stator_reactance:.4g} + {c.rotor_reactance:.4g}"
    magnetising = "no magnetising current" if math.isinf(c.magnetising) else f"magnetising {c.magnetising:.4g}"
    bars = "" if c.standstill is None else f" ({c.standstill:.4g} at standstill: deep bars)"
    values = f"stator {c.stator_resistance:.4g}, rotor {c.rotor_resistance:.4g}{bars}, {leakage}, {magnetising}"
    name = "circuit" if c.stator_resistance else "circuit without stator resistance (Kloss)"
    return f"{name} of the nameplate, ohm a phase: {values}; {'; '.join(words for _, words in _errors(plate, c).values())}"


def doubts(plate: InductionNameplate, c: EquivalentCircuit) -> tuple[str, ...]:
    """Return the values of the plate that the circuit misses by more than a tenth, and their meaning."""
    errors = _errors(plate, c)
    sentences = [words for error, words in errors.values() if abs(error) > LARGE]
    if plate.cosine is not None and math.isinf(c.magnetising):
        sentences.append(f"the leakage alone draws more reactive power than a power factor of {plate.cosine:.3g} leaves")
    return tuple(sentences)
