"""Energies -> System: the Euler-Lagrange equations of the second kind, derived part by part.

For coordinates q with velocities v:  d/dt dT/dv - dT/dq + dV/dq + dR/dv = sum force * d rate/dv.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.energies import Energies
from wucht.system import TIME, Output, SecondOrder, System


@dataclass(frozen=True)
class Coordinate:
    """A generalised coordinate and its velocity; ``angle`` if it lives on a circle.

    ``prescribed`` is the velocity it is given from outside (an expression in parameters and time), or None if it is free.
    """

    position: sp.Symbol
    velocity: sp.Symbol
    angle: bool = False
    prescribed: sp.Expr | None = None

    @classmethod
    def named(cls, name: str, velocity: str, angle: bool = False, prescribed: sp.Expr | None = None) -> Coordinate:
        """A coordinate whose symbols bear these names."""
        return cls(sp.Symbol(name, real=True), sp.Symbol(velocity, real=True), angle, prescribed)


@dataclass(frozen=True)
class Lock:
    """Coordinate ``index`` follows the coordinate ``about`` (None: it stands still) while the parameter ``locked`` is 1.

    Both must have the same velocity when the lock is on; at 0 the coordinate is free.
    """

    index: int
    about: int | None
    locked: sp.Symbol


def equations_of_motion(parts: Sequence[Energies], coordinates: Sequence[Coordinate]) -> SecondOrder:
    """Mass matrix and forces of ``M a = F``.

    parts: energies in the coordinates' symbols. A prescribed coordinate keeps its row: there the force still lacks the unknown
    torque that enforces the motion. Raises ``WuchtError`` if a kinetic energy is not quadratic in the velocities.
    """
    q = [c.position for c in coordinates]
    v = [c.velocity for c in coordinates]
    n = len(q)
    mass = sp.zeros(n, n)
    forces, other = [sp.S.Zero] * n, [sp.S.Zero] * n
    for part in parts:
        used = {k for k in range(n) for e in (part.kinetic, part.potential, part.dissipation) if e.has(q[k]) or e.has(v[k])}
        for i in sorted(used):
            momentum = sp.diff(part.kinetic, v[i])
            for j in sorted(used):
                inertia = sp.diff(momentum, v[j])
                if inertia.free_symbols & set(v):
                    raise WuchtError(f"the kinetic energy {part.kinetic} is not quadratic in the velocities")
                mass[i, j] += inertia
                forces[i] -= sp.diff(momentum, q[j]) * v[j]
            forces[i] += sp.diff(part.kinetic, q[i]) - sp.diff(momentum, TIME)
            other[i] -= sp.diff(part.potential, q[i]) + sp.diff(part.dissipation, v[i])
    # T is quadratic in the velocities, so the velocity products appear twice; expanding merges them.
    forces = [sp.expand(f) + rest for f, rest in zip(forces, other, strict=True)]
    for applied in (a for part in parts for a in part.applied):
        for i in range(n):
            forces[i] += applied.force * sp.diff(applied.rate, v[i])
    driven = tuple(c.position for c in coordinates if c.prescribed is not None)
    return SecondOrder(tuple(q), tuple(v), sp.ImmutableMatrix(mass), sp.ImmutableMatrix(n, 1, forces), driven)


def first_order(
    motion: SecondOrder,
    coordinates: Sequence[Coordinate],
    parameters: Sequence[sp.Symbol],
    outputs: Sequence[Output] = (),
    quadratures: Sequence[Output] = (),
    locks: Sequence[Lock] = (),
) -> System:
    """The System of a mechanism: positions, then the velocities of the free coordinates, as states.

    Outputs and quadratures may use ``acceleration(c)`` of any coordinate, the velocity of any, and ``reaction(c)``, the force
    that enforces a prescribed motion. locks: those on other coordinates' followers first.
    """
    n = len(coordinates)
    free = [i for i, c in enumerate(coordinates) if c.prescribed is None]
    definitions: list[tuple[sp.Symbol, sp.Expr]] = []
    given: dict[int, sp.Expr] = {}
    for i, c in enumerate(coordinates):
        if c.prescribed is not None:
            definitions.append((c.velocity, c.prescribed))
            given[i] = sp.diff(c.prescribed, TIME)
            definitions.append((acceleration(c), given[i]))
    if free:
        known = {i: sp.Add(*(motion.mass[i, k] * a for k, a in given.items())) for i in free}
        right = {i: motion.forces[i] - known[i] for i in free}
        mass = {(i, j): motion.mass[i, j] for i in free for j in free}
        for lock in locks:
            _apply(lock, mass, right, given, free)
        names = [coordinates[i].position.name for i in free]
        matrix = sp.ImmutableMatrix(len(free), len(free), [mass[i, j] for i in free for j in free])
        lines, solved = solve_by_elimination(matrix, sp.ImmutableMatrix([right[i] for i in free]), names)
        accelerations = dict(zip(free, solved, strict=True)) | given
        for lock in reversed(locks):
            if lock.about is not None:
                accelerations[lock.index] += lock.locked * accelerations[lock.about]
        definitions += lines
        definitions += [(acceleration(coordinates[i]), accelerations[i]) for i in free]
    rest = [sp.Add(*(motion.mass[i, j] * acceleration(coordinates[j]) for j in range(n))) - motion.forces[i] for i in range(n)]
    for lock in locks:  # what a lock pushes its coordinate with, it takes from the other
        if lock.about is not None:
            rest[lock.about] += lock.locked * rest[lock.index]
    definitions += [(reaction(coordinates[i]), rest[i]) for i in given]
    return System(
        states=(*(c.position for c in coordinates), *(coordinates[i].velocity for i in free)),
        derivatives=(*(c.velocity for c in coordinates), *(acceleration(coordinates[i]) for i in free)),
        parameters=tuple(parameters),
        definitions=tuple(definitions),
        outputs=tuple(outputs),
        quadratures=tuple(quadratures),
        angles=frozenset(c.position for c in coordinates if c.angle),
        second_order=motion,
    )


def _apply(
    lock: Lock,
    mass: dict[tuple[int, int], sp.Expr],
    right: dict[int, sp.Expr],
    given: Mapping[int, sp.Expr],
    free: Sequence[int],
) -> None:
    """Write the locked coordinate's acceleration as that of the other plus a rest, which is zero while it is locked.

    With s = 1 the two equations of motion are added, so that the unknown torque between them drops out; with s = 0 nothing
    changes. The matrix stays symmetric and positive definite.
    """
    i, k, s = lock.index, lock.about, lock.locked
    if k is not None and k in given:
        for j in free:
            right[j] -= mass[j, i] * s * given[k]
    elif k is not None:
        for j in free:
            mass[j, k] += s * mass[j, i]
        for j in free:
            mass[k, j] += s * mass[i, j]
        right[k] += s * right[i]
    for j in free:
        if j != i:
            mass[i, j] *= 1 - s
            mass[j, i] *= 1 - s
    right[i] *= 1 - s


def acceleration(coordinate: Coordinate) -> sp.Symbol:
    """The symbol of a coordinate's acceleration."""
    return sp.Symbol(f"{coordinate.position.name}.acceleration", real=True)


def reaction(coordinate: Coordinate) -> sp.Symbol:
    """The symbol of the force or torque that enforces a prescribed motion."""
    return sp.Symbol(f"{coordinate.position.name}.reaction", real=True)


def dissipated_power(parts: Sequence[Energies], coordinates: Sequence[Coordinate]) -> sp.Expr:
    """The power lost: ``v . dR/dv`` of the linear dampers, less the power of applied forces booked as lost."""
    lost: list[sp.Expr] = []
    for part in parts:
        lost += [c.velocity * sp.diff(part.dissipation, c.velocity) for c in coordinates]
        lost += [-a.power for a in part.applied if a.booked == "lost"]
    return sp.Add(*lost)


def supplied_power(parts: Sequence[Energies], coordinates: Sequence[Coordinate]) -> sp.Expr:
    """The power of all motors, those included that enforce a prescribed speed."""
    motors = [a.power for part in parts for a in part.applied if a.booked == "supplied"]
    enforced = [reaction(c) * c.velocity for c in coordinates if c.prescribed is not None]
    return sp.Add(*motors, *enforced)
