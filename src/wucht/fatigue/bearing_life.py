"""The life of a rolling bearing after ISO 281, from its load over its revolutions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

_REVOLUTIONS = 1e6  # revolutions that a bearing endures under its rating
HEAVY = 0.5  # of the rating: beyond this load ISO 281 refers to the manufacturer


@dataclass(frozen=True)
class BearingRating:
    """Rating of a rolling bearing: nine of ten endure L_10 = (C/P)^p 10^6 revolutions (ISO 281:2007).

    Parameters
    ----------
    C : float
        The basic dynamic load rating.
    p : float
        The exponent: 3 of ball bearings, 10/3 of roller bearings.

    Examples
    --------
    >>> from wucht.fatigue import BearingRating
    >>> ball_bearing = BearingRating(C=45e3, p=3)
    >>> ball_bearing.revolutions(4.5e3)
    1000000000.0
    >>> round(ball_bearing.hours(4.5e3, speed=1500))  # in rpm
    11111
    """

    C: float
    p: float = 3.0

    def revolutions(self, load: float) -> float:
        """Return the revolutions that nine of ten bearings endure under a load; infinite without one."""
        return _REVOLUTIONS * (self.C / load) ** self.p if load else math.inf

    def hours(self, load: float, speed: float) -> float:
        """Return the same in hours at a speed in revolutions a minute; infinite at rest."""
        return self.revolutions(load) / (60 * abs(speed)) if speed else math.inf


@dataclass(frozen=True)
class BearingDuty:
    """The load of a bearing over its revolutions, as sums over the motion so far.

    Parameters
    ----------
    exponent : float
        p of the life.
    begin, end : float
        Times between which the load counts.
    time : float
        The counted time in s.
    angle : float
        The angle in rad that the bearing has turned through, forwards or backwards.
    power : float
        Integral of |F|^p over that angle.
    place, least, greatest : float
        Angle in rad at the end, from where it began, and the limits of it.

    Examples
    --------
    A load of 1 kN for half of the revolutions, then of 2 kN:

    >>> import numpy as np
    >>> from wucht.fatigue import BearingDuty
    >>> duty = BearingDuty(exponent=3)
    >>> for force in (1e3, 2e3):
    ...     duty = duty.update(np.array([0.0, 10.0]), np.array([force, force]), np.array([100.0, 100.0]))
    >>> round(duty.equivalent_load)
    1651
    """

    exponent: float
    begin: float = -math.inf
    end: float = math.inf
    time: float = 0.0
    angle: float = 0.0
    power: float = 0.0
    place: float = field(default=0.0, compare=False)  # it does not matter which way it turns
    least: float = field(default=0.0, compare=False)
    greatest: float = field(default=0.0, compare=False)

    def update(self, time: np.ndarray, force: np.ndarray, speed: np.ndarray) -> BearingDuty:
        """Return the duty after a further part of the motion: time, size of the force, speed in rad/s, all (N,)."""
        edges = max(self.begin, float(time[0])), min(self.end, float(time[-1]))
        if not edges[0] < edges[1]:
            return self
        rate = np.abs(speed)
        integral, course = _integrals(time, *edges), self.place + _angle_over(time, speed, *edges)
        return replace(
            self,
            place=float(course[-1]),
            least=min(self.least, float(course.min())),
            greatest=max(self.greatest, float(course.max())),
            time=self.time + edges[1] - edges[0],
            angle=self.angle + integral(rate),
            power=self.power + integral(np.abs(force) ** self.exponent * rate),
        )

    @property
    def equivalent_load(self) -> float | None:
        """P, under which as many revolutions are endured as under the load itself; None of a bearing that makes no turn.

        P^p is the mean of |F|^p over the revolutions: damages of single revolutions add up.
        """
        return (self.power / self.angle) ** (1 / self.exponent) if self.turns else None

    @property
    def turns(self) -> bool:
        """True if the bearing makes a full turn: what merely swings wears in another way."""
        return self.greatest - self.least >= 2 * math.pi

    @property
    def speed(self) -> float:
        """The mean speed in revolutions a minute."""
        return 60 * self.angle / (2 * math.pi * self.time) if self.time > 0 else 0.0

    def life(self, rating: BearingRating) -> float | None:
        """Return the life in hours of such a motion; None of a bearing that does not turn, or without load."""
        load = self.equivalent_load
        return rating.hours(load, self.speed) if load else None


def mean_over_time(time: np.ndarray, values: np.ndarray, begin: float, end: float) -> float:
    """Return the mean of a sampled signal, time and values (N,), between two times within it."""
    begin, end = max(begin, float(time[0])), min(end, float(time[-1]))
    return _integrals(time, begin, end)(values) / (end - begin) if begin < end else float(values[-1])


def _angle_over(time: np.ndarray, speed: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Return the angle (K,) turned through since a time, at the samples until another one; speed (N,) at times (N,)."""
    places = np.concatenate([[begin], time[(time > begin) & (time < end)], [end]])
    speeds = np.interp(places, time, speed)
    return np.append(0.0, np.cumsum(np.diff(places) * (speeds[1:] + speeds[:-1]) / 2))


def _integrals(time: np.ndarray, begin: float, end: float) -> Callable[[np.ndarray], float]:
    """Return the integral over part of the samples' time (N,), as a function of the values (N,): trapezia, cut at the ends."""
    inner = time[(time > begin) & (time < end)]
    places = np.concatenate([[begin], inner, [end]])
    steps = np.diff(places)

    def integral(values: np.ndarray) -> float:
        heights = np.interp(places, time, values)
        return float(steps @ (heights[1:] + heights[:-1]) / 2)

    return integral
