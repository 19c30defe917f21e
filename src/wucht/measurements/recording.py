"""Recordings: measured channels by name, each with its time, as files hold them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import InputError, code_of, nearest
from wucht.schema import LARGEST, Unit, article

TIME_UNIT = Unit("s", "time")
SPEED_UNIT = Unit("rad/s", "angular speed")
ANGLE_UNIT = Unit("rad", "angle")
FULL_SCALE = "of full scale"  # the unit of a sound file's samples, which are between -1 and 1
_OF_FULL_SCALE = "a sound file has no units; state how many {0} full scale is with the keys scale = NUMBER and unit = '{0}'"
_GRAVITY = 9.80665  # m/s^2: accelerometers state g, which elsewhere is a gram


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured signal.

    Parameters
    ----------
    source, name : str
        The file and its channel.
    unit : str
        Of the values, as the file states it; "" if it states none.
    time : numpy.ndarray, (n,)
        Of the samples in s, increasing, in steps that may differ.
    values : numpy.ndarray, (n,)

    Raises
    ------
    InputError
        For less than two samples, times and values of different number, a time that does not increase, and numbers that are not
        finite, or beyond ``LARGEST``.
    """

    source: str
    name: str
    unit: str
    time: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        for key in ("time", "values"):
            object.__setattr__(self, key, _numbers(getattr(self, key), self.location, key))
        times, values = len(self.time), len(self.values)
        if times != values:
            raise InputError(
                self.location,
                None,
                f"there must be one value at each time; there are {values} values and {times} times",
                code="count",
            )
        if times < 2:
            raise InputError(self.location, None, f"there must be at least two samples; there are {times}", code="too-few")
        back = np.flatnonzero(np.diff(self.time) <= 0)
        if len(back):
            i = int(back[0])
            after = f"sample {i + 2} is at {self.time[i + 1]:.9g} s, the one before it at {self.time[i]:.9g} s"
            raise InputError(
                self.location,
                None,
                f"the time must increase: {after}; sort the samples and take out repeated ones",
                code="not-increasing",
            )

    @property
    def location(self) -> str:
        """The location ``file: channel``, for sentences."""
        return f"{self.source}: {self.name}"

    def to_si(self, unit: Unit) -> Channel:
        """Convert the channel to an SI unit; if no unit is stated, its numbers are assumed to be in it.

        Raises ``InputError`` for a channel of another dimension, an unknown unit, and a sound that was given no scale.
        """
        if self.unit == FULL_SCALE:
            raise InputError(self.location, None, _OF_FULL_SCALE.format(unit.si), code="full-scale")
        factor = self._factor(unit) if self.unit else 1.0
        return replace(self, unit=unit.si, values=self.values if factor == 1.0 else factor * self.values)

    def _factor(self, unit: Unit) -> float:
        if (self.unit, unit.si) == ("g", "m/s^2"):
            return _GRAVITY
        try:
            return unit.parse_quantity(f"1 {self.unit}")
        except ValueError as error:
            explanation = (
                f"{error}; if the file is wrong, give the unit of its numbers with the key unit, as in unit = '{unit.si}'"
            )
            raise InputError(self.location, self.unit, explanation, code=code_of(error)) from None

    def with_scale(self, factor: float, unit: str) -> Channel:
        """Multiply the values by a factor, which gives them in that unit: the scale of a sound file, or another sign."""
        return replace(self, unit=unit, values=factor * self.values)

    def correct(self, unit: str | None = None, scale: float | None = None) -> Channel:
        """Replace the unit that the file states, and multiply the values by a factor, as far as they are given.

        Raises ``InputError`` for the unit of a sound without a factor.
        """
        if unit is not None and scale is None and self.unit == FULL_SCALE:
            raise InputError(self.location, None, _OF_FULL_SCALE.format(unit), code="full-scale")
        return self if unit is None and scale is None else self.with_scale(1.0 if scale is None else scale, unit or self.unit)


@dataclass(frozen=True, eq=False)
class Recording:
    """The channels of a file, each loaded on demand; ``Recording.of`` makes one of arrays.

    Parameters
    ----------
    source : str
        The file.
    names : tuple of str
        Of its channels.
    load : callable
        Returns the channel of one of the names.
    """

    source: str
    names: tuple[str, ...]
    load: Callable[[str], Channel]

    @classmethod
    def of(
        cls, source: str, time: np.ndarray, values: Mapping[str, np.ndarray], units: Mapping[str, str] | None = None
    ) -> Recording:
        """Create a recording of arrays (n,) over one time in s; units: of the channels that are not in SI."""
        stated_units = units or {}
        return cls(source, tuple(values), lambda name: Channel(source, name, stated_units.get(name, ""), time, values[name]))

    def channel(self, name: str, unit: Unit | None = None) -> Channel:
        """Return a channel, in SI if a unit is given. Raises ``InputError`` for an unknown name, and as the channel does."""
        if name not in self.names:
            raise InputError(self.source, name, f"there is no such column; {nearest(name, self.names)}")
        channel = self.load(name)
        return channel if unit is None else channel.to_si(unit)


def _numbers(values: object, location: str, key: str) -> np.ndarray:
    array = np.asarray(values)
    if array.ndim != 1 or array.dtype.kind not in "biuf":
        raise InputError(
            location, None, f"the {key} must be a list of real numbers; this is {_describe(array)}", code="no-numbers"
        )
    array = array.astype(float, copy=False)
    bad = np.flatnonzero(~np.isfinite(array))
    if len(bad):
        detail = f"sample {bad[0] + 1} is {array[bad[0]]}" + (f", further ones: {len(bad) - 1}" if len(bad) > 1 else "")
        raise InputError(
            location, None, f"the {key} must be finite numbers: {detail}; take such samples out", code="not-finite"
        )
    beyond = np.flatnonzero(np.abs(array) > LARGEST)
    if len(beyond):
        detail = f"sample {beyond[0] + 1} is {array[beyond[0]]:g}"
        raise InputError(location, None, f"the {key} must be at most {LARGEST:g} in magnitude: {detail}")
    return array


def _describe(array: np.ndarray) -> str:
    if array.ndim != 1:
        return article(f"table of {array.ndim} dimensions")
    return {"c": "complex", "U": "text", "S": "text"}.get(array.dtype.kind, f"of type {array.dtype}")
