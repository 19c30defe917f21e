"""Rotors entrained by a vibration or by each other: mean speeds and phases over whole periods."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.numerics.observers.turns import PER_TURN
from wucht.results.conventions import wrapped
from wucht.results.outcomes import Locking
from wucht.studies.motion.observation import Observation

_SHARE = 0.5  # of the run: the last part, over which is averaged


@dataclass(frozen=True)
class Locked:
    """The evidence, and what goes into the summary.

    speeds: of all rotors over whole periods, with their signs. phases: of the other rotors to the main one, or of the main
    rotor to the vibration (key ``vibration``), as sigma phi, means over the last whole periods, wrapped to [0, 2 pi). window:
    begin and end time. smooth_speeds: the same as ``speeds``, where a modulation is cut at the ends. change: the largest between
    the halves of the window.
    """

    evidence: Locking
    speeds: dict[str, float]
    phases: dict[str, float]
    window: tuple[float, float]
    smooth_speeds: dict[str, float]
    change: float


def is_locking(machine: Machine) -> bool:
    """Whether a machine is judged by locking: its carrier is shaken harmonically, or several of its rotors are free to turn."""
    free = sum(r.coordinate.prescribed is None for r in machine.rotors)
    return free > 1 or (free == 1 and machine.shaken is not None and machine.shaking_frequency is not None)


def locked(machine: Machine, seen: Observation) -> Locked | None:
    """Mean speeds and phases of a run; None where the main rotor does not make a single period in its last half."""
    main, frequency, names = machine.rotor.name, machine.shaking_frequency, [b.name for b in machine.bodies]
    by_vibration = seen.vibration is not None
    record = seen.rotors[main] if seen.vibration is None else seen.vibration
    leading = [*(["vibration"] if by_vibration else [main]), *(n for n in names if by_vibration or n != main)]
    half = record.whole_turns(_SHARE)
    periods = round((len(half) - 1) * half.size / PER_TURN)
    if periods < 1:
        return None

    def of_rotors(values: np.ndarray) -> dict[str, Any]:
        """Of values for the leading motion and for those beside it, those of the rotors."""
        return {r.name: values[leading.index(r.name)] for r in machine.rotors}

    speeds, smooth = (of_rotors((half.sense * x).tolist()) for x in (half.mean_speeds, half.smooth_mean_speeds))
    earlier, later = (of_rotors(part.smooth_mean_speeds) for part in (half.part(slice(len(half) // 2)), half.last(0.5)))
    phases = rotor_phases(machine, half.time, of_rotors(np.array([half.angle, *half.angles])))
    creep = max((float(abs(p[-1] - p[len(half) // 2])) for p in phases.values()), default=0.0)
    return Locked(
        evidence=Locking(tuple(map(abs, speeds.values())), frequency, periods, creep),
        speeds=speeds,
        phases={name: float(wrapped(p[-max(1, len(half) // 10) :].mean())) for name, p in phases.items()},
        window=(float(half.time[0]), float(half.time[-1])),
        smooth_speeds=smooth,
        change=max(float(abs(later[name] - earlier[name])) for name in speeds),
    )


def rotor_phases(machine: Machine, time: np.ndarray, angles: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """As sigma phi (N,), of the main rotor to the vibration (``vibration``), or of the others to it. angles: of all of them."""
    turned = {name: math.copysign(1.0, angle[-1] - angle[0]) * angle for name, angle in angles.items()}
    origin, frequency = turned.pop(machine.rotor.name), machine.shaking_frequency
    return {n: a - origin for n, a in turned.items()} if frequency is None else {"vibration": origin - frequency * time}
