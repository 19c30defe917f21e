"""Starting from rest: the torque of a drive at standstill, and the moments of weight and load that it must overcome.

A rotor on a carrier at rest hangs with its centre of mass below its axis; theta is its angle from there, in the sense of its
drive: J theta'' = T(theta') - L(theta') - M sin theta. Under a torque that grows slowly it turns over if T - L exceeds the
moment M of its weight. A constant torque that comes suddenly needs less, the largest of M (1 - cos theta)/theta, since the
rotor swings. It starts if the first swing takes it over the top. A torque that rises with the speed may increase further
swings until it turns over after all: that depends on the vibration of the carrier, which only a run-up has.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.analysis.vibration import unbalances
from wucht.analysis.working_points import creep_speed
from wucht.machines.machine import Machine
from wucht.machines.operation import shaft_torques
from wucht.machines.parts.table_load import TableLoad
from wucht.machines.structure import SPEED
from wucht.machines.tree import RotatingBody

SUDDEN = 0.72461135377686  # the largest (1 - cos x)/x, which is sin x where x sin x = 1 - cos x
_TOLERANCE = 1e-9  # of the integration
_LONGEST = 1e3  # times sqrt(J/M), that the first swing may take: a slower rotor creeps


def gravity_of(machine: Machine) -> float:
    """The acceleration of gravity, along -y; 0 where it moves no body."""
    if machine.frame.tilt != 0:  # a couple unbalance has no weight in the plane
        return 0.0
    gravity = sp.sympify(machine.frame.gravity)
    return machine.values[gravity.name] if gravity.is_Symbol else float(gravity)


def has_weight_or_load(machine: Machine) -> bool:
    """True if a rotor may have to lift something at standstill: gravity acts, or a load has a torque there."""
    return bool(gravity_of(machine)) or creep_speed(machine) > 0 or any(isinstance(p, TableLoad) for p in machine.parts)


def turning_with(machine: Machine, body: RotatingBody) -> list[RotatingBody]:
    """A body and those about it that are locked to it, directly or through others."""
    locked_bodies = [b for b in machine.bodies if b.about == body.name and is_locked(machine, b)]
    return [body, *(outer for b in locked_bodies for outer in turning_with(machine, b))]


def is_locked(machine: Machine, body: RotatingBody) -> bool:
    """True if a body is locked to what it turns about."""
    return body.release is not None and machine.values.get(body.lock_symbol.name, 1.0) != 0.0


def static_moment(machine: Machine, body: RotatingBody) -> complex:
    """Mass times distance, complex in the body's frame, of a body, the pivots on it, and the bodies that are locked to it.

    These are locked at angle 0, or at that which the machine gives them.
    """
    moments, offsets = dict(zip(machine.bodies, unbalances(machine).tolist(), strict=True)), {body.name: 0.0}
    for b in turning_with(machine, body)[1:]:
        offsets[b.name] = offsets[str(b.about)] + machine.start_angles.get(b.name, 0.0)
    return complex(sum(moments[machine.body(n)] * complex(math.cos(a), math.sin(a)) for n, a in offsets.items()))


@dataclass(frozen=True)
class StartFromRest:
    """A rotor that hangs at rest, and its drive. Torques are magnitudes, positive in the sense of the drive.

    Parameters
    ----------
    machine : Machine
        At a time of its schedules: ``machine.at(time)``.
    rotor : RotatingBody
        Free to turn.
    """

    machine: Machine
    rotor: RotatingBody

    @cached_property
    def _torques(self) -> Callable[[float], list[float]]:
        return self.machine.function(*shaft_torques(self.machine, self.rotor), of=SPEED, modules="math")

    @cached_property
    def sense(self) -> float:
        """The sense in which the drive pushes at standstill, +1 or -1."""
        return math.copysign(1.0, float(self._torques(0.0)[0]))

    def net_torque(self, speed: float) -> tuple[float, float]:
        """The torque of the drives and that of loads and bearings against it, at a speed in the sense of the drive."""
        drive, losses = self._torques(self.sense * speed)
        return self.sense * float(drive), self.sense * float(losses)

    @cached_property
    def torque(self) -> float:
        """The torque of the drives at standstill; under dry friction at the speed below which a rotor creeps."""
        return self.net_torque(creep_speed(self.machine))[0]

    @cached_property
    def load(self) -> float:
        """The torque of loads and bearings there."""
        return self.net_torque(creep_speed(self.machine))[1]

    @cached_property
    def weight(self) -> float:
        """The largest moment of the weight over a turn, of the rotor and what turns with it; balancing bodies hang."""
        return abs(gravity_of(self.machine) * static_moment(self.machine, self.rotor))

    @property
    def is_held(self) -> bool:
        """True if there is a drive with a torque, but less than weight and load: the rotor can stay at rest under it."""
        return 0 < self.torque <= self.weight + self.load

    @cached_property
    def starts(self) -> bool:
        """True if the drive, switched on suddenly, takes the rotor over the top in its first swing, the carrier at rest.

        Bodies about it do not brake it.
        """
        if not self.is_held or self.torque <= self.load:
            return self.torque > self.weight + self.load
        kinetic = self.machine.structure.kinetic_of(turning_with(self.machine, self.rotor)).xreplace({SPEED: sp.S.One})
        inertia = 2 * float(self.machine.evaluate(kinetic)[0])
        return _turns_over(self.net_torque, self.weight, inertia, creep_speed(self.machine))

    @property
    def reason(self) -> str:
        """The torques in words: what the drive gives, and what weight and load need."""
        unit = f" {self.machine.units.torque}".rstrip()
        needs = [f"the load takes {self.load:.4g}{unit}"] if self.load > 0 else []
        if self.weight > 0:
            weight = f"the weight takes up to {self.weight:.4g}{unit}"
            needs.append(f"{weight} ({SUDDEN * self.weight:.4g}{unit} of a constant torque that comes suddenly)")
        return f"the drive gives {self.torque:.4g}{unit} at standstill, {' and '.join(needs) or 'without a load'}"


def starts_from_rest(machine: Machine) -> dict[str, StartFromRest]:
    """Return for each rotor that is free to turn, by name, what decides whether its drive starts it from rest.

    Parameters
    ----------
    machine : Machine
        At a time of its schedules: ``machine.at(time)``.

    Returns
    -------
    dict of str to StartFromRest
        ``starts`` is the answer; ``torque``, ``weight``, ``load`` its reasons. Without a drive the torque is 0.
    """
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None and r.release is None]
    return {r.name: StartFromRest(machine, r) for r in free}


def not_started_in_words(starts: Mapping[str, StartFromRest], is_named: bool = True) -> str:
    """Return the sentence on rotors that do not start, those with the same torques together. is_named: by their names."""
    names_by_reason: dict[str, list[str]] = {}
    for name, start in starts.items():
        names_by_reason.setdefault(start.reason, []).append(name)
    return "; ".join(
        f"{', '.join(names) if is_named else 'the rotor'} {'do' if len(names) > 1 else 'does'} not start: "
        f"{reason}{' of each' if len(names) > 1 else ''}"
        for reason, names in names_by_reason.items()
    )


def _turns_over(torques: Callable[[float], tuple[float, float]], weight: float, inertia: float, creep: float) -> bool:
    """True if a rotor gets over the top in its first swing from rest at the bottom.

    torques: of drive and losses at a speed. weight: its largest moment. creep: the speed below which dry friction holds it.
    """
    from scipy.integrate import LSODA

    def rates(_: float, state: np.ndarray) -> tuple[float, float]:
        angle, speed = state.tolist()
        drive, losses = torques(speed)
        return speed, (drive - losses - weight * math.sin(angle)) / inertia

    longest = _LONGEST * math.sqrt(inertia / weight)
    solver = LSODA(rates, 0.0, [0.0, 0.0], longest, rtol=_TOLERANCE, atol=_TOLERANCE)
    while solver.status == "running":
        before = float(solver.y[1])
        solver.step()
        if solver.y[0] >= math.pi or solver.y[1] <= min(before, creep):
            return bool(solver.y[0] >= math.pi)
    return False
