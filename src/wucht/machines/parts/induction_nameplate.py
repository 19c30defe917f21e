"""The nameplate of an induction motor."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field, model_validator

from wucht.machines.parts.nameplate import Nameplate
from wucht.schema import si

_MOST_SLIP = 0.3  # more, and speed, frequency or poles are mistaken


class InductionNameplate(Nameplate):
    """What is printed on an induction motor, or in its data sheet: the rated point, and torques as multiples of the rated one.

    Of ``efficiency``, ``power_factor`` and ``current`` two give the magnetising reactance and, with the losses, a bound on the
    resistance of the stator.
    """

    power: float = si("W", "rated power on the shaft", "P_n", gt=0)
    speed: float = si("rad/s", "rated speed", "n_n", gt=0, help="rated speed of the shaft")
    voltage: float = si("V", "rated voltage between two lines", "U_n", gt=0)
    connection: Literal["star", "delta"] = Field("star", description="connection of the windings")
    frequency: float = si("Hz", "rated frequency", "f_n", gt=0, help="rated frequency of the mains")
    poles: float | None = si(
        "", "number of poles", "2p", None, ge=2, help="number of poles, by default as many as the rated speed says"
    )
    breakdown_torque_ratio: float = si("", "breakdown torque over rated torque", "T_b/T_n", gt=1)
    starting_torque_ratio: float | None = si("", "starting torque over rated torque", "T_s/T_n", None, gt=0)
    efficiency: float | None = si("", "efficiency at the rated point", "eta", None, gt=0, lt=1)
    power_factor: float | None = si("", "power factor at the rated point", "cos phi", None, gt=0, lt=1)
    current: float | None = si("A", "rated current of a line", "I_n", None, gt=0)

    @property
    def pole_pairs(self) -> float:
        """By default the most with which the motor slips."""
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
        """What the motor draws in W, by its efficiency, else by current and power factor; None where neither is printed."""
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
        """Those outside the cage, in W."""
        return None if self.input_power is None else self.input_power - self._crossing

    @property
    def _crossing(self) -> float:
        """The power in W that crosses the air gap."""
        return self.power / (1 - self.slip)

    @model_validator(mode="after")
    def _possible(self) -> InductionNameplate:
        if self.poles is not None and self.poles % 2:
            raise ValueError("poles", "must be an even number of poles")
        if self.slip <= 0:
            rpm = self.synchronous * 30 / math.pi
            fields = f"{self.pole_pairs * 2:g} poles at {self.frequency:g} Hz"
            raise ValueError("speed", f"must be less than the synchronous speed {rpm:.6g} rpm of {fields}: this motor slips")
        if self.slip > _MOST_SLIP:
            with_poles = f"with {2 * self.pole_pairs:g} poles the rated slip would be {self.slip:.0%}"
            raise ValueError("speed" if self.poles is None else "poles", f"{with_poles}: must be at most {_MOST_SLIP:.0%}")
        if self.other_losses is not None and self.input_power is not None and self.other_losses <= 0:
            key = "efficiency" if self.efficiency is not None else "power_factor"
            bound = (
                1 - self.slip if self.efficiency is not None else (self.power_factor or 0.0) * self._crossing / self.input_power
            )
            side = "below" if self.efficiency is not None else "above"
            raise ValueError(key, f"must be {side} {bound:.4g}: the cage alone loses the slip, {self.slip:.3g} of what it gets")
        if self.cosine is not None and self.cosine >= 1:
            least_current = (self.input_power or 0.0) / (math.sqrt(3) * self.voltage)
            raise ValueError("current", f"must be more than {least_current:.4g} A, by power, efficiency and voltage")
        return self
