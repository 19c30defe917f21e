"""Energies -> System: the Euler-Lagrange equations of the second kind, derived part by part.

For coordinates q with velocities v:  d/dt dT/dv - dT/dq + dV/dq + dR/dv = sum force * d rate/dv.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.energies import Energies, InternalState
from wucht.mechanics.phasors import Lines
from wucht.system import TIME, Output, SecondOrder, System


@dataclass(frozen=True)
class Coordinate:
    """A generalised coordinate and its velocity.

    Parameters
    ----------
    position, velocity : sympy.Symbol
        Real symbols; ``Coordinate.from_names("x", "v")`` makes them.
    angle : bool, optional
        True for an angle.
    prescribed_velocity : sympy.Expr, optional
        An expression in parameters and time; None if the coordinate is free.
    """

    position: sp.Symbol
    velocity: sp.Symbol
    angle: bool = False
    prescribed_velocity: sp.Expr | None = None

    @classmethod
    def from_names(
        cls, name: str, velocity: str, angle: bool = False, prescribed_velocity: sp.Expr | None = None
    ) -> Coordinate:
        """A coordinate whose symbols bear these names."""
        return cls(sp.Symbol(name, real=True), sp.Symbol(velocity, real=True), angle, prescribed_velocity)


@dataclass(frozen=True)
class Lock:
    """Coordinate ``index`` follows the coordinate ``about`` (None: it stands still) while the parameter ``switch`` is 1.

    Both must have the same velocity when the lock is on; at 0 the coordinate is free.
    """

    index: int
    about: int | None
    switch: sp.Symbol


def equations_of_motion(parts: Sequence[Energies], coordinates: Sequence[Coordinate]) -> SecondOrder:
    """Derive mass matrix and forces of ``M a = F`` from energies: the Euler-Lagrange equations of the second kind.

    Parameters
    ----------
    parts : sequence of Energies
        In the coordinates' symbols.
    coordinates : sequence of Coordinate, n
        A prescribed one keeps its row: there the force still lacks the unknown torque that enforces the motion.

    Returns
    -------
    SecondOrder

    Raises
    ------
    WuchtError
        Where a kinetic energy is not quadratic in the velocities.

    Examples
    --------
    >>> from wucht.mechanics import Coordinate, Energies, equations_of_motion
    >>> x = Coordinate.from_names("x", "v")
    >>> oscillator = Energies(kinetic=x.velocity**2, potential=2 * x.position**2, dissipation=x.velocity**2 / 2)
    >>> equations_of_motion([oscillator], [x]).forces[0]
    -v - 4*x
    """
    q = [c.position for c in coordinates]
    v = [c.velocity for c in coordinates]
    n = len(q)
    mass = sp.zeros(n, n)
    forces, potential_forces = [sp.S.Zero] * n, [sp.S.Zero] * n
    for part in parts:
        symbols = part.kinetic.free_symbols | part.potential.free_symbols | part.dissipation.free_symbols
        active_indices = [k for k in range(n) if q[k] in symbols or v[k] in symbols]
        for i in active_indices:
            momentum = sp.diff(part.kinetic, v[i])
            for j in active_indices:
                inertia = sp.diff(momentum, v[j])
                if inertia.free_symbols & set(v):
                    raise WuchtError(
                        f"the kinetic energy {part.kinetic} is not quadratic in the velocities", code="not-quadratic"
                    )
                mass[i, j] += inertia
                forces[i] -= sp.diff(momentum, q[j]) * v[j]
            forces[i] += sp.diff(part.kinetic, q[i]) - sp.diff(momentum, TIME)
            potential_forces[i] -= sp.diff(part.potential, q[i]) + sp.diff(part.dissipation, v[i])
    applied_forces = [a for part in parts for a in part.applied_forces]
    for i in range(n):
        # T is quadratic in the velocities, so the velocity products appear twice; expanding merges them.
        forces[i] = (
            sp.expand(forces[i]) + potential_forces[i] + sp.Add(*(a.force * sp.diff(a.rate, v[i]) for a in applied_forces))
        )
    driven = tuple(c.position for c in coordinates if c.prescribed_velocity is not None)
    return SecondOrder(tuple(q), tuple(v), sp.ImmutableMatrix(mass), sp.ImmutableMatrix(n, 1, forces), driven)


def first_order(
    motion: SecondOrder,
    coordinates: Sequence[Coordinate],
    parameters: Sequence[sp.Symbol],
    outputs: Sequence[Output] = (),
    quadratures: Sequence[Output] = (),
    locks: Sequence[Lock] = (),
    internal: Sequence[InternalState] = (),
) -> System:
    """Solve equations of motion for the accelerations, as a System of first order.

    Parameters
    ----------
    motion : SecondOrder
        As ``equations_of_motion`` returns it.
    coordinates : sequence of Coordinate
        The same as there.
    parameters : sequence of sympy.Symbol
    outputs, quadratures : sequence of Output, optional
        They may use ``acceleration(c)`` of any coordinate, the velocity of any, and the force ``reaction(c)`` that enforces a
        prescribed motion.
    locks : sequence of Lock, optional
        Those on other coordinates' followers first.
    internal : sequence of InternalState, optional

    Returns
    -------
    System
        Its states are the positions, then the velocities of the free coordinates, then the internal states.

    Raises
    ------
    WuchtError
        Where an expression uses a symbol that is no coordinate and no parameter, or a name has two meanings: see ``System``.
    """
    free = [i for i, c in enumerate(coordinates) if c.prescribed_velocity is None]
    accelerations = {i: sp.diff(c.prescribed_velocity, TIME) for i, c in enumerate(coordinates) if i not in free}
    lines = Lines()
    for i, a in accelerations.items():
        c = coordinates[i]
        lines.pairs += [(c.velocity, c.prescribed_velocity), (acceleration(c), a)]
    lines.pairs += [(internal_state.change, internal_state.rate) for internal_state in internal]
    if free:
        mass = sp.Matrix(motion.mass)
        known_accelerations = sp.Matrix([accelerations.get(i, 0) for i in range(len(coordinates))])
        right = sp.Matrix(motion.forces - mass * known_accelerations)
        for lock in locks:
            _apply_lock(lock, mass, right, accelerations)
        names = [coordinates[i].position.name for i in free]
        solution = solve_by_elimination(mass.extract(free, free), [right[i] for i in free], names, lines)
        accelerations |= dict(zip(free, solution, strict=True))
        for lock in reversed(locks):
            if lock.about is not None:
                accelerations[lock.index] += lock.switch * accelerations[lock.about]
        lines.pairs += [(acceleration(coordinates[i]), accelerations[i]) for i in free]
    rest = sp.Matrix(motion.mass * sp.Matrix([acceleration(c) for c in coordinates]) - motion.forces)
    for lock in locks:  # the force of a lock on its coordinate reacts on the other one
        if lock.about is not None:
            rest[lock.about] += lock.switch * rest[lock.index]
    lines.pairs += [(reaction(c), rest[i]) for i, c in enumerate(coordinates) if c.prescribed_velocity is not None]
    return System(
        states=(
            *(c.position for c in coordinates),
            *(coordinates[i].velocity for i in free),
            *(internal_state.state for internal_state in internal),
        ),
        derivatives=(
            *(c.velocity for c in coordinates),
            *(acceleration(coordinates[i]) for i in free),
            *(internal_state.change for internal_state in internal),
        ),
        parameters=tuple(parameters),
        definitions=tuple(lines.pairs),
        outputs=tuple(outputs),
        quadratures=tuple(quadratures),
        angles=frozenset(c.position for c in coordinates if c.angle),
        second_order=motion,
    )


def _apply_lock(lock: Lock, mass: sp.Matrix, right: sp.Matrix, known_accelerations: Mapping[int, sp.Expr]) -> None:
    """Write the locked coordinate's acceleration as that of the other plus a remainder, which is zero while it is locked.

    With s = 1 the two equations of motion are added, so that the unknown torque between them drops out; with s = 0 nothing
    changes. The matrix stays symmetric and positive definite.
    """
    i, k, s = lock.index, lock.about, lock.switch
    if k is not None and k in known_accelerations:
        right[:, :] -= mass[:, i] * (s * known_accelerations[k])
    elif k is not None:
        mass[:, k] += s * mass[:, i]
        mass[k, :] += s * mass[i, :]
        right[k] += s * right[i]
    inertia = mass[i, i]
    mass[:, i] *= 1 - s
    mass[i, :] *= 1 - s
    mass[i, i] = inertia
    right[i] *= 1 - s


def acceleration(coordinate: Coordinate) -> sp.Symbol:
    """Return the symbol of a coordinate's acceleration, for outputs.

    Parameters
    ----------
    coordinate : Coordinate

    Returns
    -------
    sympy.Symbol
        Named ``<position>.acceleration``.
    """
    return sp.Symbol(f"{coordinate.position.name}.acceleration", real=True)


def reaction(coordinate: Coordinate) -> sp.Symbol:
    """The symbol of the force or torque that enforces a prescribed motion."""
    return sp.Symbol(f"{coordinate.position.name}.reaction", real=True)


def dissipated_power(parts: Sequence[Energies], coordinates: Sequence[Coordinate]) -> sp.Expr:
    """The power lost: ``v . dR/dv`` of the linear dampers, minus the power of applied forces on the side ``lost``."""
    damper_powers = [
        c.velocity * sp.diff(part.dissipation, c.velocity)
        for part in parts
        for symbols in (part.dissipation.free_symbols,)
        for c in coordinates
        if c.velocity in symbols
    ]
    return sp.Add(*damper_powers, *(-a.power for part in parts for a in part.applied_forces if a.energy_side == "lost"))


def supplied_power(parts: Sequence[Energies], coordinates: Sequence[Coordinate]) -> sp.Expr:
    """The power of all motors, those included that enforce a prescribed speed."""
    motors = [a.power for part in parts for a in part.applied_forces if a.energy_side == "supplied"]
    reaction_powers = [reaction(c) * c.velocity for c in coordinates if c.prescribed_velocity is not None]
    return sp.Add(*motors, *reaction_powers)
