"""How far the averaged equations are from the full ones: 002, 5.6.1, (5.24)-(5.25)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.observation import Orbit
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


def course_of(motion: Motion) -> Course:
    """What is compared of a motion."""
    machine, rows = motion.case.machine, motion.rows
    about = [b for b in machine.bodies if b.about == machine.rotor.name]
    angle = rows[machine.rotor.coordinate.position.name]
    speed = np.array([rows[b.coordinate.velocity.name] for b in watched(machine)])
    sense = float(np.sign(angle[-1] - angle[0])) or 1.0
    mean = np.mean([rows[b.coordinate.position.name] for b in about], axis=0) if about else None
    radius = Orbit.of(machine, motion.seen.time, rows).distance
    return Course(sense * angle, sense * speed, radius, None if mean is None else sense * (mean - angle))


def at_equal_angle(full: Course, slow: Course, until: float = np.inf) -> Deviations | None:
    """At equal angle of the rotor, up to an angle: (5.24), (5.25). None where there is nothing in common."""
    begin = max(full.angle[0], slow.angle[0])
    return _compared(full, slow, full.angle - begin, slow.angle - begin, until)


def at_equal_phase(full: Course, slow: Course) -> Deviations | None:
    """At equal mean phase of the bodies, 002 figure 5.12, while these lag; None where they do not lag a turn in common."""
    if full.phase is None or slow.phase is None:
        return None
    sense = np.sign(full.phase[-1] - full.phase[0])
    apart = _compared(full, slow, sense * full.phase, sense * slow.phase)
    return None if apart is None or np.ptp(apart.at) < 2 * np.pi else replace(apart, at=sense * apart.at)


def _compared(full: Course, slow: Course, a: np.ndarray, b: np.ndarray, until: float = np.inf) -> Deviations | None:
    """At equal abscissae a, b (N,); one that turns back is compared where it is new."""
    common, new = _advancing(a) & (a >= b[0]) & (a <= min(b.max(), until)), _advancing(b)
    if np.count_nonzero(common) < _FEWEST:
        return None
    pairs = zip((*full.speed, full.radius), (*slow.speed, slow.radius), strict=True)
    *speeds, radius = (y[common] - np.interp(a[common], b[new], other[new]) for y, other in pairs)
    largest = np.abs(speeds).argmax(axis=0)[None]
    return Deviations(a[common], np.take_along_axis(np.array(speeds), largest, axis=0)[0], radius)


def _advancing(values: np.ndarray) -> np.ndarray:
    """Where (mask) a value is larger than all before."""
    return np.asarray(np.r_[True, values[1:] > np.maximum.accumulate(values)[:-1]])
