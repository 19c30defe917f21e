"""The equivalent circuit that is fitted to the nameplate of an induction motor.

Rated torque at rated speed and breakdown torque are met exactly: for a resistance R_1 of the stator both give R_2 and X in
closed form, from T_b = 3 V^2/(2 w_s (R_1 + sqrt(R_1^2 + X^2))) and T_n = 3 V^2 (R_2/s)/(w_s ((R_1 + R_2/s)^2 + X^2)), with
voltage and impedance as the rotor sees them. With R_1 = 0 that is the formula of M. Kloss, Archiv fuer
Elektrotechnik 5 (1916) 59-87. R_1 is the one with which the starting torque comes out, as far as the losses allow it; the
reactive power at the rated point gives X_m. The leakage is shared equally by stator and rotor (IEEE Std 112, motors of
design A and D).

Assumptions. The torque on the shaft is the circuit's: friction and windage are counted among the losses that the efficiency
has besides the windings'. The cage takes s/(1 - s) of the shaft's power. Of all other losses (stator winding, iron, friction,
windage, stray) the winding takes at most half: of all losses the winding takes 25 to 40, the cage 15 to 25 %
(U.S. Department of Energy, Determining Electric Motor Load and Efficiency).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from wucht.machines.parts.equivalent_circuit import EquivalentCircuit
from wucht.machines.parts.induction_nameplate import InductionNameplate
from wucht.machines.parts.nameplate import LARGE, missed

_WINDING = 0.5  # of the losses outside the cage: the most that the stator's winding takes
_MOST = 0.9  # of the largest resistance of the stator: up to there one is looked for


def fitted_circuit(plate: InductionNameplate, stator_resistance: float | None = None) -> EquivalentCircuit:
    """The circuit at rated voltage and frequency. stator_resistance: of a phase in ohm, where it was measured."""
    if stator_resistance is not None:
        return _with_resistance(plate, stator_resistance)
    most = _bound(plate)
    if plate.starting_torque_ratio is None:
        return _with_resistance(plate, most if plate.other_losses is not None else 0.0)
    starting = plate.starting_torque_ratio * plate.torque
    return _with_resistance(plate, _nearest_zero(lambda r1: _with_resistance(plate, r1).torque(1.0) - starting, most))


def largest_resistance(plate: InductionNameplate) -> float:
    """The resistance of the stator in ohm with which the breakdown torque would leave no leakage."""
    return _breakdown_impedance(plate, plate.phase_voltage) / 2


def _bound(plate: InductionNameplate) -> float:
    """The largest resistance of the stator with which its winding takes no more than its part of the losses."""
    most, losses = _MOST * largest_resistance(plate), plate.other_losses
    if losses is None:
        return most

    def excess(r1: float) -> float:
        current = plate.phase_current or _with_resistance(plate, r1).current(plate.slip)
        return 3 * current**2 * r1 - _WINDING * losses

    return _nearest_zero(excess, most)


def _nearest_zero(function: Callable[[float], float], most: float) -> float:
    """Where a function is zero between 0 and ``most``, else that end at which it is nearer to zero."""
    from scipy.optimize import brentq

    ends = function(0.0), function(most)
    if ends[0] * ends[1] > 0:
        return 0.0 if abs(ends[0]) <= abs(ends[1]) else most
    return float(brentq(function, 0.0, most, xtol=1e-14 * most, rtol=1e-14))


def _breakdown_impedance(plate: InductionNameplate, voltage: float) -> float:
    """R_1 + sqrt(R_1^2 + X^2) of the breakdown torque, at the voltage that the rotor sees."""
    return 3 * voltage**2 / (2 * plate.synchronous * plate.breakdown_torque_ratio * plate.torque)


def _with_resistance(plate: InductionNameplate, r1: float) -> EquivalentCircuit:
    """The circuit with this resistance of the stator, and the magnetising reactance where the power factor is known."""
    from scipy.optimize import root

    bare = _rotor_of(plate, EquivalentCircuit(plate.phase_voltage, plate.synchronous, r1, 0.0, 0.0, 0.0))
    half = bare.rotor_reactance / 2
    bare = replace(bare, stator_reactance=half, rotor_reactance=half)
    if plate.cosine is None:
        return bare
    tangent = math.tan(math.acos(plate.cosine))

    def wanted(c: EquivalentCircuit) -> float:
        """The reactive power in var: iron losses change the active one alone, so that of the plate counts where it is known."""
        return tangent * (c.drawn(plate.slip).real if plate.input_power is None else plate.input_power)

    lacking = wanted(bare) - bare.drawn(plate.slip).imag
    if lacking <= 0:  # the leakage alone draws more
        return bare

    def misfit(logarithms: list[float]) -> list[float]:
        """Of leakages that are not equal, and of the reactive power."""
        x1, xm = (math.exp(min(max(x, -50.0), 50.0)) for x in logarithms)
        c = _rotor_of(plate, replace(bare, stator_reactance=x1, magnetising=xm))
        return [c.rotor_reactance / x1 - 1, c.drawn(plate.slip).imag / wanted(c) - 1]

    found = root(misfit, [math.log(half), math.log(3 * plate.phase_voltage**2 / lacking)], options={"xtol": 1e-14})
    x1, xm = map(math.exp, found.x)
    if max(map(abs, misfit(list(found.x)))) > 1e-8:
        return bare
    return replace(_rotor_of(plate, replace(bare, stator_reactance=x1, magnetising=xm)), rotor_reactance=x1)


def _rotor_of(plate: InductionNameplate, c: EquivalentCircuit) -> EquivalentCircuit:
    """The circuit with the R_2 and X_2 that give rated and breakdown torque, whatever the stator's branch is."""
    voltage, inner = c.source
    whole, resistance = _breakdown_impedance(plate, voltage), inner.real
    reactance = math.sqrt(max(whole * (whole - 2 * resistance), 0.0))
    conductance = plate.torque * plate.synchronous / (3 * voltage**2)  # y/((R + y)^2 + X^2) of y = R_2/s
    a, b = 1 - 2 * conductance * whole, 1 + 2 * conductance * (whole - 2 * resistance)
    y = (1 - 2 * conductance * resistance + math.sqrt(max(a * b, 0.0))) / (2 * conductance)
    return replace(c, rotor_resistance=plate.slip * y, rotor_reactance=reactance - inner.imag)


def _errors(plate: InductionNameplate, c: EquivalentCircuit) -> dict[str, tuple[float, str]]:
    compared = {
        "torque at rated speed": (plate.torque, c.torque(plate.slip), "N m"),
        "breakdown torque": (plate.breakdown_torque_ratio * plate.torque, c.breakdown()[1], "N m"),
    }
    if plate.starting_torque_ratio is not None:
        compared["starting torque"] = plate.starting_torque_ratio * plate.torque, c.torque(1.0), "N m"
    active = c.drawn(plate.slip).real if plate.input_power is None else plate.input_power
    if plate.cosine is not None and not math.isinf(c.magnetising):
        compared["power factor"] = plate.cosine, active / math.hypot(active, c.drawn(plate.slip).imag), ""
    if plate.current is not None and plate.efficiency is not None and plate.power_factor is not None:
        by_current = math.sqrt(3) * plate.voltage * plate.current * plate.power_factor
        compared["input power by current"] = plate.power / plate.efficiency, by_current, "W"
    return missed(compared)


def fit_in_words(plate: InductionNameplate, c: EquivalentCircuit) -> str:
    """The circuit, and by how much it misses what is printed."""
    leakage = f"leakage {c.stator_reactance:.4g} + {c.rotor_reactance:.4g}"
    magnetising = "no magnetising current" if math.isinf(c.magnetising) else f"magnetising {c.magnetising:.4g}"
    values = f"stator {c.stator_resistance:.4g}, rotor {c.rotor_resistance:.4g}, {leakage}, {magnetising}"
    name = "circuit" if c.stator_resistance else "circuit without stator resistance (Kloss)"
    return f"{name} of the nameplate, ohm a phase: {values}; {'; '.join(words for _, words in _errors(plate, c).values())}"


def doubts(plate: InductionNameplate, c: EquivalentCircuit) -> tuple[str, ...]:
    """What of the plate the circuit misses by more than a tenth, and what that means."""
    errors = _errors(plate, c)
    found = [words for error, words in errors.values() if abs(error) > LARGE]
    if errors.get("starting torque", (0.0, ""))[0] < -LARGE:
        found[-1] += ": real cages displace the current at standstill, the circuit does not; it is too weak at low speed"
    if plate.cosine is not None and math.isinf(c.magnetising):
        found.append(f"the leakage alone draws more reactive power than a power factor of {plate.cosine:.3g} leaves")
    return tuple(found)
