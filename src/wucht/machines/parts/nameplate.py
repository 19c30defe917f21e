"""Nameplates: rated data printed on a DC or an induction motor, from which its parameters follow when it is built.

A DC motor of constant flux, of armature resistance R_A and flux k Phi turns by U = R_A I + k Phi w, and gives the shaft k Phi I
less friction and iron losses, k Phi I_0 by its no-load current I_0 (A. E. Fitzgerald et al., Electric Machinery, chapter 7).
So the torque on the shaft is a straight line with the slope (k Phi)^2/R_A that is zero at the no-load speed, and as such it is
kept: through the rated point and the no-load point, k Phi = U/w_0, with friction and iron losses in it, exact at the rated
voltage.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeVar

from pydantic import Field, ValidationError, model_validator

from wucht.machines.parts.typical_motors import BREAKDOWN_SPREAD, STARTING_SPREAD, TypicalMotor, estimate_text
from wucht.schema import SI, Parameter, TableModel, si

LARGE = 0.1  # of a value: a larger misfit gives a warning
_MOST_SLIP = 0.3  # a larger one indicates a wrong speed, frequency or number of poles


class Nameplate(TableModel):
    """Data printed on a part. It has no parameters itself: those that follow from it belong to the part."""

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """Return no parameters."""
        return ()


PlateT = TypeVar("PlateT", bound=Nameplate)


def read_nameplate(table: Any, cls: type[PlateT], follow: Sequence[str]) -> tuple[Any, PlateT | None]:
    """Return the table of a motor and the nameplate in it from which its parameters follow.

    follow: the keys that follow from the nameplate. None where there is no nameplate, or a wrong one, which its field reports;
    and where all keys are present already, as in a motor that was built before. Raises ``ValueError(key, sentence)``
    where some are given beside it.
    """
    if not isinstance(table, Mapping) or table.get("nameplate") is None or all(key in table for key in follow):
        return table, None
    try:
        plate = cls.model_validate(table["nameplate"])
    except ValidationError:
        return table, None
    for key in follow:
        if table.get(key) is not None:
            raise ValueError(key, "not allowed beside nameplate, from which it follows")
    return table, plate


def required_without(schema: dict[str, Any], keys: Sequence[str]) -> dict[str, Any]:
    """Return the JSON schema of a motor in which these keys are required only where there is no nameplate."""
    required_keys = schema.get("required", [])
    always = [key for key in required_keys if key not in keys]
    choice = [{"required": ["nameplate"]}, {"required": [key for key in required_keys if key in keys]}]
    return {k: v for k, v in schema.items() if k != "required"} | {"anyOf": choice} | ({"required": always} if always else {})


def fit_errors(comparisons: Mapping[str, tuple[float, float, str]]) -> dict[str, tuple[float, str]]:
    """Return the relative deviation of each fitted value from the printed one, and both as text.

    comparisons: printed and fitted value, and their unit, by name.
    """
    errors = {}
    for name, (printed_value, fitted_value, unit) in comparisons.items():
        error, suffix = fitted_value / printed_value - 1, f" {unit}" if unit else ""
        agreement = f"{name} {printed_value:.4g}{suffix} met" if abs(error) < 5e-4 else ""
        errors[name] = (
            error,
            agreement or f"{name} {fitted_value:.4g}{suffix} for {printed_value:.4g}{suffix} ({100 * error:+.2g} %)",
        )
    return errors


class DCNameplate(Nameplate):
    """Data printed on a DC motor with a separate field or permanent magnets: the rated point, and the one without load.

    ``power`` on the shaft, or ``torque``. Needed besides is the ``no_load_speed``; or ``current`` with ``armature_resistance``;
    or ``current`` with ``no_load_current``, from which the losses give the resistance.
    """

    voltage: SI[float] = si("V", "rated voltage", "U_n", gt=0, help="rated voltage of the armature")
    speed: SI[float] = si("rad/s", "rated speed", "n_n", gt=0, help="rated speed of the shaft")
    power: SI[float | None] = si(
        "W", "rated power on the shaft", "P_n", default=None, gt=0, help="rated power on the shaft; or `torque`"
    )
    torque: SI[float | None] = si("N m", "rated torque", "T_n", default=None, gt=0, help="rated torque, instead of `power`")
    current: SI[float | None] = si("A", "rated current of the armature", "I_n", default=None, gt=0, help=(
        "rated current of the armature, beside `armature_resistance` or `no_load_current`"
    ))  # fmt: skip
    no_load_speed: SI[float | None] = si(
        "rad/s", "no-load speed", "n_0", default=None, gt=0, help="no-load speed at the rated voltage; or give `current`"
    )
    no_load_current: SI[float | None] = si("A", "no-load current of the armature", "I_0", default=None, ge=0)
    armature_resistance: SI[float | None] = si("ohm", "resistance of the armature", "R_A", default=None, gt=0)

    @property
    def shaft_torque(self) -> float:
        """The rated torque in N m."""
        return self.torque if self.torque is not None else (self.power or 0.0) / self.speed

    @property
    def resistance(self) -> float | None:
        """Resistance of the armature in ohm: as printed, else by P = (U - R I) (I - I_0); None where that is not known."""
        if self.armature_resistance is not None or self.current is None or self.no_load_current is None:
            return self.armature_resistance
        induced_voltage = self.shaft_torque * self.speed / (self.current - self.no_load_current)
        return (self.voltage - induced_voltage) / self.current

    @model_validator(mode="after")
    def _check_consistency(self) -> DCNameplate:
        if (self.power is None) == (self.torque is None):
            raise ValueError("power", "give either the rated power on the shaft or the rated torque")
        if self.no_load_speed is not None and self.no_load_speed <= self.speed:
            raise ValueError("no_load_speed", "must be above the rated speed: a loaded motor is slower")
        if self.no_load_current is not None and self.current is not None and self.no_load_current >= self.current:
            raise ValueError("no_load_current", "must be below the rated current")
        if self.current is not None and self.shaft_torque * self.speed >= self.voltage * self.current:
            least = self.shaft_torque * self.speed / self.voltage
            raise ValueError("current", f"must be above {least:.4g} A: the input power must exceed the shaft's power")
        if self.no_load_speed is not None:
            return self
        if self.current is None or (resistance := self.resistance) is None:
            options = "no_load_speed, or current with armature_resistance, or current with no_load_current"
            raise ValueError("no_load_speed", f"give one of these: {options}")
        if not 0 < resistance * self.current < self.voltage:
            key = "armature_resistance" if self.armature_resistance is not None else "no_load_current"
            raise ValueError(key, f"does not fit power, voltage and current: the armature would have {resistance:.4g} ohm")
        return self

    def line(self) -> tuple[float, float]:
        """Return k Phi in V s and R_A in ohm of the line through the rated point that is zero at the no-load speed."""
        no_load = self.no_load_speed
        if no_load is None:
            assert self.current is not None and self.resistance is not None
            flux = (self.voltage - self.resistance * self.current) / self.speed
            no_load = self.speed + self.shaft_torque * self.resistance / flux**2
        flux = self.voltage / no_load
        return flux, flux * (self.voltage - flux * self.speed) / self.shaft_torque

    def errors(self, flux: float, resistance: float) -> dict[str, tuple[float, str]]:
        """Return the relative deviations of a line from the printed values, and their texts."""
        comparisons = {
            "rated torque": (self.shaft_torque, flux * (self.voltage - flux * self.speed) / resistance, "N m"),
        }
        if self.no_load_speed is not None:
            comparisons["no-load speed"] = self.no_load_speed, self.voltage / flux, "rad/s"
        if self.armature_resistance is not None:
            comparisons["armature resistance"] = self.armature_resistance, resistance, "ohm"
        if self.current is not None and self.no_load_current is not None:
            comparisons["rated current"] = self.current, self.shaft_torque / flux + self.no_load_current, "A"
        return fit_errors(comparisons)

    def fit_text(self, flux: float, resistance: float) -> str:
        """Return the line, and its deviations from the plate, as text."""
        errors = "; ".join(words for _, words in self.errors(flux, resistance).values())
        return f"line of the nameplate: flux times motor constant {flux:.4g} V s, armature {resistance:.4g} ohm; {errors}"

    def doubts(self, flux: float, resistance: float) -> tuple[str, ...]:
        """Return the values of the plate that the line misses by more than a tenth."""
        return tuple(words for error, words in self.errors(flux, resistance).values() if abs(error) > LARGE)


class InductionNameplate(Nameplate):
    """Data printed on an induction motor, or in its data sheet: the rated point, and torques as multiples of the rated one.

    Of ``efficiency``, ``power_factor`` and ``current`` two give the magnetising reactance and, with the losses, a bound on the
    resistance of the stator.
    """

    power: SI[float] = si("W", "rated power on the shaft", "P_n", gt=0)
    speed: SI[float] = si("rad/s", "rated speed", "n_n", gt=0, help="rated speed of the shaft")
    voltage: SI[float] = si("V", "rated voltage between two lines", "U_n", gt=0)
    connection: Literal["star", "delta"] = Field(default="star", description="connection of the windings")
    frequency: SI[float] = si("Hz", "rated frequency", "f_n", gt=0, help="rated frequency of the mains")
    poles: SI[float | None] = si(
        "", "number of poles", "2p", default=None, ge=2, help="number of poles, by default the one that fits the rated speed"
    )
    breakdown_torque_ratio: SI[float | None] = si(
        "",
        "breakdown torque over rated torque",
        "T_b/T_n",
        default=None,
        gt=1,
        help="breakdown torque over rated torque, by default that of typical motors of its power and poles",
    )
    starting_torque_ratio: SI[float | None] = si("", "starting torque over rated torque", "T_s/T_n", default=None, gt=0, help=(
        "starting torque over rated torque, by default typical if `breakdown_torque_ratio` is missing too, else by the circuit"
    ))  # fmt: skip
    efficiency: SI[float | None] = si("", "efficiency at the rated point", "eta", default=None, gt=0, lt=1)
    power_factor: SI[float | None] = si("", "power factor at the rated point", "cos phi", default=None, gt=0, lt=1)
    current: SI[float | None] = si("A", "rated current of a line", "I_n", default=None, gt=0)

    @property
    def typical(self) -> TypicalMotor:
        """A typical motor of its power and poles."""
        return TypicalMotor.of(self.power, 2 * self.pole_pairs)

    @property
    def breakdown_ratio(self) -> float:
        """The breakdown torque over the rated one, as given or typical, and no less than the starting torque."""
        return self.breakdown_torque_ratio or max(self.typical.breakdown, self.starting_torque_ratio or 0.0)

    @property
    def starting_ratio(self) -> float | None:
        """The starting torque over the rated one, as given or typical; None where it follows from a given breakdown torque."""
        typical = self.typical.starting if self.breakdown_torque_ratio is None else None
        return self.starting_torque_ratio or typical

    def estimates(self) -> tuple[str, ...]:
        """Return what the plate does not say and is estimated, each with its range, as text."""
        if self.breakdown_torque_ratio is not None:
            return ()
        least = self.starting_torque_ratio or 0.0
        breakdown = estimate_text("breakdown torque ratio", self.breakdown_ratio, BREAKDOWN_SPREAD, least=least)
        if self.starting_torque_ratio is not None:
            return (breakdown,)
        return breakdown, estimate_text("starting torque ratio", self.typical.starting, STARTING_SPREAD)

    @property
    def pole_pairs(self) -> float:
        """Number of pole pairs, by default the largest with a positive slip."""
        return (
            self.poles / 2 if self.poles is not None else float(max(math.floor(2 * math.pi * self.frequency / self.speed), 1))
        )

    @property
    def synchronous(self) -> float:
        """The synchronous speed in rad/s."""
        return 2 * math.pi * self.frequency / self.pole_pairs

    @property
    def slip(self) -> float:
        """The rated slip."""
        return 1 - self.speed / self.synchronous

    @property
    def phase_voltage(self) -> float:
        """The voltage of a phase in V."""
        return self.voltage / math.sqrt(3) if self.connection == "star" else self.voltage

    @property
    def torque(self) -> float:
        """The rated torque in N m."""
        return self.power / self.speed

    @property
    def input_power(self) -> float | None:
        """Input power in W, by efficiency, else by current and power factor; None where neither is printed."""
        if self.efficiency is not None:
            return self.power / self.efficiency
        if self.current is not None and self.power_factor is not None:
            return math.sqrt(3) * self.voltage * self.current * self.power_factor
        return None

    @property
    def cosine(self) -> float | None:
        """The power factor, printed or by current and efficiency; None where neither is known."""
        if self.power_factor is not None or self.input_power is None or self.current is None:
            return self.power_factor
        return self.input_power / (math.sqrt(3) * self.voltage * self.current)

    @property
    def phase_current(self) -> float | None:
        """The current of a phase in A, None where it is not known."""
        line = self.current
        if line is None and self.input_power is not None and self.power_factor is not None:
            line = self.input_power / (math.sqrt(3) * self.voltage * self.power_factor)
        return line if line is None or self.connection == "star" else line / math.sqrt(3)

    @property
    def other_losses(self) -> float | None:
        """Losses outside the cage, in W."""
        return None if self.input_power is None else self.input_power - self._air_gap_power

    @property
    def _air_gap_power(self) -> float:
        """The power in W that crosses the air gap."""
        return self.power / (1 - self.slip)

    @model_validator(mode="after")
    def _check_consistency(self) -> InductionNameplate:
        if self.poles is not None and self.poles % 2:
            raise ValueError("poles", "must be an even number of poles")
        if self.slip <= 0:
            rpm = self.synchronous * 30 / math.pi
            fields = f"{self.pole_pairs * 2:g} poles at {self.frequency:g} Hz"
            raise ValueError("speed", f"must be less than the synchronous speed {rpm:.6g} rpm of {fields}: this motor slips")
        if self.slip > _MOST_SLIP:
            with_poles = f"with {2 * self.pole_pairs:g} poles the rated slip would be {100 * self.slip:.0f} %"
            raise ValueError(
                "speed" if self.poles is None else "poles", f"{with_poles}: must be at most {100 * _MOST_SLIP:.0f} %"
            )
        if self.other_losses is not None and self.input_power is not None and self.other_losses <= 0:
            key = "efficiency" if self.efficiency is not None else "power_factor"
            limit = (
                1 - self.slip
                if self.efficiency is not None
                else (self.power_factor or 0.0) * self._air_gap_power / self.input_power
            )
            side = "below" if self.efficiency is not None else "above"
            raise ValueError(key, f"must be {side} {limit:.4g}: the cage alone loses the slip, {self.slip:.3g} of its power")
        if self.cosine is not None and self.cosine >= 1:
            least_current = (self.input_power or 0.0) / (math.sqrt(3) * self.voltage)
            raise ValueError("current", f"must be more than {least_current:.4g} A, by power, efficiency and voltage")
        return self
