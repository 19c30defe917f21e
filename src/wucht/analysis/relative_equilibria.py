"""Steady rotation as an equilibrium: the full equations of a machine in the frame that turns with its main rotor.

If a machine is invariant under rotation as a whole (an isotropic carrier, no gravity, no prescribed motion, all rotors in
one sense), the rotor's angle drops out. Motions with steady phases are then equilibria of one state less, their stability is
that of a matrix, and branches of them are followed as those of any equilibria. In other machines they are periodic orbits:
``synchronous_motion``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from wucht.analysis.vibration import unbalances
from wucht.disk_cache import derived_once
from wucht.errors import InputError, RunError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.machines.structure import Structure
from wucht.mechanics.corotating import Turning, corotating, refuse_oriented
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.flow.jacobian import Jacobian
from wucht.system import System

_MOST_STEPS = 30
_TOLERANCE = 1e-11  # of the states' sizes: Newton's last step
_SINGULAR = 1e-12  # share of the largest singular value below which there is a family of equilibria
_FAMILY_RESIDUAL = 1e-8  # of the fastest rate: a larger residual along a family means that there is none
_HALVINGS = 10


@dataclass(frozen=True)
class RelativeEquilibrium:
    """A steady rotation.

    Attributes
    ----------
    state : ndarray, (n-1,)
        State of the System in the turning frame.
    speed : float
        Speed of the main rotor, signed: all bodies turn with it.
    eigenvalues : ndarray of complex, (n-1,)
        Eigenvalues of the full equations linearised about it, per unit of time, the fastest growing first.
    neutral : int
        Dimension of the family it belongs to: as many eigenvalues are zero and do not decide on stability.
    """

    state: np.ndarray
    speed: float
    eigenvalues: np.ndarray
    neutral: int

    @property
    def exponents(self) -> np.ndarray:
        """The eigenvalues (n-1-neutral,) across the family, the fastest growing first."""
        zero = np.argsort(np.abs(self.eigenvalues), kind="stable")[: self.neutral]
        return np.delete(self.eigenvalues, zero)


@dataclass(frozen=True)
class RelativeEquilibria:
    """The relative equilibria of a machine at its parameter values, contacts on tracks neglected, all bodies released.

    system: in the turning frame, see ``mechanics.corotating``; its parameters are those of the machine except gravity, which
    is zero.
    """

    machine: Machine
    system: System

    @classmethod
    def of(cls, machine: Machine, senses: Mapping[str, float] | None = None) -> RelativeEquilibria:
        """Relative equilibria of a machine whose bodies turn in these senses (+1, -1 by name; by default those of the drives).

        Raises ``InputError`` for a machine whose steady rotation is no equilibrium in any frame, with the reason.
        """
        bare = without_contacts(machine)
        try:
            return cls(bare, _turning_frame_system(bare, senses))
        except WuchtError as error:
            reason = f"steady rotation is not an equilibrium in a frame that turns with {machine.rotor.name}: {error}"
            raise InputError("machine", None, reason) from None

    @property
    def values(self) -> dict[str, float]:
        """The parameters' values by name."""
        return {name: self.machine.values[name] for name in self.system.parameter_names}

    @cached_property
    def _rows(self) -> tuple[list[int], list[int], list[int], int]:
        """Indices in the machine's state: of x and its rate, of y and its rate, of the other bodies' angles; of the rotor's."""
        turning, row = turning_of(self.machine.structure), self.machine.row
        pairs = [[row(s) for s in (c.position, c.velocity)] for c in turning.plane] or [[], []]
        return pairs[0], pairs[1], [row(c.position) for c in turning.angles[1:]], row(turning.angles[0].position)

    @property
    def frame_symbols(self) -> dict[sp.Symbol, sp.Expr]:
        """What the symbols of the machine's equations are in the turning frame, where they are not the same: the main rotor's
        angle is zero there, and gravity, if it is left out."""
        turning, parameters = turning_of(self.machine.structure), set(self.system.parameters)
        left_out = [p for p in self.machine.system.parameters if p not in parameters]
        return {**turning.frame_symbols, **dict.fromkeys([turning.angles[0].position, *left_out], sp.S.Zero)}

    def to_turning_frame(self, states: np.ndarray) -> np.ndarray:
        """States (n-1,) or (n-1, N) in the turning frame, from those of the machine's equations (n,) or (n, N)."""
        x, y, angles, main = self._rows
        values = np.array(states, float)
        z = (values[x] + 1j * values[y]) * np.exp(-1j * values[main])
        values[x], values[y] = z.real, z.imag
        values[angles] -= values[main]
        return np.delete(values, main, axis=0)

    def to_fixed_frame(self, states: np.ndarray, angle: float | np.ndarray) -> np.ndarray:
        """The way back: states (n,) or (n, N), the main rotor's angle being a number or (N,)."""
        x, y, angles, main = self._rows
        rest = np.insert(np.asarray(states, float), main, angle, axis=0)
        z = (rest[x] + 1j * rest[y]) * np.exp(1j * np.asarray(angle))
        rest[x], rest[y] = z.real, z.imag
        rest[angles] += angle
        return rest

    def speed(self, state: np.ndarray) -> float:
        """The main rotor's speed, signed, in a state (n-1,) of the turning frame."""
        coordinate = self.machine.rotor.coordinate
        if coordinate.prescribed_velocity is not None:
            return float(self.machine.prescribed_speed(coordinate, 0.0)[0])
        return float(state[self.system.state_names.index(coordinate.velocity.name)])

    def sizes(self, state: np.ndarray) -> np.ndarray:
        """Characteristic size (n-1,) of a change of each state, near a relative equilibrium.

        A phase by 1 rad, a speed by that of the rotor, the carrier by its displacement, or U/M of all unbalances together.
        """
        x, y, _, main = self._rows
        speed, mass = abs(self.speed(state)) or 1.0, float(np.abs(self.machine.matrices[0]).max(initial=0.0))
        away = float(np.abs(unbalances(self.machine)).sum()) / mass if mass else 1.0
        if x:
            away = max(away, float(np.hypot(*self.to_fixed_frame(state, 0.0)[[x[0], y[0]]])))
        size = [1.0 if c.angle else away for c in self.machine.coordinates]
        size += [speed * (1.0 if c.angle else away) for c in self.machine.coordinates if c.prescribed_velocity is None]
        size += self.machine.evaluate(*(internal_state.size for internal_state in self.machine.internal))
        return np.delete(np.array(size), main)

    def linear(self) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """The rates f (n-1,) and df/dx (n-1, n-1) as a function of a state (n-1,)."""
        return _system_jacobian(self.system).with_parameters(self.system.values(self.values))

    def find_near(self, guess: np.ndarray, neutral: int = 0) -> RelativeEquilibrium:
        """The relative equilibrium near a state (n-1,) of the turning frame, by Newton's method.

        neutral: the dimension of the family that it belongs to, as of more than two bodies that compensate; the nearest
        of its members is returned. Raises ``RunError`` where there is none.
        """
        linear, x = self.linear(), np.array(guess, float)
        sizes, rate = self.sizes(x), abs(self.speed(x)) or 1.0
        for _ in range(_MOST_STEPS):
            f, f_x = linear(x)
            if not (np.isfinite(f).all() and np.isfinite(f_x).all()):
                break
            left_vectors, values, right_vectors = np.linalg.svd(f_x * sizes / (sizes[:, None] * rate))
            rank = len(x) - neutral
            if values[rank - 1] <= _SINGULAR * values[0]:
                raise RunError(
                    f"the equations are singular here: there is a family of a dimension above {neutral}", code="singular"
                )
            step = -right_vectors[:rank].T @ ((left_vectors[:, :rank].T @ (f / (sizes * rate))) / values[:rank])
            if np.abs(step).max() <= _TOLERANCE:
                if np.abs(f / (sizes * rate)).max() > _FAMILY_RESIDUAL * values[0]:
                    raise RunError(
                        f"there is no steady rotation here: near this state there is no family of dimension {neutral}",
                        code="no-family",
                    )
                return self.equilibrium_at(x + step * sizes, neutral)
            share, residual = 1.0, np.linalg.norm(f / sizes)
            for _ in range(_HALVINGS):
                if np.linalg.norm(linear(x + share * step * sizes)[0] / sizes) < residual:
                    break
                share /= 2
            x = x + share * step * sizes
        raise RunError(
            f"no convergence to a steady rotation: {_MOST_STEPS} steps of Newton's method were not enough; start nearer"
        )

    def equilibrium_at(self, state: np.ndarray, neutral: int = 0) -> RelativeEquilibrium:
        """A state (n-1,) that is known to be a relative equilibrium, with its eigenvalues."""
        eigenvalues = np.linalg.eigvals(self.linear()(state)[1])
        order = np.lexsort((-eigenvalues.imag, -eigenvalues.real))
        return RelativeEquilibrium(state, self.speed(state), eigenvalues[order].astype(complex), neutral)

    def branches_over(
        self, parameter: str, bounds: tuple[float, float], near: RelativeEquilibrium, steps: Steps | None = None
    ) -> EquilibriumContinuation:
        """The branches of relative equilibria over a parameter (its path), with folds and Hopf points of the full equations.

        bounds: lowest and highest value. near: one of them, whose sizes scale the states. Raises ``InputError`` for an
        unknown parameter, ``RunError`` for a member of a family, which has no single branch over one parameter.
        """
        if parameter not in self.system.parameter_names:
            explanation = f"must be a parameter of the equations: {', '.join(self.system.parameter_names)}"
            raise InputError("parameter", parameter, explanation)
        if near.neutral:
            family = f"a family of dimension {near.neutral}"
            raise RunError(f"{family} has no single branch over {parameter}: follow an isolated state", code="no-single-branch")
        sizes = self.sizes(near.state).tolist()
        scale = dict(zip(self.system.state_names, sizes, strict=True)) | {parameter: bounds[1] - bounds[0]}
        fixed_values = {name: value for name, value in self.values.items() if name != parameter}
        return EquilibriumContinuation(
            EquilibriumEquations.from_system(self.system, [parameter], fixed_values, scale), bounds, steps or Steps()
        )


def without_contacts(machine: Machine) -> Machine:
    """The machine without contacts on tracks, all bodies released."""
    released_bodies = tuple(replace(b, release=None) for b in machine.bodies)
    return machine.with_fields(energies=machine.without_contacts, tracks=(), bodies=released_bodies)


def turning_of(structure: Structure) -> Turning:
    """The coordinates of a machine that change when it is turned as a whole."""
    plane = tuple(c for label, c in zip(structure.labels, structure.carrier, strict=True) if label in ("x", "y"))
    other_bodies = [b for b in structure.bodies if b is not structure.rotor]
    return Turning(plane, tuple(b.coordinate for b in (structure.rotor, *other_bodies)))


def _turning_frame_system(machine: Machine, senses: Mapping[str, float] | None) -> System:
    """The System in the turning frame. Raises ``WuchtError`` where there is none, with the reason."""
    if machine.schedules:
        raise WuchtError(f"{machine.schedules[0].parameter} changes over time")
    turn = {r.name: sense_of(machine, r) if senses is None else senses[r.name] for r in machine.rotors}
    opposing = [name for name, sense in turn.items() if sense != turn[machine.rotor.name]]
    if opposing:
        raise WuchtError(f"{opposing[0]} turns against it")
    prescribed_bodies = [
        b.name for b in machine.bodies if b is not machine.rotor and b.coordinate.prescribed_velocity is not None
    ]
    if prescribed_bodies:
        raise WuchtError(f"the speed of {prescribed_bodies[0]} is prescribed")
    gravity = sp.sympify(machine.frame.gravity)
    weightless = gravity.is_Symbol and machine.numbers[gravity] == 0
    turning_system = _corotating(machine.structure, (gravity,) if weightless else ())
    if isinstance(turning_system, str):
        raise WuchtError(turning_system)
    return turning_system


@lru_cache(maxsize=64)
@derived_once
def _corotating(structure: Structure, zero: tuple[sp.Symbol, ...]) -> System | str:
    """The System, or the reason why there is none: returned, since an error would not be cached."""
    turning = turning_of(structure)
    try:
        refuse_oriented(structure.energies, turning, zero)
    except WuchtError as error:
        return str(error)
    return corotating(replace(structure.system, outputs=(), quadratures=()), turning, zero)


@lru_cache(maxsize=64)
@derived_once
def _system_jacobian(system: System) -> Jacobian:
    return Jacobian.of(system)
