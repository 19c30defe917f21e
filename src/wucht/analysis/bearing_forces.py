"""Forces of rotors on their bearings, in both directions of the plane, and the ratings of these bearings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.fatigue.bearing_life import BearingRating
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body, Point
from wucht.machines.parts.rotor import Rotor
from wucht.machines.tree import Tree
from wucht.mechanics.lagrange import Coordinate, acceleration, equations_of_motion
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

_PLANE = ("x", "y")
_SPEED = "speed"
_VIRTUAL = {d: Coordinate.from_names(f"bearing.{d}", f"bearing.v{d}") for d in _PLANE}


def bearing_ratings(machine: Machine) -> dict[str, BearingRating]:
    """Return the ratings of bearings that have one, by the name of their rotor."""
    names = [p.name for p in machine.parts if isinstance(p, Rotor) and p.bearing is not None]
    return {n: BearingRating(machine.values[f"{n}.bearing.C"], machine.values[f"{n}.bearing.p"]) for n in names}


@dataclass(frozen=True)
class BearingForces:
    """Forces of a machine's rotors, each with the bodies about it, on their bearings: of the bearing on what carries it.

    rotors: their names. evaluator: of both components and of the speed against the carrier of each.
    """

    rotors: tuple[str, ...]
    evaluator: Evaluator

    @classmethod
    def of(cls, machine: Machine, rotors: tuple[str, ...] | None = None) -> BearingForces:
        """Return the forces of some rotors, by default of all, of a machine with units and without couple unbalance."""
        names = tuple(r.name for r in machine.rotors) if rotors is None else rotors
        expressions = list[sp.Expr]()
        for name in names:  # the outer ring of a bearing sits in the carrier
            expressions += [bearing_force(machine, name, direction) for direction in _PLANE]
            expressions.append(machine.body(name).coordinate.velocity - machine.frame.rotation)
        return cls(names, Evaluator.of(machine.system, expressions, [f"{n}.{k}" for n in names for k in (*_PLANE, _SPEED)]))

    def __call__(self, motion: Trajectory) -> tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]:
        """Return the forces (2, N) in N and the speeds (N,) in rad/s over the machine's motion, by rotor."""
        rows = self.evaluator(motion.time, motion.states, motion.final_parameter_values)
        forces = {n: np.array([rows[f"{n}.{d}"] for d in _PLANE]) for n in self.rotors}
        return forces, {n: rows[f"{n}.{_SPEED}"] for n in self.rotors}


def bearing_force(machine: Machine, rotor: str, direction: str) -> sp.Expr:
    """Return the force of a rotor, with the bodies about it, on its bearing in x or y, in the symbols of the System.

    In a direction in which the carrier moves it is the System's output; in another one it follows from a virtual displacement
    of the rotor's axis.
    """
    if direction not in machine.labels:
        return _force_on_guide(machine, rotor, direction)
    alone = len(machine.rotors) == 1
    return machine.system.output(f"bearing_force_{direction}" if alone else f"bearing_force[{rotor}]_{direction}").expression


def _force_on_guide(machine: Machine, rotor: str, direction: str) -> sp.Expr:
    """Return the force on a carrier that is held in this direction.

    It is the residual of the equation of motion of the rotor and the bodies about it in a virtual displacement of their axis,
    which stays zero.
    """
    every = {p.name: p for p in machine.parts if isinstance(p, Body)}
    bodies = [every[name] for name in Tree({name: p.reference for name, p in every.items()}).group(rotor)]
    virtual = _VIRTUAL[direction]
    axes = {b.name: _axis_with(machine.frame.axis(b.name), virtual, direction) for b in bodies}
    frame = replace(machine.frame, axes={**machine.frame.axes, **axes})
    coordinates = (*machine.coordinates, virtual)
    motion = equations_of_motion([b.energies(frame) for b in bodies], coordinates)
    accelerations = sp.Matrix([*map(acceleration, machine.coordinates), sp.S.Zero])
    force = motion.forces[-1] - (motion.mass[-1, :] * accelerations)[0]
    return sp.sympify(force.xreplace({virtual.position: sp.S.Zero, virtual.velocity: sp.S.Zero}))


def _axis_with(axis: Point, virtual: Coordinate, direction: str) -> Point:
    position, velocity = getattr(axis, direction) + virtual.position, getattr(axis, f"v{direction}") + virtual.velocity
    return replace(axis, **{direction: position, f"v{direction}": velocity})
