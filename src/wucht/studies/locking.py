"""Rotors entrained by a vibration or by each other: mean speeds and phases over whole periods."""

from __future__ import annotations

import math
from collections.abc import Mapping
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

    speeds: of all rotors over whole periods, with their signs. phases: of the other rotors to the main one, or of the main
    rotor to the vibration (key ``vibration``), as sigma phi, means over the last whole periods, wrapped to [0, 2 pi). window:
    begin and end time.
    """

    evidence: Locking
    speeds: dict[str, float]
    phases: dict[str, float]
    window: tuple[float, float]


def is_locking(machine: Machine) -> bool:
    """Whether a machine is judged by locking: its carrier is shaken harmonically, or several of its rotors are free to turn."""
    free = sum(r.coordinate.prescribed is None for r in machine.rotors)
    return free > 1 or (free == 1 and machine.shaken is not None and machine.shaking_frequency is not None)


def locked(machine: Machine, trajectory: Trajectory) -> Locked | None:
    """Mean speeds and phases of a run; None where the main rotor does not make a single period in its last half."""
    motion = {r.name: motion_of(machine, trajectory, r) for r in machine.rotors}
    main, time, frequency = machine.rotor.name, trajectory.time, machine.shaking_frequency
    end, rate = float(time[-1]), frequency
    if rate is None:
        half, angle = int(np.searchsorted(time, (1 - _SHARE) * end)), motion[main][0]
        rate = abs(float(angle[-1] - angle[half])) / max(end - float(time[half]), 1e-300)
    periods = math.floor(_SHARE * (end - float(time[0])) * rate / (2 * math.pi) * (1 + 1e-9))
    if periods < 1:
        return None
    begin = end - periods * 2 * math.pi / rate
    at = begin + (end - begin) * np.arange(periods * _PER_PERIOD + 1) / (periods * _PER_PERIOD)
    angles = {name: hermite(at, time, *of_body) for name, of_body in motion.items()}
    speeds = {name: float((a[-1] - a[0]) / (end - begin)) for name, a in angles.items()}
    phases = rotor_phases(machine, at, angles)
    means = {name: p[:-1].reshape(periods, _PER_PERIOD).mean(axis=1) for name, p in phases.items()}
    creep = max((float(abs(m[-1] - m[periods // 2])) for m in means.values()), default=0.0)
    last = {name: float(wrapped(m[-max(1, periods // 10) :].mean())) for name, m in means.items()}
    evidence = Locking(tuple(map(abs, speeds.values())), frequency, periods, creep)
    return Locked(evidence, speeds, last, (begin, end))


def rotor_phases(machine: Machine, time: np.ndarray, angles: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """As sigma phi (N,), of the main rotor to the vibration (``vibration``), or of the others to it. angles: of all of them."""
    turned = {name: math.copysign(1.0, angle[-1] - angle[0]) * angle for name, angle in angles.items()}
    origin, frequency = turned.pop(machine.rotor.name), machine.shaking_frequency
    return {n: a - origin for n, a in turned.items()} if frequency is None else {"vibration": origin - frequency * time}


def motion_of(machine: Machine, trajectory: Trajectory, body: RotatingBody) -> tuple[np.ndarray, np.ndarray]:
    """Angle and speed of a body over a run, (N,) each."""
    angle = trajectory.states[machine.row(body.coordinate.position)]
    if body.coordinate.prescribed is not None:
        return angle, machine.prescribed_speed(body.coordinate, trajectory.time)
    return angle, trajectory.states[machine.row(body.coordinate.velocity)]
