"""What a record says of a shaft: its speed, or its angle, over time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from wucht.errors import InputError
from wucht.measurements.pulses import check_even, pulse_times
from wucht.measurements.recording import ANGLE, SPEED, Channel, Recording

Quantity = Literal["speed", "angle", "pulses"]
TURN = 2 * math.pi
_LONGEST_STEP = 0.4  # turns: over longer steps a wrapped angle may have gone either way
_STANDS = 1e-9  # rad: no larger angle is a motion


@dataclass(frozen=True, eq=False)
class ShaftSignal:
    """The speed in rad/s or the angle in rad, not wrapped, of a shaft at times (n,) in s.

    where: file and column. index: instants in s at which the shaft stands at its zero; none without an index pulse.
    unit_stated: False where nobody said that the numbers are in SI.
    """

    where: str
    quantity: Literal["speed", "angle"]
    time: np.ndarray
    values: np.ndarray
    index: np.ndarray = field(default_factory=lambda: np.empty(0))
    unit_stated: bool = True

    def speed(self) -> tuple[np.ndarray, np.ndarray]:
        """Times in s and the speed in rad/s: that measured, or the differences of the angle in the middle between samples."""
        if self.quantity == "speed":
            return self.time, self.values
        steps = np.diff(self.time)
        return self.time[:-1] + steps / 2, np.diff(self.values) / steps

    def angle(self) -> tuple[np.ndarray, np.ndarray]:
        """Times in s and the angle in rad, zero at the index pulse if there is one: measured, or the speed integrated.

        Raises ``InputError`` for an index pulse at other times than these.
        """
        angles = self.values
        if self.quantity == "speed":
            from scipy.interpolate import CubicSpline

            angles = CubicSpline(self.time, self.values).antiderivative()(self.time)
        if not len(self.index):
            return self.time, angles
        seen = self.index[(self.index >= self.time[0]) & (self.index <= self.time[-1])]
        if not len(seen):
            raise InputError(self.where, None, "the index pulse does not come in this record: record it at the same time")
        return self.time, angles - mean_direction(np.interp(seen, self.time, angles))


def mean_direction(angles: np.ndarray) -> float:
    """The mean of angles in rad of which whole turns do not count."""
    return float(np.angle(np.exp(1j * angles).mean()))


def speed_signal(channel: Channel, index: Channel | None = None) -> ShaftSignal:
    """Of a speed, in any unit of angular speed; without one in rad/s. index: a channel of pulses, one a turn.

    Raises ``InputError`` for a unit of another dimension.
    """
    speed = channel.in_si(SPEED)
    return ShaftSignal(channel.where, "speed", speed.time, speed.values, _index(index), bool(channel.unit))


def angle_signal(channel: Channel, index: Channel | None = None) -> ShaftSignal:
    """Of an angle, in any unit of angle; without one in rad. One that jumps back after each turn (or several) is unwrapped.

    Raises ``InputError`` for a unit of another dimension, an angle that stands still, and a wrapped one in too long steps.
    """
    angle = channel.in_si(ANGLE)
    if np.ptp(angle.values) < _STANDS:
        raise InputError(channel.where, None, "the angle is constant: the shaft does not turn; is this the right column?")
    return ShaftSignal(channel.where, "angle", angle.time, _unwrapped(angle), _index(index), bool(channel.unit))


def pulse_signal(channel: Channel, per_turn: int, index: Channel | None = None) -> ShaftSignal:
    """Of an encoder's pulses: their instants (a channel in a unit of time), or a signal that rises at each of them.

    per_turn: pulses a turn. The angle is zero at the first pulse, or, with an index, there. Raises ``InputError`` for pulses
    a turn that are no whole number, pulses missing or too many, and what ``pulse_times`` raises.
    """
    if isinstance(per_turn, bool) or int(per_turn) != per_turn or per_turn < 1:
        raise InputError(channel.where, per_turn, "the pulses per turn must be a whole number, 1 or more")
    times = pulse_times(channel)
    check_even(times, channel.where)
    return ShaftSignal(channel.where, "angle", times, TURN / per_turn * np.arange(len(times)), _index(index))


def shaft_signal(
    recording: Recording, column: str, quantity: Quantity | None = None, per_turn: int | None = None, index: str | None = None
) -> ShaftSignal:
    """Of the column of a record. index: the column of an index pulse.

    quantity: what the column holds; by default what its name begins with ("speed", "angle" or "pulse"), else what its unit is.
    Raises ``InputError`` where neither says so, for pulses without their number a turn, and what the three functions above do.
    """
    channel, zero = recording.channel(column), recording.channel(index) if index is not None else None
    found = quantity or _quantity(channel)
    if found == "speed":
        return speed_signal(channel, zero)
    if found == "angle":
        return angle_signal(channel, zero)
    if per_turn is None:
        raise InputError(channel.where, None, "say how many pulses the encoder gives a turn")
    return pulse_signal(channel, per_turn, zero)


def _quantity(channel: Channel) -> Quantity:
    names: tuple[Quantity, ...] = ("speed", "angle", "pulses")
    for name in names:
        if channel.name.rsplit("/", 1)[-1].strip().lower().startswith(name.removesuffix("s")):
            return name
    for unit, quantity in ((SPEED, names[0]), (ANGLE, names[1])):
        try:
            if channel.unit:
                unit.parse(f"1 {channel.unit}")
                return quantity
        except ValueError:
            continue
    raise InputError(channel.where, None, "say whether this column holds the speed, the angle or pulses of the shaft")


def _index(channel: Channel | None) -> np.ndarray:
    return np.empty(0) if channel is None else pulse_times(channel, least=1)


def _unwrapped(angle: Channel) -> np.ndarray:
    """The angles without the jumps by whole turns that are against the direction of rotation, if there are such."""
    steps = np.diff(angle.values)
    back = -steps * np.sign(np.median(steps))
    if back.max() <= np.ptp(angle.values) / 2 or back.max() < TURN * (1 - _LONGEST_STEP):
        return angle.values
    period = TURN * max(1, round(float(back.max()) / TURN))
    unwrapped = np.unwrap(angle.values, period=period)
    longest = float(np.abs(np.diff(unwrapped)).max())
    if longest > _LONGEST_STEP * period:
        i = int(np.abs(np.diff(unwrapped)).argmax())
        allowed = (
            f"the wrapped angle goes on by {longest / TURN:.2f} turns in the step from {angle.time[i]:.6g} s on, so that its "
            "way is not known; sample faster, or cut the record where samples are missing"
        )
        raise InputError(angle.where, None, allowed)
    return np.asarray(unwrapped)
