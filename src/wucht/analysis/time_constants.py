"""How long transients of a machine last: the decay of its slowest vibration and slip, and the run-up."""

from __future__ import annotations

import math

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, net_torque
from wucht.machines.structure import SPEED
from wucht.numerics.flow.program import Evaluator

_STEP = 1e-5  # of the speed
_NONE = 1e-6  # of the speed: a rate below it is no decay


def slowest_decay(machine: Machine, speed: float) -> float:
    """In what time the slowest disturbance falls by the factor e that falls at all: a free vibration of the carrier, or the slip
    of a body while the others turn at a speed. 0 where there is none."""
    poles = Vibration.of(machine).poles
    rates = np.append(-poles.real[-poles.real > _NONE * np.abs(poles)], _slip_rates(machine, speed or 1.0))
    return 1 / float(rates.min()) if len(rates) else 0.0


def _slip_rates(machine: Machine, speed: float) -> np.ndarray:
    """The rates at which differences of the bodies' speeds decay: with the carrier at rest and all bodies at angle 0."""
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed is None]
    state, h = np.zeros(len(machine.state_names)), _STEP * abs(speed)
    state[free] = speed
    states = np.repeat(state[:, None], 2 * len(free), axis=1)
    states[free, range(len(free))] += h
    states[free, range(len(free), 2 * len(free))] -= h
    system = machine.system
    with np.errstate(all="ignore"):
        rates = Evaluator.of_rates(system).array(np.zeros(2 * len(free)), states, system.values(machine.values))[free]
    matrix = (rates[:, : len(free)] - rates[:, len(free) :]) / (2 * h)
    if not np.isfinite(matrix).all():
        return np.empty(0)
    decays = -np.linalg.eigvals(matrix).real
    return np.asarray(decays[decays > _NONE * abs(speed)])


def run_up_time(machine: Machine) -> float:
    """How long the main rotor's run-up to its free speed takes about, without vibration; 0 where it has none."""
    rotor = machine.rotor
    free = None if rotor.coordinate.prescribed is not None else free_speed(machine, rotor)
    if not free:
        return 0.0
    energy = machine.function(machine.structure.kinetic_in_operation, of=SPEED, modules="math")
    torque = abs(net_torque(machine, rotor)(free / 2))
    time = 2 * float(energy(free)[0]) / abs(free) / torque if torque else 0.0
    return time if math.isfinite(time) else 0.0
