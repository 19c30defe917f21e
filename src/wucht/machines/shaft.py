"""What drives a rotor and what brakes it, over its speed: the characteristic and the load line of 002 figure 3.2b."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine, Turning
from wucht.machines.vibration import group
from wucht.numerics.program import python_function

Curve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
_SPEED = sp.Symbol("speed", real=True)


@dataclass(frozen=True)
class Shaft:
    """Torques on a rotor whose bodies turn with it, the carrier at rest: functions of the speed (N,), value and slope.

    drive: of all drives, in the direction of positive speeds. losses: of loads and bearings, against it. Speeds are signed.
    """

    drive: Curve
    losses: Curve

    @classmethod
    def of(cls, machine: Machine, rotor: Turning) -> Shaft:
        """The shaft of a rotor, whatever parts state its torques."""
        drive, losses = [], []
        for v in (b.coordinate.velocity for b in group(machine, rotor)):
            for e in machine.energies:
                losses.append(sp.diff(e.dissipation, v))
                for a in e.applied:
                    torque = a.force * sp.diff(a.rate, v)
                    if a.booked == "supplied":
                        drive.append(torque)
                    else:
                        losses.append(-torque)
        at_rest = {s: sp.S.Zero for c in machine.carrier for s in (c.position, c.velocity)}
        at_rest |= {s: sp.S.Zero for x in machine.sliders for s in (x.coordinate.position, x.coordinate.velocity)}
        at_rest |= {b.coordinate.velocity: _SPEED for b in machine.bodies}
        return cls(*(_curve(sp.Add(*f).xreplace(at_rest).xreplace(machine.numbers)) for f in (drive, losses)))


def _curve(torque: sp.Expr) -> Curve:
    function = python_function((_SPEED,), (), (torque, sp.diff(torque, _SPEED)))

    def values(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = np.asarray(speeds, float)
        value, slope = (np.broadcast_to(np.asarray(v, float), at.shape) for v in function(at))
        return value, slope

    return values
