"""Durations of transients of a machine: the decay of its slowest vibration and slip, and the run-up."""

from __future__ import annotations

import math

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies, net_torque, rotor_inertia
from wucht.numerics.flow.program import Evaluator

_NEARLY, _POINTS = 0.005, 200  # of the free speed: distance at which a run-up ends
_RUNAWAY, _SLOWEST_RUNAWAY = 20.0, 150.0  # times the highest natural frequency, or this in rad/s: 30,000 rpm at least
_STEP = 1e-5  # of the speed
_NO_DECAY = 1e-6  # of the speed: a rate below it is no decay


def slowest_decay(machine: Machine, speed: float) -> float:
    """Time constant of the slowest decaying disturbance (decay by the factor e); 0 where there is none.

    It is a free vibration of the carrier, or the slip of a body while the others turn at a speed.
    """
    return max(vibration_decay(machine), 1 / float(_slip_rates(machine, speed or 1.0).min(initial=math.inf)))


def vibration_decay(machine: Machine) -> float:
    """Time constant of the slowest decaying free vibration of the carrier (decay by the factor e); 0 where there is none."""
    poles = Vibration.of(machine).poles
    return 1 / float((-poles.real[-poles.real > _NO_DECAY * np.abs(poles)]).min(initial=math.inf))


def _slip_rates(machine: Machine, speed: float) -> np.ndarray:
    """The rates at which differences of the bodies' speeds decay: with the carrier at rest and all bodies at angle 0."""
    bodies = [b for b in machine.bodies if b.coordinate.prescribed_velocity is None]
    state, h = np.zeros(len(machine.state_names)), _STEP * abs(speed)
    free = [machine.row(b.coordinate.velocity) for b in bodies]
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
    return np.asarray(decays[decays > _NO_DECAY * abs(speed)])


def run_up_time(machine: Machine, speed: float) -> float:
    """Time that the main rotor takes from a speed to its free speed, or to the runaway limit, without vibration.

    0 if it does not reach that.
    """
    rotor = machine.rotor
    if rotor.coordinate.prescribed_velocity is not None:
        return 0.0
    free, torque = free_speed(machine, rotor), net_torque(machine, rotor)
    end = (1 - _NEARLY) * free if free else math.copysign(runaway_limit(machine) or 0.0, torque(0.0))
    if not end or abs(speed) >= abs(end):
        return 0.0
    speeds = np.linspace(math.copysign(abs(speed), end), end, _POINTS)
    torques = np.array([torque(float(w)) for w in speeds]) * math.copysign(1.0, end)
    return float(np.trapezoid(rotor_inertia(machine, rotor) / torques, np.abs(speeds))) if (torques > 0).all() else 0.0


def runaway_limit(machine: Machine) -> float | None:
    """Speed in rad/s at which a run ends whose drive meets no sufficient load; None for all other machines.

    Such are a series motor without load, 002 (2.105), and a constant torque without losses.
    """
    rotor = machine.rotor
    is_limited = rotor.coordinate.prescribed_velocity is not None or free_speed(machine, rotor) is not None
    if is_limited or not machine.units.time or machine.schedules or net_torque(machine, rotor)(0.0) == 0.0:
        return None
    return highest_speed(machine)


def highest_speed(machine: Machine) -> float:
    """Speed in rad/s above all resonances, where a run may end; infinite where time has no unit."""
    return _RUNAWAY * max([*natural_frequencies(machine).values(), _SLOWEST_RUNAWAY]) if machine.units.time else math.inf
