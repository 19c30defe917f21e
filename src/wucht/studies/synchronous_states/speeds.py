"""Which speeds a question about constant phases may name, and which are searched."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.errors import InputError
from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import Machine
from wucht.machines.vibration import free_speed, net_torque, sense_of

_LOWEST, _ABOVE = 1e-3, 1 + 1e-4  # of the highest speed without vibration: where the search for speeds begins and ends
_SLOWER, _FASTER = 1e-3, 1e3  # of the lowest and the highest speed of the machine: beyond, nothing is left to be computed
_RUNAWAY = 3  # times the highest natural frequency: how far is searched where the drive has no speed of its own
_UNKNOWN = 100.0  # rad/s, where the machine has neither natural frequencies nor speeds of its own
_SAMPLES = 1001


@dataclass(frozen=True)
class SpeedRange:
    """The speeds that are searched, in the main rotor's own sense. chosen: the upper end is the program's choice."""

    low: float
    high: float
    chosen: bool = False


def speed_limits(machine: Machine) -> tuple[float, float]:
    """The lowest and the highest speed that may be asked for, by the natural frequencies and the drives of the machine."""
    own = [*natural_frequencies(machine).values(), *(abs(free_speed(machine, r) or 0.0) for r in machine.rotors)]
    own = [w for w in own if w > 0 and math.isfinite(w)] or [_UNKNOWN]
    return _SLOWER * min(own), _FASTER * max(own)


def check_speed(machine: Machine, speed: float) -> None:
    """Raises ``InputError`` for a given speed at which nothing can be computed."""
    low, high = speed_limits(machine)
    if not low <= abs(speed) <= high:
        raise InputError("study.speed", speed, f"allowed are speeds {_between(machine, low, high)}")


def searched(machine: Machine, given: tuple[float, float] | None) -> SpeedRange:
    """The range of speeds to search. Raises ``InputError`` where nothing drives the machine, or the given one does not fit."""
    found = _of_drives(machine) if given is None else _given(machine, given)
    speeds = np.linspace(found.low, found.high, _SAMPLES)
    if not any(torque(sense * float(w)) for torque, sense in _net_torques(machine) for w in speeds):
        where = "" if given is None else " at these speeds"
        raise InputError("study.speed", None, f"nothing drives the machine{where}: needed is the speed of the main rotor")
    return found


def _given(machine: Machine, given: tuple[float, float]) -> SpeedRange:
    sense = sense_of(machine, machine.rotor)
    low, high = sorted(sense * w for w in given)
    if low < 0:
        raise InputError("study.range", list(given), "allowed are speeds in the sense in which the drive turns")
    least, most = speed_limits(machine)
    if not least < high <= most:
        raise InputError("study.range", list(given), f"allowed are speeds {_between(machine, least, most)}")
    return SpeedRange(max(low, min(least, _LOWEST * high)), high)


def _of_drives(machine: Machine) -> SpeedRange:
    """Up to the highest speed without vibration; a drive that runs away without load has none."""
    free = [free_speed(machine, r) for r in machine.rotors]
    top = max((abs(w) for w in free if w is not None), default=0.0)
    runaway = any(w is None and torque(0.0) for w, (torque, _) in zip(free, _net_torques(machine), strict=True))
    if runaway:
        top = max(top, _RUNAWAY * max((f for f in natural_frequencies(machine).values() if f > 0), default=_UNKNOWN))
    if not top:
        raise InputError("study.speed", None, "nothing drives the machine: needed is the speed of the main rotor")
    return SpeedRange(_LOWEST * top, top if runaway else _ABOVE * top, runaway)


def _net_torques(machine: Machine) -> list[tuple[Callable[[float], float], float]]:
    """Of each rotor what drives it less what brakes it, and the sense in which it turns."""
    return [(net_torque(machine, r), sense_of(machine, r)) for r in machine.rotors]


def _between(machine: Machine, low: float, high: float) -> str:
    return (
        f"from {low:.3g} to {high:.3g} {machine.units.speed}".rstrip()
        + ", a thousandth of the lowest to a thousand times the highest natural frequency or speed of a drive"
    )
