"""The motor fed by an inverter: a speed controller with a limited torque."""

from __future__ import annotations

import math
from dataclasses import replace

import sympy as sp

from wucht.machines.parts.base import SI, Drive, Frame, si
from wucht.mechanics.energies import Energies, InternalState, StateDescription
from wucht.piecewise import CLAMP_TO_ONE, Pieces, PiecewiseCubic, step


class Inverter(Drive):
    """A PI controller of the speed that gives a torque up to a limit; its current control is taken as instantaneous.

    T = gain (set_speed - speed) + x, held within +-torque_limit; the integral part x follows the torque that is really given,
    integral_time x' = T - x. Below the limit that is x' = gain (set_speed - speed)/integral_time; at the limit x stays within
    it, so that nothing winds up: the automatic reset of K. J. Astrom, T. Hagglund, "PID Controllers: Theory, Design, and
    Tuning", 2nd ed., ISA 1995, section 3.5, back-calculation with the integral time. x begins at zero. With ``power_limit`` P
    the limit is P/|speed| above the speed P/torque_limit: field weakening. A schedule of ``set_speed`` is the ramp.
    """

    kind = "inverter"
    internal_states = (StateDescription("integral", "N m", "integral part", "tau"),)

    set_speed: SI[float] = si(
        "rad/s", "set speed", "omega_s", help="speed that the controller keeps; a schedule of it is the ramp"
    )
    gain: SI[float] = si("N m s", "gain of the controller", "K", gt=0)
    integral_time: SI[float] = si("s", "integral time", "T_i", gt=0, help="integral time of the controller")
    torque_limit: SI[float] = si("N m", "torque limit", "T_m", gt=0, help="largest torque in either sense")
    power_limit: SI[float | None] = si(
        "W",
        "power limit",
        "P",
        default=None,
        gt=0,
        help="largest power, which limits the torque at high speed: field weakening",
    )

    def no_load_path(self) -> str:
        """Return the path of ``set_speed``."""
        return f"{self.path}.set_speed"

    def held_speed(self) -> float:
        """Return the set speed, reduced to the body."""
        return self.set_speed if self.transmission is None else self.set_speed / self.transmission.ratio

    def limit(self, speed: sp.Expr) -> sp.Expr:
        """Return the largest torque at a speed, in either direction: torque_limit/max(|speed|/w_b, 1), w_b = P/torque_limit."""
        most, power = self.symbols("torque_limit", "power_limit")
        return most if self.power_limit is None else most / PiecewiseCubic(speed * most / power, _AT_LEAST_1)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """Return the steady torque: the limit below the set speed, against it above; at it any torque within, here zero."""
        below = self.symbol("set_speed") - speed
        return self.limit(speed) * (PiecewiseCubic(below, _POSITIVE) - PiecewiseCubic(-below, _POSITIVE))

    def linearisation(self, speed: float) -> tuple[float, float]:
        """Return a vertical line at the set speed."""
        return (math.inf, speed) if speed == self.held_speed() else super().linearisation(speed)

    def energies(self, frame: Frame) -> Energies:
        """Return the power of the torque, and the controller's state x."""
        target, gain, time, most = self.symbols("set_speed", "gain", "integral_time", "torque_limit")
        (state,) = self.internal_states
        x = state.at(self.path)

        def torque(speed: sp.Expr) -> sp.Expr:
            limit = self.limit(speed)
            return limit * PiecewiseCubic((gain * (target - speed) + x) / limit, CLAMP_TO_ONE)

        speed = self.ratio * (frame.speed(self.on) - (frame.rotation if self.stator == "carrier" else 0))
        controller = InternalState(x, (torque(speed) - x) / time, state, most, self.torque(speed))
        return replace(self.torque_energies(frame, torque), internal_states=(controller,))


_POSITIVE = step("positive", 0.0, 0.0, 1.0)
_AT_LEAST_1 = Pieces("max1", (-1.0, 1.0), ((1, -1, 0, 0), (1, 0, 0, 0), (1, 1, 0, 0)))
