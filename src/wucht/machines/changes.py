"""Changes of a machine while it runs: locked bodies that are released, and schedules."""

from __future__ import annotations

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.parts.base import Release
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.events import Event
from wucht.system import TIME


def release_events(machine: Machine) -> tuple[Event, ...]:
    """Return the events at which the locked bodies of a machine are released: their parameter ``locked`` becomes 0."""
    return tuple(_release_event(machine, b, b.release) for b in machine.bodies if b.release is not None)


def last_change(machine: Machine) -> float:
    """Return the time of the last change of the machine by a schedule or a timed release; 0 where there is none."""
    timed_names = [b.name for b in machine.bodies if b.release is not None and b.release.time is not None]
    return max([machine.breakpoints[-1], *(machine.values[f"{name}.release.time"] for name in timed_names)])


def _release_event(machine: Machine, body: RotatingBody, release: Release) -> Event:
    index = machine.system.parameter_names.index(body.lock_symbol.name)

    def release_body(_time: float, state: np.ndarray, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        parameters[index] = 0.0
        return state, parameters

    if release.time is not None:
        rising = TIME / sp.Symbol(f"{body.name}.release.time", real=True) - 1
    else:
        rising = (leader_of(machine, body).coordinate.velocity / sp.Symbol(f"{body.name}.release.speed", real=True)) ** 2 - 1
    return Event(f"release of {body.name}", rising, +1, action=release_body)


def leader_of(machine: Machine, body: RotatingBody) -> RotatingBody:
    """Return the body whose speed releases a locked one: that it turns about, for a rotor the first other rotor."""
    return machine.body(body.about) if body.about else next(r for r in machine.rotors if r.name != body.name)
