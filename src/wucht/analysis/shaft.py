"""What drives a rotor and what brakes it, over its speed: the characteristic and the load line of 002 figure 3.2b."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import sympy as sp

from wucht.analysis.vibration import Vibration, unbalances
from wucht.machines.machine import Machine
from wucht.machines.operation import damped, net_torque, operating_speed, slopes
from wucht.machines.parts.coulomb_load import CoulombLoad
from wucht.machines.parts.table_load import TableLoad
from wucht.machines.structure import SPEED

_NO_DECAY = 1e-6  # of its frequency: a rate below it is rounding
Curve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def curves(machine: Machine, torques: Sequence[sp.Expr]) -> Curve:
    """Torques, expressions in ``SPEED`` and the parameters, as functions of the speeds (N,): values and slopes, (n, N) each."""
    function = machine.function(*torques, *slopes(tuple(torques)), of=SPEED)

    def values(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w = np.atleast_1d(np.asarray(speeds, float))
        every = np.empty((2 * len(torques), *w.shape))
        for row, value in zip(every, function(w), strict=True):
            row[:] = value  # which may be one number for all speeds
        return every[: len(torques)], every[len(torques) :]

    return values


def dry_friction(machine: Machine) -> tuple[float, float]:
    """What all loads of dry friction take at any speed, in N m, and the highest speed in rad/s of their smooth transitions."""
    measured = [(load.friction(), load.transition_speed) for load in machine.parts if isinstance(load, TableLoad)]
    dry = [(load.level, load.transition_speed) for load in machine.parts if isinstance(load, CoulombLoad)]
    there = [(torque, speed) for torque, speed in (*dry, *measured) if torque > 0]
    return sum(torque for torque, _ in there), max((speed for _, speed in there), default=0.0)


def energy_scale(machine: Machine) -> float:
    """The kinetic energy of the bodies at operating speed, the size of the works in a run."""
    kinetic = machine.function(machine.structure.kinetic_in_operation, of=SPEED, modules="math")
    energy = float(kinetic(operating_speed(machine))[0])
    return energy if energy > 0 and math.isfinite(energy) else 1.0


def only_braked(machine: Machine, fastest: float) -> bool:
    """Whether swings of all rotors with speeds up to that can only lose energy: nothing but constant torques drives them.

    The carrier is not shaken, no speed is prescribed, all free vibrations and balancing bodies are damped, and the torque on
    each shaft, less what it is at rest, acts against every speed.
    """
    prescribed = machine.shaken is not None or any(r.coordinate.prescribed is not None for r in machine.rotors)
    poles = Vibration.of(machine).poles
    if prescribed or not damped(machine) or not (-poles.real > _NO_DECAY * np.abs(poles)).all():
        return False
    torques, speeds = [net_torque(machine, r) for r in machine.rotors], np.linspace(-fastest, fastest, 201)
    return all((torque(float(w)) - torque(0.0)) * w <= 0 for torque in torques for w in speeds)


def torque_surplus(machine: Machine, vibration: Vibration, phases: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """What the torque on the main shaft exceeds that of a vibration by at steady speeds (N,), positive in its drive's sense.

    phases: of the bodies that excite it, (n,).
    """
    torque = net_torque(machine, machine.rotor)
    sense = math.copysign(1.0, torque(0.0))
    drive = np.array([sense * torque(sense * float(w)) for w in speeds])
    return np.asarray(drive - vibration.torque(speeds, phases)[0])


def swing_frequency(machine: Machine) -> float:
    """The angular frequency at which the unbalanced bodies swing in the carrier's gravity, all alike; 0 without it."""
    gravity = machine.values.get("carrier.gravity", 0.0)
    if not gravity:
        return 0.0
    kinetic = machine.function(machine.structure.kinetic_in_operation, of=SPEED, modules="math")
    square = gravity * float(np.abs(unbalances(machine)).sum()) / (2 * float(kinetic(1.0)[0]))
    return math.sqrt(square) if math.isfinite(square) else 0.0
