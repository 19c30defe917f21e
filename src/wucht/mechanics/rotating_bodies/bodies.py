"""Rotating bodies on a linear carrier, from which averaged equations are derived."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from wucht.mechanics.phasors import Phasor
from wucht.system import TIME


@dataclass(frozen=True)
class Shaking:
    """A prescribed motion of the carrier: coordinate ``index`` moves by ``amplitude`` cos(``frequency`` t)."""

    index: int
    amplitude: sp.Expr
    frequency: sp.Expr


@dataclass(frozen=True)
class RotatingBodies:
    """n bodies on a linear carrier with m coordinates, all in the bodies' senses of rotation.

    heads: the index of the rotor that each body turns about, its index for a rotor; the first body is the main rotor. inertia:
    n x n, constant, without terms between bodies of different rotors. relative: n x n, dampers between the bodies of a rotor,
    rows that sum to zero. drive, losses: torques on each body as functions of its speed, in its sense and against it.
    mass, damping, stiffness: m x m. excitation: n rows of m phasors E_i. axis: 1 or 2 x m, the coordinates x, y of the main
    rotor's axis (or an angle) in those of the carrier. definitions: symbols in the others. weight: gravity turns body i with
    Re[weight_i exp(i theta_i)]. fixed_speed: the main rotor's, where it is prescribed. shaking: a prescribed motion of the
    carrier.
    """

    names: tuple[str, ...]
    heads: tuple[int, ...]
    inertia: sp.ImmutableMatrix
    relative: sp.ImmutableMatrix
    drive: tuple[Callable[[sp.Expr], sp.Expr], ...]
    losses: tuple[Callable[[sp.Expr], sp.Expr], ...]
    mass: sp.ImmutableMatrix
    damping: sp.ImmutableMatrix
    stiffness: sp.ImmutableMatrix
    excitation: tuple[tuple[Phasor, ...], ...]
    labels: tuple[str, ...]
    axis: sp.ImmutableMatrix
    definitions: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()
    weight: tuple[Phasor, ...] = ()
    fixed_speed: sp.Expr | None = None
    shaking: Shaking | None = None

    @cached_property
    def rotors(self) -> tuple[int, ...]:
        """The bodies that turn about no other."""
        return tuple(i for i, h in enumerate(self.heads) if h == i)

    @cached_property
    def free(self) -> list[int]:
        """The bodies whose speed is not prescribed."""
        return [i for i in range(len(self.names)) if i or self.fixed_speed is None]

    @cached_property
    def phases(self) -> tuple[sp.Symbol | None, ...]:
        """Phase of a body to its rotor, of a rotor to the main one, of the main rotor to the shaking (else None)."""
        return tuple(None if i == 0 and self.shaking is None else body_symbol(n, "phase") for i, n in enumerate(self.names))

    @cached_property
    def frequency(self) -> sp.Expr:
        """The common speed w: of the shaking, or of the main rotor."""
        return self.shaking.frequency if self.shaking is not None else self.speed(0)

    def speed(self, i: int) -> sp.Expr:
        """The speed of a body: a symbol, or the fixed speed of the main rotor."""
        return self.fixed_speed if i == 0 and self.fixed_speed is not None else body_symbol(self.names[i], "speed")

    def reference(self, i: int) -> int:
        """The body relative to which the phase of body i is measured: its rotor, and for a rotor the main one."""
        return self.heads[i] if self.heads[i] != i else 0

    def total_phase(self, i: int) -> sp.Expr:
        """The phase to the reference: alpha_i."""
        phase = self.phases[i] or sp.S.Zero
        return phase + self.total_phase(self.reference(i)) if i else phase

    def group(self, head: int) -> list[int]:
        """A rotor and the bodies that turn about it."""
        return [i for i, h in enumerate(self.heads) if h == head]


def absolute_torque(bodies: RotatingBodies, i: int, speed: sp.Expr) -> sp.Expr:
    """The torque on a body that depends on its absolute speed alone."""
    return bodies.drive[i](speed) - bodies.losses[i](speed)


def absolute_torque_slope(bodies: RotatingBodies, i: int, speed: sp.Expr) -> sp.Expr:
    """The derivative of that torque with respect to the speed."""
    v = sp.Dummy("v", real=True)
    return sp.diff(absolute_torque(bodies, i, v), v).xreplace({v: speed})


def fixed_speed_rate(bodies: RotatingBodies) -> sp.Expr:
    """The rate at which a prescribed speed changes."""
    return sp.diff(bodies.fixed_speed, TIME) if bodies.fixed_speed is not None else sp.S.Zero


def body_symbol(name: str, quantity: str) -> sp.Symbol:
    """The symbol ``name.quantity``."""
    return sp.Symbol(f"{name}.{quantity}", real=True)
