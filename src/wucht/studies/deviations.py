"""How far the slow equations are from the full ones: 002, 5.6.1, (5.24)-(5.25)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.tree import RotatingBody

_FEWEST = 3  # samples on a common range, to compare on


def watched(machine: Machine) -> list[RotatingBody]:
    """Whose speeds are compared: the main rotor's, or where that is prescribed those of the bodies that are free."""
    free = [b for b in machine.bodies if b.coordinate.prescribed is None]
    return free if machine.rotor.coordinate.prescribed is not None and free else [machine.rotor]


@dataclass(frozen=True)
class Course:
    """What is compared of a run: samples (N,) of the rotor's angle, the mean phase of its bodies, and its axis' distance.

    speed: (k, N) of those that are ``watched``. angle and speed are positive in the rotor's own sense. phase: unwrapped, None
    without bodies about the rotor.
    """

    angle: np.ndarray
    speed: np.ndarray
    radius: np.ndarray
    phase: np.ndarray | None = None


@dataclass(frozen=True)
class Deviations:
    """Differences full - slow of speed and radius (N,) at the abscissa ``at`` (N,) where both are defined.

    speed: of that watched body which differs most.
    """

    at: np.ndarray
    speed: np.ndarray
    radius: np.ndarray

    @property
    def largest(self) -> tuple[float, float]:
        """The largest magnitudes: of speed and of radius."""
        return float(np.abs(self.speed).max()), float(np.abs(self.radius).max())


def at_equal_angle(full: Course, slow: Course, until: float = np.inf) -> Deviations | None:
    """At equal angle of the rotor, up to an angle: (5.24), (5.25). None where there is nothing in common."""
    begin = max(full.angle[0], slow.angle[0])
    return _compared((full.angle - begin, full), (slow.angle - begin, slow), until)


def at_equal_phase(full: Course, slow: Course) -> Deviations | None:
    """At equal mean phase of the bodies, 002 figure 5.12, while these slip; None where they do not slip a turn in common."""
    if full.phase is None or slow.phase is None:
        return None
    sense = np.sign(full.phase[-1] - full.phase[0])
    found = _compared((sense * full.phase, full), (sense * slow.phase, slow), np.inf)
    if found is None or np.ptp(found.at) < 2 * np.pi:
        return None
    return Deviations(sense * found.at, found.speed, found.radius)


def _compared(full: tuple[np.ndarray, Course], slow: tuple[np.ndarray, Course], until: float) -> Deviations | None:
    (a, mine), (b, other) = full, slow
    ahead, there = _advancing(a), _advancing(b)  # an abscissa that turns back is compared where it is new
    at = a[ahead]
    common = (at >= b[there][0]) & (at <= min(b[there][-1], until))
    if np.count_nonzero(common) < _FEWEST:
        return None
    at = at[common]
    apart = np.array(
        [m[ahead][common] - np.interp(at, b[there], o[there]) for m, o in zip(mine.speed, other.speed, strict=True)]
    )
    speed = np.take_along_axis(apart, np.abs(apart).argmax(axis=0)[None], 0)[0]
    radius = mine.radius[ahead][common] - np.interp(at, b[there], other.radius[there])
    return Deviations(at, speed, radius)


def _advancing(values: np.ndarray) -> np.ndarray:
    """Where (mask) a value is larger than all before."""
    before = np.maximum.accumulate(values)
    return np.concatenate([[True], values[1:] > before[:-1]])
