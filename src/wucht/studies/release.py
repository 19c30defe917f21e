"""Locked bodies: how they are released, and the machine placed in its start state."""

from __future__ import annotations

import numpy as np
import sympy as sp

from wucht.machines.contact import arranged
from wucht.machines.machine import Machine, Turning
from wucht.numerics.flow.events import Event
from wucht.studies.start import angles_in, fastest_in
from wucht.system import TIME


def placed(machine: Machine, state: np.ndarray) -> Machine:
    """The machine as it is in a start state (n,): the bodies of its tracks in order, those unlocked that are released already.

    Raises ``InputError`` where bodies of a track overlap.
    """
    return released_at_start(arranged(machine, angles_in(machine, state), fastest_in(machine, state)), state)


def release_event(machine: Machine, body: Turning) -> Event:
    """The event at which a locked body is released: its parameter ``locked`` becomes 0."""
    release = body.release
    assert release is not None
    place = machine.system.parameter_names.index(body.locked.name)

    def let_go(_time: float, state: np.ndarray, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        parameters[place] = 0.0
        return state, parameters

    if release.time is not None:
        rising = TIME / sp.Symbol(f"{body.name}.release.time", real=True) - 1
    else:
        rising = (leader_of(machine, body).coordinate.velocity / sp.Symbol(f"{body.name}.release.speed", real=True)) ** 2 - 1
    return Event(f"release of {body.name}", rising, +1, action=let_go)


def leader_of(machine: Machine, body: Turning) -> Turning:
    """The body whose speed releases a locked one: that it turns about, for a rotor the first other rotor."""
    return next(b for b in machine.bodies if (b.name == body.about if body.about else b.name != body.name and not b.about))


def released_at_start(machine: Machine, initial: np.ndarray) -> Machine:
    """The machine with those bodies unlocked whose speed of release is reached at t = 0: the event would never come."""
    names, free = machine.state_names, {}
    for body in machine.bodies:
        if body.release is None or body.release.speed is None:
            continue
        leader = leader_of(machine, body).coordinate
        prescribed = leader.prescribed is not None
        speed = machine.prescribed_speed(leader, 0.0)[0] if prescribed else initial[names.index(leader.velocity.name)]
        if abs(speed) >= body.release.speed:
            free[body.locked.name] = 0.0
    return machine.with_values(free) if free else machine
