"""Deviation of the averaged equations from the full ones: 002, 5.6.1, (5.24)-(5.25)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.run_ups.run_up import Motion
from wucht.dynamics.verdicts.observation import AxisMotion
from wucht.machines.machine import Machine
from wucht.machines.tree import RotatingBody

_FEWEST = 3  # samples on a common range, to compare on


def compared_bodies(machine: Machine) -> list[RotatingBody]:
    """The bodies whose speeds are compared: the main rotor, or if its speed is prescribed, the bodies that are free."""
    free = [b for b in machine.bodies if b.coordinate.prescribed_velocity is None]
    return free if machine.rotor.coordinate.prescribed_velocity is not None and free else [machine.rotor]


@dataclass(frozen=True)
class ComparedMotion:
    """Signals of a run that are compared: samples (N,) of the rotor's angle, its bodies' mean phase, and its axis' distance.

    speed: (k, N) of the ``compared_bodies``. angle and speed are positive in the rotor's sense of rotation. phase: unwrapped,
    None without bodies about the rotor.
    """

    angle: np.ndarray
    speed: np.ndarray
    radius: np.ndarray
    phase: np.ndarray | None = None


@dataclass(frozen=True)
class Deviations:
    """Differences full - slow of speed and radius (N,) at the ``abscissa`` (N,) where both are defined.

    speed: of the compared body with the largest difference.
    """

    abscissa: np.ndarray
    speed: np.ndarray
    radius: np.ndarray

    @property
    def largest(self) -> tuple[float, float]:
        """The largest magnitudes: of speed and of radius."""
        return float(np.abs(self.speed).max()), float(np.abs(self.radius).max())


def compared_motion(motion: Motion) -> ComparedMotion:
    """Return the signals of a motion that are compared."""
    machine, rows = motion.case.machine, motion.rows
    about = [b for b in machine.bodies if b.about == machine.rotor.name]
    angle = rows[machine.rotor.coordinate.position.name]
    speed = np.array([rows[b.coordinate.velocity.name] for b in compared_bodies(machine)])
    sense = float(np.sign(angle[-1] - angle[0])) or 1.0
    mean = np.mean([rows[b.coordinate.position.name] for b in about], axis=0) if about else None
    radius = AxisMotion.of(machine, motion.machine_motion.time, rows).distance
    return ComparedMotion(sense * angle, sense * speed, radius, None if mean is None else sense * (mean - angle))


def deviations_by_angle(full: ComparedMotion, slow: ComparedMotion, until: float = np.inf) -> Deviations | None:
    """Compare at equal angles of the rotor, up to an angle: (5.24), (5.25). None if the ranges do not overlap."""
    begin = max(full.angle[0], slow.angle[0])
    return _compare_motions(full, slow, full.angle - begin, slow.angle - begin, until)


def deviations_by_phase(full: ComparedMotion, slow: ComparedMotion) -> Deviations | None:
    """Compare at equal mean phase of the bodies, 002 figure 5.12, while these lag; None below a common lag of one turn."""
    if full.phase is None or slow.phase is None:
        return None
    sense = np.sign(full.phase[-1] - full.phase[0])
    deviations = _compare_motions(full, slow, sense * full.phase, sense * slow.phase)
    return (
        None
        if deviations is None or np.ptp(deviations.abscissa) < 2 * np.pi
        else replace(deviations, abscissa=sense * deviations.abscissa)
    )


def _compare_motions(
    full: ComparedMotion, slow: ComparedMotion, a: np.ndarray, b: np.ndarray, until: float = np.inf
) -> Deviations | None:
    """Compare at equal abscissae a, b (N,); of one that turns back, only the samples beyond all before them."""
    common, new = _advancing(a) & (a >= b[0]) & (a <= min(b.max(), until)), _advancing(b)
    if np.count_nonzero(common) < _FEWEST:
        return None
    pairs = zip((*full.speed, full.radius), (*slow.speed, slow.radius), strict=True)
    *speeds, radius = (y[common] - np.interp(a[common], b[new], slow_signal[new]) for y, slow_signal in pairs)
    largest = np.abs(speeds).argmax(axis=0)[None]
    return Deviations(a[common], np.take_along_axis(np.array(speeds), largest, axis=0)[0], radius)


def _advancing(values: np.ndarray) -> np.ndarray:
    """Mask of the values that are larger than all before."""
    return np.asarray(np.r_[True, values[1:] > np.maximum.accumulate(values)[:-1]])
