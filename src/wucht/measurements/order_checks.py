"""Records that cannot hold orders, told before these are fitted."""

from __future__ import annotations

import numpy as np

from wucht.errors import InputError
from wucht.measurements.shaft_signal import TURN, ShaftSignal

_GAP = 10.0  # times the median step
_NYQUIST = 2.02  # samples a period, and a little, for the speed is not yet known well
_STANDS = 0.05  # turns: so few are none
_FAR = 5.0  # times as far from the median as all samples but few: one that sticks out
_FEW = 0.01  # of the samples may stick out
_LARGE = 0.2  # of the median: a smaller distance does no harm


def check_samples(shaft: ShaftSignal, omega: float, orders: np.ndarray) -> None:
    """Raises ``InputError`` for a record that cannot hold the orders (K,) at about omega in rad/s."""
    where, count, span = shaft.where, len(shaft.time), float(np.ptp(shaft.time))
    turns = omega * span / TURN
    if -_STANDS < turns <= 0:
        allowed = (
            f"the shaft stands: {omega:.4g} rad/s on average, {turns:.2g} turns in {span:.4g} s; are column and unit right?"
        )
        raise InputError(where, None, allowed, code="stands-still")
    if turns < 0:
        allowed = (
            f"the shaft turns backwards ({omega:.4g} rad/s on average): turn the sign with the key scale, as in scale = -1"
        )
        raise InputError(where, None, allowed, code="turns-back")
    if turns < 1:
        told = f"the record is shorter than a turn ({turns:.2g} turns at {omega:.4g} rad/s)"
        allowed = f"{told}: record several turns, or check the unit of the speed"
        raise InputError(where, None, allowed, code="too-short")
    steps = np.diff(shaft.time)
    longest = int(steps.argmax())
    if steps[longest] > _GAP * float(np.median(steps)) and steps[longest] * omega > TURN:
        allowed = (
            f"there is a gap of {steps[longest]:.4g} s, {steps[longest] * omega / TURN:.3g} turns, after "
            f"{shaft.time[longest]:.6g} s: cut the record to one side of it"
        )
        raise InputError(where, None, allowed, code="gap")
    highest, parameters = int(orders[-1]), 3 + 2 * len(orders)
    a_turn = (count - 1) / turns
    if a_turn < _NYQUIST * highest or count < parameters:
        needed = f"order {highest} needs more than {2 * highest}" if count >= parameters else f"these need {parameters} in all"
        units = "; are the units of time and speed right?" if a_turn < _NYQUIST else ""
        raise InputError(f"{where}: orders", orders.tolist(), f"there are {a_turn:.3g} samples a turn, and {needed}{units}")


def check_outliers(shaft: ShaftSignal) -> None:
    """Raises ``InputError`` for samples of a speed that stick out, and names the farthest: one of them spoils the mean."""
    if shaft.quantity != "speed":
        return
    median = float(np.median(shaft.values))
    off = np.abs(shaft.values - median)
    usual = float(np.quantile(off, 1 - _FEW))
    out = np.flatnonzero(off > max(_FAR * usual, _LARGE * abs(median)))
    if len(out):
        i = int(off.argmax())
        others = f" {len(out) - 1} others stick out, too;" if len(out) > 1 else ""
        allowed = (
            f"sample {i + 1}, at {shaft.time[i]:.6g} s, sticks out: it is {shaft.stated(float(shaft.values[i]))}, and the "
            f"median of all is {shaft.stated(median)};{others} take such samples out"
        )
        raise InputError(shaft.where, None, allowed)
