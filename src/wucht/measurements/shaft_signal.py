"""Signals of a shaft in a record: its pulses, its speed, or its angle, over time."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from wucht.errors import InputError
from wucht.measurements.recording import ANGLE_UNIT, SPEED_UNIT, TIME_UNIT, Channel, Recording
from wucht.schema import Unit

HYSTERESIS = 0.2  # of the swing, to each side of the middle
_AROUND = 5  # intervals, whose median is the expected one
_MISSING = 1.6  # times that: a pulse is missing
_FALSE = 1.2  # times that, of two together: a false pulse cuts one in two
_TIMES = ("s", "ms", "us", "µs", "ns")
Quantity = Literal["speed", "angle", "pulses"]
TURN = 2 * math.pi
_LONGEST_STEP = 0.4  # turns: over longer steps a wrapped angle may have gone either way
_STANDS = 1e-9  # rad: no larger angle is a motion
_A_SECOND = re.compile(r"1\s*/\s*s(?:ec|ek)?|s\s*\^?\s*(?:-1|⁻¹)", re.IGNORECASE)
_NAMES: tuple[tuple[str, Quantity], ...] = (
    ("speed|drehzahl|drehgeschwindigkeit|winkelgeschwindigkeit", "speed"),
    ("angle|winkel(?!beschleunigung)|drehwinkel", "angle"),
    ("pulse|impuls", "pulses"),
)


def _holds_instants(channel: Channel) -> bool:
    """True if a channel is a list of instants, being in a unit of time, and not a signal."""
    return channel.unit in _TIMES


def pulse_times(channel: Channel, level: float | None = None, hysteresis: float = HYSTERESIS, least: int = 2) -> np.ndarray:
    """Return the instants of the pulses of a channel.

    A channel in a unit of time holds the instants themselves. Any other is a signal, square or not, whose rising crossings of a
    level are pulses.

    Parameters
    ----------
    channel : Channel
    level : float, optional
        By default half-way between the least and the greatest value.
    hysteresis : float, optional
        Share of that swing by which the signal must have been below the level, and must then be above, so that noise at the
        level is no pulse.
    least : int, optional
        The least number of pulses.

    Returns
    -------
    numpy.ndarray, (m,)
        In s, interpolated between samples.

    Raises
    ------
    InputError
        For fewer pulses, instants that do not increase, and a constant signal.
    """
    if _holds_instants(channel):
        times = channel.to_si(TIME_UNIT).values
        return Channel(channel.source, channel.name, "s", times, times).time
    times = rising_crossings(channel, level, hysteresis)
    if len(times) < least:
        explanation = f"there must be at least {least} pulses; the signal rises through its middle {len(times)} times"
        raise InputError(channel.location, None, explanation, code="too-few")
    return times


def rising_crossings(channel: Channel, level: float | None = None, hysteresis: float = HYSTERESIS) -> np.ndarray:
    """Return the times (m,) at which a signal rises through a level, in s, interpolated between samples.

    level: by default half-way between the least and the greatest value. hysteresis: share of that swing by which the signal
    must have been below, and must then be above, so that noise at the level is no pulse. Raises ``InputError`` for a constant.
    """
    x, time = channel.values, channel.time
    low, high = float(x.min()), float(x.max())
    if low == high:
        raise InputError(
            channel.location, None, f"the signal is constant ({low:.6g}): no pulses; is this the right column?", code="constant"
        )
    middle, margin = (low + high) / 2 if level is None else level, hysteresis * (high - low)
    state = np.where(x > middle + margin, 1, np.where(x < middle - margin, -1, 0))
    clear_samples = np.flatnonzero(state)
    risen = clear_samples[1:][np.diff(state[clear_samples]) == 2]
    rising = np.flatnonzero((x[:-1] < middle) & (x[1:] >= middle))
    before = rising[np.searchsorted(rising, risen, side="left") - 1]  # the last one by which it comes up there
    share = (middle - x[before]) / (x[before + 1] - x[before])
    return np.asarray(time[before] + share * (time[before + 1] - time[before]))


def check_even(times: np.ndarray, location: str, remedy: str = "take it out") -> None:
    """Raise ``InputError`` if a pulse is missing, or is one too many, among the instants (m,): by the intervals around.

    remedy: what to do about a pulse too many, other than to cut the record.
    """
    steps = np.diff(times)
    if len(steps) < _AROUND:
        return
    usual = np.median(np.lib.stride_tricks.sliding_window_view(steps, _AROUND), axis=1)
    usual = np.pad(usual, _AROUND // 2, mode="edge")
    missing = np.flatnonzero(steps > _MISSING * usual)
    if len(missing):
        i = int(missing[0])
        explanation = (
            f"pulses are missing between {times[i]:.6g} s and {times[i + 1]:.6g} s: the interval is {steps[i] / usual[i]:.3g} "
            "times those around it; cut the record there (a wheel with missing teeth cannot be read)"
        )
        raise InputError(location, None, explanation, code="pulses-missing")
    false = np.flatnonzero(steps[:-1] + steps[1:] < _FALSE * np.minimum(usual[:-1], usual[1:]))
    if len(false):
        i = int(false[0]) + 1
        explanation = f"there is a pulse too many near {times[i]:.6g} s: {remedy}, or cut the record there"
        raise InputError(location, None, explanation, code="pulse-too-many")


@dataclass(frozen=True, eq=False)
class ShaftSignal:
    """The speed or the angle of a shaft over time.

    Attributes
    ----------
    location : str
        File and column.
    quantity : {"speed", "angle"}
    time : numpy.ndarray, (n,)
        In s.
    values : numpy.ndarray, (n,)
        The speed in rad/s or the angle in rad, not wrapped.
    index : numpy.ndarray, (k,)
        Instants in s at which the shaft is at its zero; none without an index pulse.
    unit : str
        That of the numbers as they were recorded, "" if none is stated.
    per_turn : int or None
        Of pulses.
    warnings : tuple of str
        Sentences on what to check.
    """

    location: str
    quantity: Literal["speed", "angle"]
    time: np.ndarray
    values: np.ndarray
    index: np.ndarray = field(default_factory=lambda: np.empty(0))
    unit: str = ""
    per_turn: int | None = None
    warnings: tuple[str, ...] = ()

    def format_speed(self, speed: float) -> str:
        """Format a speed in rad/s in the unit of the record, for sentences."""
        if self.quantity != "speed" or not self.unit:
            return f"{speed:.5g} rad/s"
        return f"{speed / SPEED_UNIT.parse_quantity(f'1 {self.unit}'):.5g} {self.unit}"

    def speed(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times in s and the speed in rad/s: as measured, or from differences of the angle, midway between samples."""
        if self.quantity == "speed":
            return self.time, self.values
        steps = np.diff(self.time)
        return self.time[:-1] + steps / 2, np.diff(self.values) / steps

    def angle(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times in s and the angle in rad, zero at the index pulse if there is one: measured, or the speed integrated.

        Raises ``InputError`` for an index pulse at other times than these.
        """
        angles = self.values
        if self.quantity == "speed":
            from scipy.interpolate import CubicSpline

            angles = CubicSpline(self.time, self.values).antiderivative()(self.time)
        if not len(self.index):
            return self.time, angles
        index_times = self.index[(self.index >= self.time[0]) & (self.index <= self.time[-1])]
        if not len(index_times):
            raise InputError(
                self.location,
                None,
                "the index pulse does not occur in this record: record it at the same time",
                code="no-index",
            )
        return self.time, angles - mean_direction(np.interp(index_times, self.time, angles))


def mean_direction(angles: np.ndarray) -> float:
    """Return the mean of angles in rad of which whole turns do not count."""
    return float(np.angle(np.exp(1j * angles).mean()))


def speed_signal(channel: Channel, index: Channel | None = None, hysteresis: float = HYSTERESIS) -> ShaftSignal:
    """Create a shaft signal of a speed, in any unit of angular speed; without one in rad/s.

    Parameters
    ----------
    channel : Channel
    index : Channel, optional
        Pulses, one a turn.
    hysteresis : float, optional
        Of the pulses of the index: see ``pulse_times``.

    Returns
    -------
    ShaftSignal

    Raises
    ------
    InputError
        For a unit of another dimension.
    """
    warnings: tuple[str, ...] = ()
    if _A_SECOND.fullmatch(channel.unit):
        warnings = (
            f"{channel.location}: {channel.unit!r} does not say whether turns or radians, and is read as turns per second, as "
            'rotational frequencies are written; for radians give unit = "rad/s".',
        )
        channel = replace(channel, unit="Hz")
    speed, zero = channel.to_si(SPEED_UNIT), _index(index, hysteresis)
    return ShaftSignal(channel.location, "speed", speed.time, speed.values, zero, channel.unit, warnings=warnings)


def angle_signal(channel: Channel, index: Channel | None = None, hysteresis: float = HYSTERESIS) -> ShaftSignal:
    """Create a shaft signal of an angle, in any unit of angle; without one in rad. Jumps back after whole turns are unwrapped.

    Parameters
    ----------
    channel : Channel
    index : Channel, optional
        Pulses, one a turn.
    hysteresis : float, optional
        Of the pulses of the index: see ``pulse_times``.

    Returns
    -------
    ShaftSignal

    Raises
    ------
    InputError
        For a unit of another dimension, an angle that stands still, and a wrapped one in too long steps.
    """
    angle = channel.to_si(ANGLE_UNIT)
    if np.ptp(angle.values) < _STANDS:
        raise InputError(
            channel.location, None, "the angle is constant: the shaft does not turn; is this the right column?", code="constant"
        )
    return ShaftSignal(channel.location, "angle", angle.time, _unwrap_angle(angle), _index(index, hysteresis), channel.unit)


def pulse_signal(channel: Channel, per_turn: int, index: Channel | None = None, hysteresis: float = HYSTERESIS) -> ShaftSignal:
    """Create a shaft signal of an encoder's pulses: instants (a channel in a unit of time), or a signal that rises at each.

    Parameters
    ----------
    channel : Channel
    per_turn : int
        Pulses a turn.
    index : Channel, optional
        Pulses, one a turn: there the angle is zero, else at the first pulse.
    hysteresis : float, optional
        Of pulses that are a signal: see ``pulse_times``.

    Returns
    -------
    ShaftSignal
        Of the angle.

    Raises
    ------
    InputError
        For pulses a turn that are no whole number, pulses missing or too many, and as ``pulse_times``.
    """
    if isinstance(per_turn, bool) or int(per_turn) != per_turn or per_turn < 1:
        raise InputError(channel.location, per_turn, "the pulses per turn must be a whole number, 1 or more")
    times, zero = pulse_times(channel, hysteresis=hysteresis), _index(index, hysteresis)
    remedy = "take it out" if _holds_instants(channel) else f"raise the hysteresis above {hysteresis:g} with the key hysteresis"
    check_even(times, channel.location, remedy)
    angles = TURN / per_turn * np.arange(len(times))
    return ShaftSignal(channel.location, "angle", times, angles, zero, per_turn=per_turn)


def shaft_signal(
    recording: Recording,
    column: str,
    quantity: Quantity | None = None,
    per_turn: int | None = None,
    index: str | None = None,
    unit: str | None = None,
    scale: float | None = None,
    hysteresis: float | None = None,
) -> ShaftSignal:
    """Create the shaft signal of a column of a record. index: the column of an index pulse.

    quantity: of the column; by default from the beginning of its name (speed, angle or pulse; Drehzahl, Winkel, Impuls),
    else from its unit. unit: of the numbers, instead of the one that the file states. scale: a factor for them. hysteresis:
    of pulses that are a signal; see ``rising_crossings``.
    Raises ``InputError`` if neither is known, for pulses without their number a turn, and as the three functions above do.
    """
    channel = recording.channel(column).correct(unit, scale)
    zero = recording.channel(index) if index is not None else None
    kind, margin = quantity or _quantity(channel), HYSTERESIS if hysteresis is None else hysteresis
    if kind == "speed":
        return speed_signal(channel, zero, margin)
    if kind == "angle":
        return angle_signal(channel, zero, margin)
    if per_turn is None:
        explanation = "state the number of pulses of the encoder in a turn, with the key pulses_per_turn"
        raise InputError(channel.location, None, explanation, code="missing")
    return pulse_signal(channel, per_turn, zero, margin)


def _quantity(channel: Channel) -> Quantity:
    for names, quantity in _NAMES:
        if re.match(names, channel.name.rsplit("/", 1)[-1].strip(), re.IGNORECASE):
            return quantity
    units: tuple[tuple[Unit, Quantity], ...] = ((SPEED_UNIT, "speed"), (ANGLE_UNIT, "angle"))
    for unit, quantity in units:
        try:
            if channel.unit:
                unit.parse_quantity(f"1 {channel.unit}")
                return quantity
        except ValueError:
            continue
    explanation = 'state which quantity of the shaft this column holds, with the key quantity: "speed", "angle" or "pulses"'
    raise InputError(channel.location, None, explanation, code="no-quantity")


def _index(channel: Channel | None, hysteresis: float) -> np.ndarray:
    return np.empty(0) if channel is None else pulse_times(channel, hysteresis=hysteresis, least=1)


def _unwrap_angle(angle: Channel) -> np.ndarray:
    """Remove the jumps by whole turns that are against the direction of rotation, if there are such, from the angles."""
    steps = np.diff(angle.values)
    back = -steps * np.sign(np.median(steps))
    if back.max() <= np.ptp(angle.values) / 2 or back.max() < TURN * (1 - _LONGEST_STEP):
        return angle.values
    period = TURN * max(1, round(float(back.max()) / TURN))
    angles = np.unwrap(angle.values, period=period)
    longest = float(np.abs(np.diff(angles)).max())
    if longest > _LONGEST_STEP * period:
        i = int(np.abs(np.diff(angles)).argmax())
        explanation = (
            f"the wrapped angle advances by {longest / TURN:.2f} turns in the step from {angle.time[i]:.6g} s on, so that its "
            "path is ambiguous; sample faster, or cut the record where samples are missing"
        )
        raise InputError(angle.location, None, explanation, code="wraps-unclear")
    return np.asarray(angles)
