"""Locked bodies: how they are released, and when the machine changes for the last time."""

from __future__ import annotations

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.parts.base import Release
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.events import Event
from wucht.system import TIME


def release_events(machine: Machine) -> tuple[Event, ...]:
    """The events at which the locked bodies of a machine are released: their parameter ``locked`` becomes 0."""
    return tuple(_release_event(machine, b, b.release) for b in machine.bodies if b.release is not None)


def last_change(machine: Machine) -> float:
    """When a schedule or a timed release changes the machine for the last time; 0 where none does."""
    timed = [b.name for b in machine.bodies if b.release is not None and b.release.time is not None]
    return max([machine.breakpoints[-1], *(machine.values[f"{name}.release.time"] for name in timed)])


def _release_event(machine: Machine, body: RotatingBody, release: Release) -> Event:
    locked = machine.system.parameter_names.index(body.locked.name)

    def let_go(_time: float, state: np.ndarray, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        parameters[locked] = 0.0
        return state, parameters

    if release.time is not None:
        rising = TIME / sp.Symbol(f"{body.name}.release.time", real=True) - 1
    else:
        rising = (leader_of(machine, body).coordinate.velocity / sp.Symbol(f"{body.name}.release.speed", real=True)) ** 2 - 1
    return Event(f"release of {body.name}", rising, +1, action=let_go)


def leader_of(machine: Machine, body: RotatingBody) -> RotatingBody:
    """The body whose speed releases a locked one: that it turns about, for a rotor the first other rotor."""
    return machine.body(body.about) if body.about else next(r for r in machine.rotors if r.name != body.name)
