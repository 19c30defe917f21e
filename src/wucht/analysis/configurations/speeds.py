"""The speeds at which a machine's bodies may turn in step: those that its drives and its vibration leave."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies, net_torque, sense_of

LOWEST = 1e-3  # of the highest speed: where a search begins
_ABOVE = 1 + 1e-4  # of the highest speed without vibration: where it ends
_SLOWER, _FASTER = 1e-3, 1e3  # of the lowest and the highest speed of the machine: beyond, nothing is left to be computed
_RUNAWAY = 3  # times the highest natural frequency: how far is searched where the drive has no speed of its own
_UNKNOWN = 100.0  # rad/s, where the machine has neither natural frequencies nor speeds of its own
_SAMPLES = 1001


@dataclass(frozen=True)
class SpeedRange:
    """Speeds to be searched, in the main rotor's own sense. chosen: the upper end is the program's choice."""

    low: float
    high: float
    chosen: bool = False


def speed_limits(machine: Machine) -> tuple[float, float]:
    """The lowest and the highest speed at which anything can be computed, by the machine's natural frequencies and drives."""
    own = [*natural_frequencies(machine).values(), *(abs(free_speed(machine, r) or 0.0) for r in machine.rotors)]
    own = [w for w in own if w > 0 and math.isfinite(w)] or [_UNKNOWN]
    return _SLOWER * min(own), _FASTER * max(own)


def speeds_of_drives(machine: Machine) -> SpeedRange | None:
    """Up to the highest speed without vibration; a drive that runs away without load has none. None: nothing drives."""
    free = [free_speed(machine, r) for r in machine.rotors]
    top = max((abs(w) for w in free if w is not None), default=0.0)
    runaway = any(w is None and torque(0.0) for w, (torque, _) in zip(free, _net_torques(machine), strict=True))
    if runaway:
        top = max(top, _RUNAWAY * max((f for f in natural_frequencies(machine).values() if f > 0), default=_UNKNOWN))
    return SpeedRange(LOWEST * top, top if runaway else _ABOVE * top, runaway) if top else None


def driven(machine: Machine, speeds: SpeedRange) -> bool:
    """Whether there is any torque at these speeds."""
    at = np.linspace(speeds.low, speeds.high, _SAMPLES)
    return any(torque(sense * float(w)) for torque, sense in _net_torques(machine) for w in at)


def _net_torques(machine: Machine) -> list[tuple[Callable[[float], float], float]]:
    """Of each rotor what drives it less what brakes it, and the sense in which it turns."""
    return [(net_torque(machine, r), sense_of(machine, r)) for r in machine.rotors]
