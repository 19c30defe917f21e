"""The nameplate of a DC motor with a constant flux, and the straight line of torque over speed that follows from it.

A motor of armature resistance R_A and flux k Phi turns by U = R_A I + k Phi w, and gives the shaft k Phi I less what friction
and iron take, k Phi I_0 by its no-load current I_0 (A. E. Fitzgerald et al., Electric Machinery, chapter 7). So the torque
on the shaft is a straight line with the slope (k Phi)^2/R_A that is zero at the no-load speed, and as such it is kept: through
the rated point and the no-load point, k Phi = U/w_0, with friction and iron losses in it, exact at the rated voltage.
"""

from __future__ import annotations

from pydantic import model_validator

from wucht.machines.parts.nameplate import LARGE, Nameplate, missed
from wucht.schema import si


class DCNameplate(Nameplate):
    """What is printed on a DC motor with a separate field or permanent magnets: the rated point, and the one without load.

    ``power`` on the shaft, or ``torque``. Needed besides is the ``no_load_speed``; or ``current`` with ``armature_resistance``;
    or ``current`` with ``no_load_current``, from which the losses give the resistance.
    """

    voltage: float = si("V", "rated voltage", "U_n", gt=0, help="rated voltage of the armature")
    speed: float = si("rad/s", "rated speed", "n_n", gt=0, help="rated speed of the shaft")
    power: float | None = si("W", "rated power on the shaft", "P_n", None, gt=0, help="rated power on the shaft; or `torque`")
    torque: float | None = si("N m", "rated torque", "T_n", None, gt=0, help="rated torque, instead of `power`")
    current: float | None = si("A", "rated current of the armature", "I_n", None, gt=0, help=(
        "rated current of the armature, beside `armature_resistance` or `no_load_current`"
    ))  # fmt: skip
    no_load_speed: float | None = si(
        "rad/s", "no-load speed", "n_0", None, gt=0, help="no-load speed at the rated voltage; or give `current`"
    )
    no_load_current: float | None = si("A", "no-load current of the armature", "I_0", None, ge=0)
    armature_resistance: float | None = si("ohm", "resistance of the armature", "R_A", None, gt=0)

    @property
    def shaft_torque(self) -> float:
        """The rated torque in N m."""
        return self.torque if self.torque is not None else (self.power or 0.0) / self.speed

    @property
    def resistance(self) -> float | None:
        """Of the armature in ohm: as printed, else by P = (U - R I) (I - I_0); None where that is not known."""
        if self.armature_resistance is not None or self.current is None or self.no_load_current is None:
            return self.armature_resistance
        induced = self.shaft_torque * self.speed / (self.current - self.no_load_current)
        return (self.voltage - induced) / self.current

    @model_validator(mode="after")
    def _possible(self) -> DCNameplate:
        if (self.power is None) == (self.torque is None):
            raise ValueError("power", "needed is the rated power on the shaft or the rated torque, one of both")
        if self.no_load_speed is not None and self.no_load_speed <= self.speed:
            raise ValueError("no_load_speed", "must be above the rated speed: a loaded motor is slower")
        if self.no_load_current is not None and self.current is not None and self.no_load_current >= self.current:
            raise ValueError("no_load_current", "must be below the rated current")
        if self.current is not None and self.shaft_torque * self.speed >= self.voltage * self.current:
            least = self.shaft_torque * self.speed / self.voltage
            raise ValueError("current", f"must be above {least:.4g} A: less than the shaft's power would be supplied")
        if self.no_load_speed is not None:
            return self
        if self.current is None or (resistance := self.resistance) is None:
            needed = "no_load_speed, or current with armature_resistance, or current with no_load_current"
            raise ValueError("no_load_speed", f"needed is one of these: {needed}")
        if not 0 < resistance * self.current < self.voltage:
            key = "armature_resistance" if self.armature_resistance is not None else "no_load_current"
            raise ValueError(key, f"does not fit power, voltage and current: the armature would have {resistance:.4g} ohm")
        return self

    def line(self) -> tuple[float, float]:
        """k Phi in V s and R_A in ohm of the line through the rated point that is zero at the no-load speed."""
        no_load = self.no_load_speed
        if no_load is None:
            assert self.current is not None and self.resistance is not None
            flux = (self.voltage - self.resistance * self.current) / self.speed
            no_load = self.speed + self.shaft_torque * self.resistance / flux**2
        flux = self.voltage / no_load
        return flux, flux * (self.voltage - flux * self.speed) / self.shaft_torque

    def errors(self, flux: float, resistance: float) -> dict[str, tuple[float, str]]:
        """By how much a line misses what is printed, relatively, and in words."""
        compared = {
            "rated torque": (self.shaft_torque, flux * (self.voltage - flux * self.speed) / resistance, "N m"),
        }
        if self.no_load_speed is not None:
            compared["no-load speed"] = self.no_load_speed, self.voltage / flux, "rad/s"
        if self.armature_resistance is not None:
            compared["armature resistance"] = self.armature_resistance, resistance, "ohm"
        if self.current is not None and self.no_load_current is not None:
            compared["rated current"] = self.current, self.shaft_torque / flux + self.no_load_current, "A"
        return missed(compared)

    def fit_in_words(self, flux: float, resistance: float) -> str:
        """The line, and by how much it misses what is printed."""
        errors = "; ".join(words for _, words in self.errors(flux, resistance).values())
        return f"line of the nameplate: flux times motor constant {flux:.4g} V s, armature {resistance:.4g} ohm; {errors}"

    def doubts(self, flux: float, resistance: float) -> tuple[str, ...]:
        """What of the plate the line misses by more than a tenth."""
        return tuple(words for error, words in self.errors(flux, resistance).values() if abs(error) > LARGE)
