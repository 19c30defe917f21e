"""Pulses: the instants at which a shaft passes its marks, from a list of times or from a signal."""

from __future__ import annotations

import numpy as np

from wucht.errors import InputError
from wucht.measurements.recording import TIME, Channel

HYSTERESIS = 0.2  # of the swing, to each side of the middle
_AROUND = 5  # intervals, whose median is what one should be
_MISSING = 1.6  # times that: a pulse is missing
_FALSE = 1.2  # times that, of two together: a false pulse cuts one in two
_TIMES = ("s", "ms", "us", "µs", "ns")


def holds_instants(channel: Channel) -> bool:
    """Whether a channel is a list of instants, being in a unit of time, and not a signal."""
    return channel.unit in _TIMES


def pulse_times(channel: Channel, level: float | None = None, hysteresis: float = HYSTERESIS, least: int = 2) -> np.ndarray:
    """The instants (m,) of the pulses of a channel, in s.

    A channel in a unit of time holds the instants themselves. Any other is a signal, square or not, whose rising crossings of a
    level are pulses; see ``rising_crossings``. Raises ``InputError`` for fewer pulses than the least, and instants that
    do not increase.
    """
    if holds_instants(channel):
        times = channel.in_si(TIME).values
        return Channel(channel.source, channel.name, "s", times, times).time
    times = rising_crossings(channel, level, hysteresis)
    if len(times) < least:
        allowed = f"there must be at least {least} pulses; the signal rises through its middle {len(times)} times"
        raise InputError(channel.where, None, allowed, code="too-few")
    return times


def rising_crossings(channel: Channel, level: float | None = None, hysteresis: float = HYSTERESIS) -> np.ndarray:
    """Where a signal rises through a level (m,), in s, interpolated between samples.

    level: by default half-way between the least and the greatest value. hysteresis: share of that swing by which the signal
    must have been below, and must then be above, so that noise at the level is no pulse. Raises ``InputError`` for a constant.
    """
    x, time = channel.values, channel.time
    low, high = float(x.min()), float(x.max())
    if low == high:
        raise InputError(
            channel.where, None, f"the signal is constant ({low:.6g}): no pulses; is this the right column?", code="constant"
        )
    middle, away = (low + high) / 2 if level is None else level, hysteresis * (high - low)
    state = np.where(x > middle + away, 1, np.where(x < middle - away, -1, 0))
    known = np.flatnonzero(state)
    risen = known[1:][np.diff(state[known]) == 2]
    rising = np.flatnonzero((x[:-1] < middle) & (x[1:] >= middle))
    before = rising[np.searchsorted(rising, risen, side="left") - 1]  # the last one by which it comes up there
    share = (middle - x[before]) / (x[before + 1] - x[before])
    return np.asarray(time[before] + share * (time[before + 1] - time[before]))


def check_even(times: np.ndarray, where: str, remedy: str = "take it out") -> None:
    """Raises ``InputError`` where a pulse is missing, or is one too many, among the instants (m,): by the intervals around.

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
        allowed = (
            f"pulses are missing between {times[i]:.6g} s and {times[i + 1]:.6g} s: the interval is {steps[i] / usual[i]:.3g} "
            "times those around it; cut the record there (a wheel with missing teeth cannot be read)"
        )
        raise InputError(where, None, allowed, code="pulses-missing")
    false = np.flatnonzero(steps[:-1] + steps[1:] < _FALSE * np.minimum(usual[:-1], usual[1:]))
    if len(false):
        i = int(false[0]) + 1
        allowed = f"there is a pulse too many near {times[i]:.6g} s: {remedy}, or cut the record there"
        raise InputError(where, None, allowed, code="pulse-too-many")
