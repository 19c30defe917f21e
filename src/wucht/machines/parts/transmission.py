"""The gear or belt between a motor and the body that it drives."""

from __future__ import annotations

import sympy as sp

from wucht.piecewise import ABSOLUTE, PiecewiseCubic
from wucht.schema import SI, TableModel, si

TRANSITION = 0.1  # rad/s, as in the load of dry friction


class Transmission(TableModel):
    """A rigid gear or belt: the motor turns ``ratio`` times as fast as the body."""

    ratio: SI[float] = si(
        "", "speed of the motor over that of the body", "i", gt=0, help="speed of the motor over that of the body"
    )
    inertia: SI[float] = si("kg m^2", "moment of inertia on the motor's side", "J_M", default=0.0, ge=0, help=(
        "moment of inertia of what turns with the motor"
    ))  # fmt: skip
    efficiency: SI[float | None] = si("", "efficiency", "eta", default=None, gt=0, le=1, help=(
        "part of the power that arrives on the other side, whichever way it flows; without it nothing is lost"
    ))  # fmt: skip
    transition_speed: SI[float] = si("rad/s", "speed of the transition at standstill", "w_t", default=TRANSITION, gt=0)

    def loss_torque(self, path: str, torque: sp.Expr, speed: sp.Expr) -> sp.Expr:
        """Return the loss torque of the transmission on the body, against its speed. torque: of the motor, on the body's side.

        A motor that drives brings eta T, one that is driven takes T/eta: in both flows
        L = (b abs(T) + c T sigma) sigma with b = (1/eta - eta)/2, c = 1 - (1/eta + eta)/2 and sigma = sign(speed), which gives
        abs(T)(1 - eta) and abs(T)(1/eta - 1). With sigma = tanh(speed/transition_speed) it is smooth at standstill, where it
        would hold like dry friction; as b >= abs(c), L times the speed is a loss at every speed.
        """
        if self.efficiency is None:
            return sp.S.Zero
        eta, transition = self.symbol(path, "efficiency"), self.symbol(path, "transition_speed")
        sigma, b, c = sp.tanh(speed / transition), (1 / eta - eta) / 2, 1 - (1 / eta + eta) / 2
        return (b * PiecewiseCubic(torque, ABSOLUTE) + c * torque * sigma) * sigma

    def symbol(self, path: str, key: str) -> sp.Symbol:
        """Return the symbol of a parameter. path: of the drive."""
        return sp.Symbol(f"{path}.transmission.{key}", real=True)
