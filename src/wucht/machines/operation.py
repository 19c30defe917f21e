"""Steady operation without vibration: rest position of the axis, shaft torques, speeds of drives, natural frequencies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import TypeVar

import numpy as np
import sympy as sp

from wucht.machines import structure
from wucht.machines.mechanism import Mechanism
from wucht.machines.structure import SPEED
from wucht.machines.tree import RotatingBody
from wucht.mechanics.energies import Energies
from wucht.numerics.flow.program import number_function, variable_function
from wucht.numerics.zeros_and_peaks import first_where
from wucht.system import TIME

MechanismT = TypeVar("MechanismT", bound=Mechanism)
_FASTEST = 1e9  # rad/s: a drive whose net torque is still positive there has no equilibrium
_MOST_TIMES = 64  # at which the machine is examined for its fastest operation
_DRIVEN_POINTS = 401  # speeds at which a drive is examined
MOST_BODIES = 11  # of a machine whose states are searched
LOWEST = 1e-3  # of the highest speed: lower end of a search
_SLOWER, _FASTER = 1e-3, 1e3  # of the lowest and the highest speed of the machine: limits of computations
_DEFAULT_SPEED = 100.0  # rad/s, where neither natural frequencies nor drives determine a speed
_SAME = 1e-6  # of the speed: equilibria that are one
_MARGIN = 1 + 1e-4  # of the highest speed without vibration: upper end of a search
_RUNAWAY = 3  # times the highest natural frequency: upper end of a search where the drive has no no-load speed


def axis_at_rest(machine: Mechanism) -> dict[str, float]:
    """Return the coordinates of ``machine.orbit`` while the carrier rests."""
    positions = tuple(x for x, _ in machine.orbit.values())
    symbols = (*(c.position for c in machine.carrier), *machine.structure.symbols)
    resting = number_function(positions, symbols)((*machine.rest.tolist(), *machine.values.values()))
    return dict(zip(machine.orbit, map(float, resting), strict=True))


def sense_of(machine: Mechanism, body: RotatingBody) -> float:
    """Return +1 for a body that turns counter-clockwise in operation, -1 for one that turns clockwise with its drive.

    Where nothing but the vibration limits the speed, it turns as the torque at standstill drives it.
    """
    rotor = machine.rotor_of(body)
    speed = free_speed(machine, rotor)
    return -1.0 if (net_torque(machine, rotor)(0.0) if speed is None else speed) < 0 else 1.0


def shaft_torques(machine: Mechanism, rotor: RotatingBody) -> tuple[sp.Expr, sp.Expr]:
    """Return the driving and the braking torque of a rotor whose bodies turn with it, the carrier at rest.

    Expressions in ``SPEED`` and the parameters: of all drives, in the direction of positive speeds; of loads and bearings,
    against it.
    """
    return structure.steady_shaft_torques(machine.structure, tuple(b.coordinate.velocity for b in machine.group(rotor)))


def relative_damping(machine: Mechanism, body: RotatingBody) -> sp.Expr:
    """Return the coefficient of the damper between a body and the one it turns about, with all numbers put in.

    It is the decrease of the losses on the body with the speed of the other.
    """
    assert body.about is not None
    body_speed, reference_speed = body.coordinate.velocity, machine.body(body.about).coordinate.velocity
    return sp.sympify(_relative_damping(machine.without_contacts, body_speed, reference_speed).xreplace(machine.numbers))


def has_damped_balancers(machine: Mechanism) -> bool:
    """True if every balancing body is damped against the body it turns about."""
    dampers = [relative_damping(machine, b) for b in machine.bodies if b.about is not None]
    return all(not b.is_number or b > 0 for b in dampers)


@lru_cache(maxsize=256)
def _relative_damping(energies: tuple[Energies, ...], body_speed: sp.Symbol, reference_speed: sp.Symbol) -> sp.Expr:
    return -sp.diff(structure.torques_on(energies, body_speed)[1], reference_speed)


def gives_torque(machine: Mechanism, rotor: RotatingBody) -> bool:
    """True if the drives of a rotor give a torque at some speed."""
    drive, _ = shaft_torques(machine, rotor)
    torque, top = machine.function(drive, of=SPEED, modules="math"), operating_speed(machine)
    return any(float(torque(share * top)[0]) != 0.0 for share in (-1.0, 0.0, 0.37, 1.0))


def is_driven(machine: Mechanism, rotor: RotatingBody, fastest: float) -> bool:
    """True if the drives of a rotor turn it: they give a torque at standstill, or power at some speed up to ``fastest``."""
    drive, _ = shaft_torques(machine, rotor)
    torque, speeds = machine.function(drive, of=SPEED, modules="math"), np.linspace(-fastest, fastest, _DRIVEN_POINTS)
    return float(torque(0.0)[0]) != 0.0 or any(float(torque(float(w))[0]) * w > 0 for w in speeds)


def net_torque(machine: Mechanism, rotor: RotatingBody) -> Callable[[float], float]:
    """Return the drive torque less bearing losses on a rotor whose bodies turn with it, the carrier at rest and weightless."""
    drive, losses = shaft_torques(machine, rotor)
    function = machine.function(drive - losses, of=SPEED, modules="math")
    return lambda w: float(function(w)[0])


def rotor_inertia(machine: Mechanism, rotor: RotatingBody) -> float:
    """Return the moment of inertia of a rotor and the bodies that turn with it, with the inertia of their drives."""
    kinetic = machine.structure.kinetic_of(machine.group(rotor)).xreplace({SPEED: sp.S.One})
    return 2 * float(machine.evaluate(kinetic)[0])


def free_speed(machine: Mechanism, rotor: RotatingBody, time: float = 0.0) -> float | None:
    """Return the speed that the drive reaches without vibration, None where it is undetermined (no drive and no losses).

    Prescribed speeds are returned as they are at a time; a motor without load reaches its no-load speed, less what bearings
    cost. Where schedules change the drive, give the machine ``at`` that time.
    """
    if rotor.coordinate.prescribed_velocity is not None:
        return float(machine.prescribed_speed(rotor.coordinate, time)[0])
    torque = net_torque(machine, rotor)
    start = torque(0.0)
    slope = _constant_slope(machine, rotor) if start else None
    if slope:
        rough = -start / slope
        return rough - torque(rough) / slope  # the second step removes the rounding of the first
    return None if slope == 0 else _equilibrium_from(machine, rotor, 0.0)


def free_speed_from(machine: Mechanism, rotor: RotatingBody, speed: float, time: float = 0.0) -> float | None:
    """Return the speed that a rotor reaches without vibration from one at which it turns already, in rad per unit of time.

    It is ``free_speed``, but for a rotor that is faster: a motor that cannot lift its load from standstill may well hold it
    at speed.
    """
    free = free_speed(machine, rotor, time)
    if free is None or rotor.coordinate.prescribed_velocity is not None or abs(speed) <= abs(free):
        return free
    faster = _equilibrium_from(machine, rotor, speed)
    is_same = faster is None or abs(faster - free) <= _SAME * abs(speed)
    return free if is_same else faster


def common_free_speed(machine: Mechanism) -> float | None:
    """Return the speed that all drives together reach without vibration if all rotors turn at one, each in its sense.

    It is positive; 0 where losses bring them to rest, None where it is not determined. Rotors are free to turn.
    """
    torques = [(sense_of(machine, rotor), net_torque(machine, rotor)) for rotor in machine.rotors]
    return _equilibrium_speed(lambda w: sum(sense * torque(sense * w) for sense, torque in torques))


def _equilibrium_from(machine: Mechanism, rotor: RotatingBody, origin: float) -> float | None:
    """Return the speed at which the net torque on a rotor first vanishes, from one at which it turns."""
    torque, symbols, places = _net_torque_of(*shaft_torques(machine, rotor), machine.structure.symbols)
    values = tuple(machine.values.values())
    return _equilibrium_of(torque, symbols, tuple(values[i] for i in places), origin)


@lru_cache(maxsize=256)
def _net_torque_of(
    drive: sp.Expr, losses: sp.Expr, symbols: tuple[sp.Symbol, ...]
) -> tuple[sp.Expr, tuple[sp.Symbol, ...], tuple[int, ...]]:
    """Return the net torque, and those of some symbols that it has, with their places."""
    torque = drive - losses
    places = tuple(i for i, s in enumerate(symbols) if torque.has(s))
    return torque, tuple(symbols[i] for i in places), places


@lru_cache(maxsize=1024)  # of a verdict on many bodies it is needed for each of them
def _equilibrium_of(torque: sp.Expr, symbols: tuple[sp.Symbol, ...], values: tuple[float, ...], origin: float) -> float | None:
    function = variable_function((torque,), symbols, SPEED, "math")
    return _equilibrium_speed(lambda w: float(function(values, w)[0]), origin)


def _equilibrium_speed(torque: Callable[[float], float], origin: float = 0.0) -> float | None:
    """Return the speed, in the sense of the torque at an origin, at which a torque first vanishes; None if it never does."""
    start = torque(origin)
    if start == 0.0:
        return origin if torque(origin + 1.0) < 0 else None
    low, high = 0.0, math.copysign(1e-3, start)
    while abs(high) < _FASTEST:
        if torque(origin + high) * start <= 0:
            return origin + first_where(lambda step: not torque(origin + step) * start > 0, low, high)
        low, high = high, 1.5 * high
    return None


def _constant_slope(machine: Mechanism, rotor: RotatingBody) -> float | None:
    """Return the slope of the net torque over the speed where that is a straight line, else None."""
    drive, losses = shaft_torques(machine, rotor)
    (slope,) = slopes((drive - losses,))
    (bend,) = slopes((slope,))
    if bend.has(SPEED) or (bend != 0 and machine.evaluate(bend)[0] != 0):
        return None
    return float(machine.evaluate(slope.xreplace({SPEED: sp.S.Zero}))[0])


@lru_cache(maxsize=256)
def slopes(torques: tuple[sp.Expr, ...]) -> tuple[sp.Expr, ...]:
    """Return the derivatives of torques by the speed."""
    return tuple(sp.diff(t, SPEED) for t in torques)


def natural_frequencies(machine: Mechanism) -> dict[str, float]:
    """Return the undamped natural frequencies of the free carrier with all bodies on it, in rad per unit of time.

    By direction where the directions are not coupled, else by number, the lowest first.
    """
    mass, _, stiffness = machine.matrices
    if all(np.array_equal(m, np.diag(np.diag(m))) for m in (mass, stiffness)):
        pairs = zip(machine.free_labels, np.diag(stiffness), np.diag(mass), strict=True)
        return {label: math.sqrt(max(k, 0.0) / m) if m > 0 else math.nan for label, k, m in pairs}
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
    return {f"mode {i + 1}": math.sqrt(max(float(s), 0.0)) for i, s in enumerate(squares)}


def operating_speed(machine: Mechanism, time: float = 0.0) -> float:
    """Return the largest of the speeds that the drives reach without vibration and of the natural frequencies, in magnitude.

    Where schedules change the machine, give it ``at`` that time.
    """
    free = [free_speed(machine, rotor, time) for rotor in machine.rotors]
    return max([*(abs(w) for w in free if w is not None), *natural_frequencies(machine).values(), 1.0])


def fastest_operating_speed(machine: Mechanism) -> float:
    """Return the largest operating speed that the schedules reach: at their points and halfway between them.

    Of long tables at their largest and smallest values, and at some points evenly.
    """
    points = np.array(machine.breakpoints)
    times = np.sort(np.concatenate([points, 0.5 * (points[1:] + points[:-1])]))
    if len(times) > _MOST_TIMES:
        courses = [s.pieces(times) for s in machine.schedules]
        extremes = [k for values in courses for k in (values.argmin(), values.argmax())]
        times = times[np.unique([*extremes, *np.linspace(0, len(times) - 1, _MOST_TIMES, dtype=int)])]
    return max(operating_speed(machine.at(t), t) for t in times.tolist())


def machine_at_speed(machine: MechanismT, speed: float | None) -> MechanismT:
    """Return the machine with its schedules finished, all bodies released, and the main rotor at a given speed (signed)."""
    end = machine.breakpoints[-1]
    steady = machine.at(end).with_fields(schedules=())
    bodies = [replace(b, release=None) for b in steady.bodies]
    prescribed_speeds = {b.name: b.coordinate.prescribed_velocity for b in bodies}
    speeds = {
        name: None if at_time is None else at_time.xreplace({TIME: sp.Float(end)})
        for name, at_time in prescribed_speeds.items()
    }
    if speed is not None:
        speeds[machine.rotor.name] = sp.Float(speed)
    bodies = [replace(b, coordinate=replace(b.coordinate, prescribed_velocity=speeds[b.name])) for b in bodies]
    return steady.with_fields(bodies=tuple(bodies))


def driven_speeds(machine: Mechanism) -> tuple[tuple[float, float], bool]:
    """Return the range up to the highest speed without vibration, and whether a drive runs away without load."""
    free = {r: free_speed(machine, r) for r in machine.rotors}
    top = max((abs(w) for w in free.values() if w is not None), default=0.0)
    runaway = any(w is None and net_torque(machine, r)(0.0) for r, w in free.items())
    if runaway:
        top = max(top, _RUNAWAY * max((f for f in natural_frequencies(machine).values() if f > 0), default=_DEFAULT_SPEED))
    return (LOWEST * top, top if runaway else _MARGIN * top), runaway


def computable_speeds(machine: Mechanism) -> tuple[float, float]:
    """Return the lowest and the highest computable speed, by the machine's natural frequencies and drives."""
    machine_speeds = [*natural_frequencies(machine).values(), *(abs(free_speed(machine, r) or 0.0) for r in machine.rotors)]
    machine_speeds = [w for w in machine_speeds if w > 0 and math.isfinite(w)] or [_DEFAULT_SPEED]
    return _SLOWER * min(machine_speeds), _FASTER * max(machine_speeds)
