"""What drives a rotor and what brakes it, over its speed: the characteristic and the load line of 002 figure 3.2b."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine, Turning
from wucht.machines.vibration import SPEED, shaft_torques
from wucht.numerics.flow.program import python_function

Curve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


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
        drive, losses = shaft_torques(machine, rotor)
        return cls(_curve(drive), _curve(losses))


def _curve(torque: sp.Expr) -> Curve:
    function = python_function((SPEED,), (), (torque, sp.diff(torque, SPEED)))

    def values(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = np.asarray(speeds, float)
        value, slope = (np.broadcast_to(np.asarray(v, float), at.shape) for v in function(at))
        return value, slope

    return values
