"""Records that cannot hold orders, and numbers that are not what they are said to be, told before they are fitted."""

from __future__ import annotations

import math

import numpy as np

from wucht.errors import InputError
from wucht.measurements.order_regression import Fit, Mean, OrderModel
from wucht.measurements.order_start import START_BLOCKS, block_means, middle, start
from wucht.measurements.shaft_signal import TURN, ShaftSignal

_GAP = 10.0  # times the median step
_TURNS = 60.0  # in the middle of a record, in which the numbers are looked at
_NYQUIST = 2.02  # samples a period, and a little, for the speed is not yet known well
_BETTER = 0.5  # of the squares left
_OFF = 1e-3  # of omega
_NEAR = 0.02  # of omega: the same speed
_UNITS = (("rpm", 2 * math.pi / 60), ("Hz", 2 * math.pi), ("deg/s", math.pi / 180))


def check_samples(shaft: ShaftSignal, omega: float, orders: np.ndarray) -> None:
    """Raises ``InputError`` for a record that cannot hold the orders (K,) at about omega in rad/s."""
    where, count, span = shaft.where, len(shaft.time), float(np.ptp(shaft.time))
    turns = omega * span / TURN
    if turns <= 0:
        allowed = f"the shaft stands, or turns backwards ({omega:.4g} rad/s on average): turn the sign with scaled(-1, UNIT)"
        raise InputError(where, None, allowed)
    if turns < 1:
        allowed = f"the record is shorter than a turn ({turns:.2g} turns at {omega:.4g} rad/s): record several turns"
        raise InputError(where, None, allowed)
    steps = np.diff(shaft.time)
    longest = int(steps.argmax())
    if steps[longest] > _GAP * float(np.median(steps)) and steps[longest] * omega > TURN:
        allowed = (
            f"there is a gap of {steps[longest]:.4g} s, {steps[longest] * omega / TURN:.3g} turns, after "
            f"{shaft.time[longest]:.6g} s: cut the record to one side of it"
        )
        raise InputError(where, None, allowed)
    highest, parameters = int(orders[-1]), 3 + 2 * len(orders)
    a_turn = (count - 1) / turns
    if a_turn < _NYQUIST * highest or count < parameters:
        needed = f"order {highest} needs more than {2 * highest}" if count >= parameters else f"these need {parameters} in all"
        raise InputError(f"{where}: orders", orders.tolist(), f"there are {a_turn:.3g} samples a turn, and {needed}")


def check_unit(shaft: ShaftSignal, time: np.ndarray, omega: float, orders: np.ndarray) -> None:
    """Raises ``InputError`` for a speed without a unit that repeats as if its numbers were rpm, Hz or deg/s, not rad/s.

    time (n,): from the middle of the record in s. omega: the mean of the numbers.
    """
    if shaft.quantity != "speed" or shaft.unit_stated or omega <= 0:
        return
    left = {unit: _share_left(time, shaft.values, orders, omega * k) for unit, k in (("rad/s", 1.0), *_UNITS)}
    unit = min(left, key=lambda u: left[u])
    if left[unit] < _BETTER * left["rad/s"]:
        column = shaft.where.rsplit(": ", 1)[-1]
        allowed = (
            f"the numbers have no unit and would be rad/s, but they repeat as if they were {unit}: write the unit into the "
            f"heading, as in {column} [{unit}]"
        )
        raise InputError(shaft.where, None, allowed)


def _share_left(time: np.ndarray, values: np.ndarray, orders: np.ndarray, omega: float) -> float:
    """Of the variance, when orders of about omega are taken out, the mean being free; 1 where the record does not tell."""
    turns = omega * float(np.ptp(time)) / TURN
    if turns < 2 or len(time) <= 2 * orders[-1] * turns:
        return 1.0
    model = OrderModel(orders, Mean.FREE)
    t, y = block_means(*middle(time, values, _TURNS * TURN / omega), TURN / omega / orders[-1] / START_BLOCKS)
    spread = float(np.var(y))
    if len(t) <= 2 * model.size or spread == 0:
        return 1.0
    fit = start(model, t, y, omega)
    return fit.variance / spread if abs(fit.theta[0] / omega - 1) < _NEAR else 1.0


def scale_warning(model: OrderModel, time: np.ndarray, values: np.ndarray, fit: Fit) -> tuple[str, ...]:
    """A sentence where orders repeat at another speed than the mean of the signal says: where its scale is wrong.

    time, values (B,): block means, from the middle of the record. fit: of these, with the mean as the fundamental.
    """
    if model.mean is not Mean.SPEED:
        return ()
    omega = float(fit.theta[0])
    t, y = middle(time, values, _TURNS * TURN / omega)
    free, bound = start(OrderModel(model.orders, Mean.FREE), t, y, omega), start(model, t, y, omega)
    ratio = float(free.theta[1] / free.theta[0])
    if not free.converged or free.squares > _BETTER * bound.squares or not _OFF < abs(ratio - 1) < 0.2:
        return ()
    return (
        f"The mean of the numbers is {ratio:.5g} times the speed at which their orders repeat, and no motion has both: the "
        f"scale of the sensor is wrong; divide the numbers by {ratio:.5g}.",
    )
