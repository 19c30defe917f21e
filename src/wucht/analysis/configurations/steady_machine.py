"""The machine as it turns in steady operation, and the speeds at which its drives can hold it there."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies, net_torque

MOST_BODIES = 11  # of a machine whose states are searched
LOWEST = 1e-3  # of the highest speed: where a search begins
UNKNOWN = 100.0  # rad/s, where the machine has neither natural frequencies nor speeds of its own
_ABOVE = 1 + 1e-4  # of the highest speed without vibration: where it ends
_RUNAWAY = 3  # times the highest natural frequency: how far is searched where the drive has no speed of its own


def turning(machine: Machine, speed: float | None) -> Machine:
    """The machine with its schedules done, all bodies released, and the main rotor at a given speed (signed)."""
    steady = machine.at(machine.breakpoints[-1]).changed(schedules=())
    bodies = [replace(b, release=None) for b in steady.bodies]
    if speed is not None:
        main = next(i for i, b in enumerate(bodies) if b.name == machine.rotor.name)
        bodies[main] = replace(bodies[main], coordinate=replace(bodies[main].coordinate, prescribed=sp.Float(speed)))
    return steady.changed(bodies=tuple(bodies))


def driven_speeds(machine: Machine) -> tuple[tuple[float, float], bool]:
    """Up to the highest speed without vibration, and whether a drive runs away without load: then there is no such speed."""
    free = {r: free_speed(machine, r) for r in machine.rotors}
    top = max((abs(w) for w in free.values() if w is not None), default=0.0)
    runaway = any(w is None and net_torque(machine, r)(0.0) for r, w in free.items())
    if runaway:
        top = max(top, _RUNAWAY * max((f for f in natural_frequencies(machine).values() if f > 0), default=UNKNOWN))
    return (LOWEST * top, top if runaway else _ABOVE * top), runaway
