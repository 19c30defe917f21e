"""Question and machine -> plan: the torques on a shaft, and the speeds to look at."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wucht.analysis.configurations.steady_machine import LOWEST
from wucht.analysis.time_constants import highest_speed
from wucht.analysis.working_points import TorqueCurves
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies, net_torque, sense_of
from wucht.machines.tree import RotatingBody
from wucht.studies.torque_balance.spec import TorqueBalance

_FAR, _POINTS = 20.0, 1200  # times the highest natural frequency; speeds at which working points are looked for


@dataclass(frozen=True)
class Plan:
    """curves: the torques on the shaft over a range of its speed, for each branch of ``steady`` or for its held bodies.

    searched: lowest and highest speed at which working points of bodies in steady phases are looked for, in the main rotor's
    own sense.
    """

    steady: SteadyPhases
    curves: tuple[TorqueCurves, ...]
    searched: tuple[float, float]


def prepare(spec: TorqueBalance, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the start does not fit the machine, or the shaft has no drive with a torque."""
    by_name = {r.name: r for r in machine.rotors}
    if spec.on is not None and spec.on not in by_name:
        raise InputError("study.on", spec.on, f"must be a rotor: {', '.join(by_name)}")
    rotor = machine.rotor if spec.on is None else by_name[spec.on]
    steady = SteadyPhases.of(machine, spec.start, spec.bodies)
    if rotor.coordinate.prescribed is not None:
        why = f"the drive gives {rotor.name!r} its speed, whatever torque that takes: nothing is to be balanced"
        advice = "study.kind = 'response' shows the torque that it takes"
        raise InputError("machine.drive", None, f"{why}; {advice}", code="prescribed")
    turning = {b.name for b in machine.group(rotor)}
    if not machine.dimensionless and not any(d.on in turning for d in machine.drives):
        raise InputError(
            "machine.drive", None, f"nothing drives {rotor.name!r}: there is no torque to balance", code="no-drive"
        )
    speeds = spec.range or _speed_range(steady, rotor)
    curves = tuple(TorqueCurves(steady.machine, rotor, forced, speeds, spec.points) for forced in steady.curves)
    return Plan(steady, curves, _searched(steady, speeds) if steady.branches else speeds)


def _searched(steady: SteadyPhases, speeds: tuple[float, float]) -> tuple[float, float]:
    """Of the range (signed) what is to be searched. Raises ``InputError`` where it is not in the sense of the drive."""
    sense = sense_of(steady.machine, steady.machine.rotor)
    low, high = sorted(sense * w for w in speeds)
    if low < 0 or not high > 0:
        allowed = "must be speeds in the sense in which the drive turns; with study.bodies = 'held' it may be any"
        raise InputError("study.range", list(speeds), allowed)
    return max(low, LOWEST * high), high


def _speed_range(steady: SteadyPhases, rotor: RotatingBody) -> tuple[float, float]:
    """The default of ``range``: up to what the drive reaches, or where that is out of reach, up to all working points."""
    machine = steady.machine
    free, torque = free_speed(machine, rotor), net_torque(machine, rotor)(0.0)
    natural = max([f for f in natural_frequencies(machine).values() if f > 0], default=100.0)
    reach = min(highest_speed(machine), _FAR * natural) if machine.dimensionless else highest_speed(machine)
    if free and abs(free) <= reach:
        end = 1.2 * free
    else:  # the vibration may hold the rotor far beyond all resonances
        sense = math.copysign(1.0, free or torque)
        limits = (0.0, reach) if sense > 0 else (-reach, 0.0)
        points = TorqueCurves(machine, rotor, steady.forced, limits, _POINTS).working_points
        end = sense * max([3 * natural, *(1.2 * abs(p.speed) for p in points)])
    return min(0.0, end), max(0.0, end)
