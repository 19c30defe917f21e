"""Rotors that a vibration or another rotor takes along: mean speeds and phases over whole periods."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.turns import hermite
from wucht.results.conventions import wrapped
from wucht.results.outcomes import Locking

_SHARE = 0.5  # of the run: the last part, over which is averaged
_PER_PERIOD = 64


@dataclass(frozen=True)
class Locked:
    """The evidence, and what goes into the summary.

    mean_speed: of the main rotor over whole periods, with its sign. speeds: of all rotors. phases: of the other rotors to
    the main one, or of the main rotor to the vibration (key ``vibration``), as sigma phi, means over the last whole periods,
    wrapped to [0, 2 pi). window: begin and end time.
    """

    evidence: Locking
    mean_speed: float
    speeds: dict[str, float]
    phases: dict[str, float]
    window: tuple[float, float]


def is_locking(machine: Machine) -> bool:
    """Whether a machine is judged by locking: its carrier is shaken harmonically, or several of its rotors are free to turn."""
    free = [r for r in machine.rotors if r.coordinate.prescribed is None]
    return (machine.shaken is not None and frequency_of(machine) is not None and bool(free)) or len(free) > 1


def frequency_of(machine: Machine) -> float | None:
    """The angular frequency of a prescribed harmonic vibration."""
    return machine.shaking_frequency


def locked(machine: Machine, trajectory: Trajectory) -> Locked | None:
    """Mean speeds and phases of a run; None where the main rotor does not make a single period in its last half."""
    rotors = list(machine.rotors)
    motion = {r.name: motion_of(machine, trajectory, r) for r in rotors}
    time, given = trajectory.time, frequency_of(machine)
    main, _ = motion[rotors[0].name]
    end = float(time[-1])
    if given is None:
        half = int(np.searchsorted(time, (1 - _SHARE) * end))
        given_rate = abs(float(main[-1] - main[half])) / max(end - float(time[half]), 1e-300)
    else:
        given_rate = given
    periods = math.floor(_SHARE * (end - float(time[0])) * given_rate / (2 * math.pi) * (1 + 1e-9))
    if periods < 1:
        return None
    begin = end - periods * 2 * math.pi / given_rate
    at = begin + (end - begin) * np.arange(periods * _PER_PERIOD + 1) / (periods * _PER_PERIOD)
    angles = {name: hermite(at, time, a, w) for name, (a, w) in motion.items()}
    speeds = {name: float((a[-1] - a[0]) / (end - begin)) for name, a in angles.items()}
    turned = {name: (math.copysign(1.0, speeds[name]) * a) for name, a in angles.items()}
    first = turned[rotors[0].name]
    slow = (
        {"vibration": first - given * at} if given is not None
        else {r.name: turned[r.name] - first for r in rotors[1:]}
    )  # fmt: skip
    averaged = {name: s[:-1].reshape(periods, _PER_PERIOD).mean(axis=1) for name, s in slow.items()}
    drift = max((float(abs(s[-1] - s[periods // 2])) for s in averaged.values()), default=0.0)
    evidence = Locking(tuple(abs(speeds[r.name]) for r in rotors), given, periods, drift)
    phases = {name: float(wrapped(s[-max(1, periods // 10) :].mean())) for name, s in averaged.items()}
    return Locked(evidence, speeds[rotors[0].name], speeds, phases, (begin, end))


def motion_of(machine: Machine, trajectory: Trajectory, body: RotatingBody) -> tuple[np.ndarray, np.ndarray]:
    """Angle and speed of a body over a run, (N,) each."""
    angle = trajectory.states[machine.row(body.coordinate.position)]
    if body.coordinate.prescribed is not None:
        return angle, machine.prescribed_speed(body.coordinate, trajectory.time)
    return angle, trajectory.states[machine.row(body.coordinate.velocity)]
