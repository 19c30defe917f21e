"""The three-phase induction motor in the steady state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import sympy as sp
from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from wucht.errors import FieldError, code_of
from wucht.machines.parts.base import SI, Drive, si
from wucht.machines.parts.equivalent_circuit import (
    EquivalentCircuit,
    displacement,
    doubts,
    fit_text,
    fitted_circuit,
    largest_resistance,
)
from wucht.machines.parts.nameplate import InductionNameplate, read_nameplate, required_without
from wucht.machines.parts.transmission import Transmission
from wucht.machines.parts.typical_motors import INERTIA_SPREAD, estimate_text
from wucht.schema import Composite, Unit, composite

# The keys that follow from a nameplate, and those beside it: operating point, and a resistance that was measured.
_CIRCUIT = (
    "rotor_resistance",
    "stator_reactance",
    "rotor_reactance",
    "magnetising_reactance",
    "standstill_resistance",
    "pole_pairs",
    "rated_frequency",
)
_TURNING = "must be a frequency of the mains greater than 0 Hz"
_OPERATING_KEYS = ("voltage", "frequency", "stator_resistance")


class Induction(Drive):
    """A three-phase induction motor by its equivalent circuit. Drozdetskaya (2.106)-(2.121), or with the magnetising current.

    The voltage is that of a phase. Rotor quantities refer to the stator. Reactances are those at ``rated_frequency`` and grow
    in proportion to the frequency, so that it may be changed while the motor runs; without that key they are those at the
    given ``frequency``. Without ``magnetising_reactance`` its current is left out, as in 002, and a schedule of the frequency
    begins a little above zero: without a field that turns there is no slip. With it, and a resistance of the stator, the
    frequency may be 0: the motor then brakes as one fed with direct current does. Between ``standstill_resistance``
    and ``rotor_resistance`` that of the rotor follows ``displacement``.
    """

    kind = "induction"

    nameplate: Composite[InductionNameplate | None] = composite(
        default=None, description="rated data of the motor, from which its circuit follows"
    )
    voltage: SI[float] = si("V", "voltage of a phase", "U_1")
    frequency: SI[float] = si("Hz", "frequency of the mains", "f", ge=0)
    pole_pairs: SI[float] = si("", "number of pole pairs", "p", ge=1)
    stator_resistance: SI[float] = si("ohm", "resistance of the stator", "R_1", ge=0)
    rotor_resistance: SI[float] = si("ohm", "resistance of the rotor", "R_2", gt=0)
    stator_reactance: SI[float] = si("ohm", "leakage reactance of the stator", "X_1", ge=0)
    rotor_reactance: SI[float] = si("ohm", "leakage reactance of the rotor", "X_2", ge=0)
    standstill_resistance: SI[float | None] = si(
        "ohm",
        "resistance of the rotor at standstill",
        "R_2s",
        default=None,
        gt=0,
        help="resistance of the rotor at standstill and the rated frequency, where deep bars displace the current",
    )
    magnetising_reactance: SI[float | None] = si("ohm", "magnetising reactance", "X_m", default=None, gt=0, help=(
        "reactance of the magnetising current; without this key there is no such current, as in 002"
    ))  # fmt: skip
    rated_frequency: SI[float] = si("Hz", "frequency at which the reactances hold", "f_r", gt=0, help=(
        "frequency at which the reactances hold, by default `frequency`; they grow in proportion to it"
    ))  # fmt: skip
    sense: Literal[1, -1] = Field(
        default=1, description="sense of rotation; -1: two phases are exchanged, the motor turns backwards"
    )

    @model_validator(mode="before")
    @classmethod
    def _circuit_of_the_nameplate(cls, table: Any) -> Any:
        table, plate = read_nameplate(table, InductionNameplate, _CIRCUIT)
        if plate is not None:
            circuit = fitted_circuit(plate, _parse_resistance(table.get("stator_resistance"), plate))
            return {**_parameters(plate, circuit), **table} | _inertia_of_the_motor(table.get("transmission"), plate)
        if not isinstance(table, dict) or table.get("rated_frequency") is not None or "frequency" not in table:
            return table
        try:
            turns = Unit("Hz", "frequency").parse_quantity(table["frequency"]) > 0
        except ValueError:  # which the field reports
            return table
        if not turns:
            raise ValueError("frequency", f"{_TURNING}, or rated_frequency beside it")
        return {**table, "rated_frequency": table["frequency"]}

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return required_without(super().__get_pydantic_json_schema__(schema, handler), (*_CIRCUIT, *_OPERATING_KEYS))

    def check(self) -> None:
        """Check for a whole number of pole pairs, a leakage that bounds the torque, and a field that turns."""
        if self.pole_pairs != round(self.pole_pairs):
            raise FieldError("pole_pairs", "must be a whole number of pole pairs", code="whole-number")
        if self.stator_reactance + self.rotor_reactance == 0:
            raise ValueError("rotor_reactance", "must be more than 0 ohm where the stator's reactance is 0")
        if not self.frequency and not (self.magnetising_reactance and self.stator_resistance):
            hint = "at 0 Hz a motor needs magnetising_reactance and stator_resistance (a nameplate: efficiency, power_factor)"
            raise ValueError("frequency", f"{_TURNING}: {hint}")

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """Return the torque at a speed, multiplied out by the slip and the synchronous speed, so that it divides by neither.

        Without the magnetising current 002 (2.119): with the slip speed d = w_s - w, s = d/w_s and
        T = 3 R_2 U^2 d/((R_1 d + R_2 w_s)^2 + (X d)^2). With it, of f/f_r and the rotor's frequency p d/(2 pi f_r), both over
        the rated one, a and b, T = 3 p/(2 pi f_r) R_2 b X_m^2 U^2/|D|^2 with
        D = (R_1 + j a (X_1 + X_m)) (R_2 + j b (X_2 + X_m)) + a b X_m^2: the voltage equations of stator and rotor solved for
        the rotor's current (W. Leonhard, Control of Electrical Drives, chapter 10).
        """
        return self._torque_and_stator_loss(speed)[0]

    def circuit_loss(self, speed: sp.Expr) -> sp.Expr:
        """Return the heat in the windings: 3 R_1 I_1^2 of the stator, and the torque times the slip speed of the rotor.

        I_1 is the rotor's current where there is no magnetising one, else U (R_2 + j b (X_2 + X_m))/D, see ``torque``.
        """
        torque, stator_loss = self._torque_and_stator_loss(speed)
        f, p = self.symbols("frequency", "pole_pairs")
        return stator_loss + torque * (self.sense * 2 * sp.pi * f / p - speed)

    def _torque_and_stator_loss(self, speed: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        U, f, p, R1, R2, X1, X2, rated_frequency = self.symbols(
            "voltage", "frequency", "pole_pairs", "stator_resistance", "rotor_resistance", "stator_reactance",
            "rotor_reactance", "rated_frequency",
        )  # fmt: skip
        synchronous = self.sense * 2 * sp.pi * f / p
        slip_speed = synchronous - speed
        field_speed = 2 * sp.pi * rated_frequency / p
        if self.standstill_resistance is not None:
            R2 += (self.symbol("standstill_resistance") - R2) * displacement(slip_speed / field_speed)
        if self.magnetising_reactance is None:
            X = (X1 + X2) * f / rated_frequency
            square = (R1 * slip_speed + R2 * synchronous) ** 2 + (X * slip_speed) ** 2
            return 3 * R2 * U**2 * slip_speed / square, 3 * R1 * U**2 * slip_speed**2 / square
        Xm = self.symbol("magnetising_reactance")
        a, b = self.sense * f / rated_frequency, slip_speed / field_speed
        real, imaginary = R1 * R2 - a * b * (X1 * X2 + Xm * (X1 + X2)), R1 * b * (X2 + Xm) + R2 * a * (X1 + Xm)
        square = real**2 + imaginary**2
        torque = 3 / field_speed * R2 * b * Xm**2 * U**2 / square
        return torque, 3 * R1 * U**2 * (R2**2 + (b * (X2 + Xm)) ** 2) / square

    def synchronous_speed(self) -> float | None:
        """Return the speed of the field in rad/s, 2 pi f/p; negative with ``sense`` = -1; None at 0 Hz, without slip."""
        return self.sense * 2 * math.pi * self.frequency / self.pole_pairs if self.frequency else None

    def breakdown(self) -> tuple[float, float, float] | None:
        """Return slip, speed in rad/s and torque in N m at pull-out: 002 (2.121) and (2.120); None at 0 Hz.

        The printed (2.120) has a factor R_2 too many; it is 3 U^2/(2 w_s (R_1 + sqrt(R_1^2 + X^2))).
        """
        synchronous = self.synchronous_speed()
        if synchronous is None:
            return None
        slip, torque = self.circuit_at(self.voltage, self.frequency).breakdown()
        return slip, synchronous * (1 - slip), self.sense * torque

    def circuit_at(self, voltage: float, frequency: float) -> EquivalentCircuit:
        """Return the circuit at a voltage of a phase in V and a frequency in Hz, for a field that turns forwards."""
        share = frequency / self.rated_frequency
        magnetising = math.inf if self.magnetising_reactance is None else self.magnetising_reactance * share
        synchronous, reactances = 2 * math.pi * frequency / self.pole_pairs, (self.stator_reactance, self.rotor_reactance)
        x1, x2 = (share * x for x in reactances)
        r1, r2, standstill = self.stator_resistance, self.rotor_resistance, self.standstill_resistance
        return EquivalentCircuit(voltage, synchronous, r1, r2, x1, x2, magnetising, standstill, share)

    def derivation_notes(self) -> tuple[str, ...]:
        """Return the circuit that was fitted to the nameplate, its deviations, and what was estimated, as notes."""
        plate = self.nameplate
        if plate is None:
            return ()
        circuit = self._rated_circuit()
        notes = [f"{self.path}: {fit_text(plate, circuit)}"]
        if estimates := self.estimates():
            inertia = f"; its rotor, some {plate.typical.inertia:.2g} kg m^2, is part of the inertia of {self.on!r}"
            notes.append(f"{self.path}: {', '.join(estimates)}: {plate.typical}{'' if self.transmission else inertia}")
        elif plate.starting_ratio is None:
            by_circuit = f"starting torque {circuit.torque(1.0):.3g} N m by the circuit, as starting_torque_ratio is not given"
            notes.append(f"{self.path}: {by_circuit}; {plate.typical.starting * plate.torque:.3g} N m are {plate.typical}")
        return tuple(notes)

    def estimates(self) -> tuple[str, ...]:
        """See ``Drive``."""
        plate, transmission = self.nameplate, self.transmission
        if plate is None:
            return ()
        inertia = plate.typical.inertia
        is_typical = transmission is not None and transmission.inertia == inertia
        of_rotor = (estimate_text("inertia on the motor's side", inertia, INERTIA_SPREAD, " kg m^2"),) if is_typical else ()
        return (*plate.estimates(), *of_rotor)

    def doubts(self) -> tuple[str, ...]:
        """Return the nameplate values that the circuit misses by more than a tenth."""
        plate = self.nameplate
        return () if plate is None else tuple(f"{self.path}.nameplate: {d}" for d in doubts(plate, self._rated_circuit()))

    def _rated_circuit(self) -> EquivalentCircuit:
        assert self.nameplate is not None
        return self.circuit_at(self.nameplate.phase_voltage, self.nameplate.frequency)


def _parse_resistance(value: Any, plate: InductionNameplate) -> float | None:
    """Return the resistance of a phase in ohm that is given beside a nameplate. Raises ``ValueError(key, sentence)``."""
    if value is None:
        return None
    most = largest_resistance(plate)
    try:
        resistance = Unit("ohm", "resistance of the stator").parse_quantity(value)
    except ValueError as error:
        raise FieldError("stator_resistance", str(error), code=code_of(error)) from None
    if not 0 <= resistance < most:
        requirement = f"must be from 0 to {most:.4g} ohm: a larger one does not permit the breakdown torque"
        raise ValueError("stator_resistance", requirement)
    return resistance


def _inertia_of_the_motor(transmission: Any, plate: InductionNameplate) -> dict[str, Any]:
    """Return the transmission with the inertia of a typical motor, where there is one without inertia."""
    if isinstance(transmission, Mapping) and transmission.get("inertia") is None:
        return {"transmission": {**transmission, "inertia": plate.typical.inertia}}
    if isinstance(transmission, Transmission) and "inertia" not in transmission.model_fields_set:
        return {"transmission": transmission.model_copy(update={"inertia": plate.typical.inertia})}
    return {}


def _parameters(plate: InductionNameplate, c: EquivalentCircuit) -> dict[str, float | None]:
    """Return the parameters of a motor of a nameplate at its rated voltage and frequency."""
    return {
        "voltage": plate.phase_voltage,
        "frequency": plate.frequency,
        "rated_frequency": plate.frequency,
        "pole_pairs": plate.pole_pairs,
        "stator_resistance": c.stator_resistance,
        "rotor_resistance": c.rotor_resistance,
        "stator_reactance": c.stator_reactance,
        "rotor_reactance": c.rotor_reactance,
        "standstill_resistance": c.standstill,
        "magnetising_reactance": None if math.isinf(c.magnetising) else c.magnetising,
    }
