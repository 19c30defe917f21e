"""Where the torques of drive and vibration let a rotor go from where it stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wucht.analysis.time_constants import runaway_limit
from wucht.analysis.working_points import torque_surplus
from wucht.dynamics.verdicts.evidence import UNREST, Standing
from wucht.dynamics.verdicts.outcomes import Evidence
from wucht.machines.machine import Machine
from wucht.numerics.observers.projection import Course

_SHORT = 0.98  # of the free speed: a rotor that is held before has not reached it


def as_it_rises(machine: Machine, stands: Standing) -> Evidence[float]:
    """The evidence of a rotor whose speed still rises, beyond all resonances, with bodies that do not lag.

    It is settled as soon as the vibration is seen to hold it short of its free speed; or nothing can hold it.
    """
    e, (mean, *_) = stands.evidence, stands.projections
    rises = mean.course is not Course.STATIONARY and mean.high > mean.last
    limit = runaway_limit(machine) if e.free_speed is None else _SHORT * e.free_speed
    moving = stands.growing or stands.unrest > UNREST
    if e.settled or moving or not (rises and e.beyond) or not e.asynchronous.no or limit is None:
        return e
    speeds = np.linspace(stands.speed, limit, 800)
    held = not (torque_surplus(machine, stands.vibration, stands.final_phases, speeds) > 0).all()
    return replace(e, settled=held, unheld=not held and e.free_speed is None)


def faster_branch(machine: Machine, stands: Standing) -> bool:
    """Whether the drive's torque exceeds the vibration torque again somewhere between the speed reached and the free speed."""
    e = stands.evidence
    if e.free_speed is None or e.resonance is None or machine.rotor.coordinate.prescribed is not None:
        return False
    speeds = np.linspace(stands.speed, e.free_speed, 402)[1:-1]
    surplus = torque_surplus(machine, stands.vibration, stands.final_phases, speeds)
    # Between two branches the vibration takes more than the drive gives: without such a gap there is only one.
    small = 1e-3 * float(np.abs(surplus).max())
    short = np.flatnonzero(surplus < -small)
    return bool(len(short) and (surplus[short[0] :] > small).any())
