"""A machine's averaged equations in the symbols of a paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy as sp

from wucht.analysis.averaged_equations import AveragedEquations
from wucht.machines.machine import Machine
from wucht.mechanics.lagrange import acceleration, equations_of_motion
from wucht.system import substitute_definitions

Substitution = Mapping[sp.Symbol, sp.Expr]


def real(names: str) -> tuple[sp.Symbol, ...]:
    """Real symbols, always as a tuple."""
    return tuple(sp.Symbol(n, real=True) for n in names.split())


def path(name: str) -> sp.Symbol:
    """The program's symbol of a state or parameter."""
    return sp.Symbol(name, real=True)


@dataclass(frozen=True)
class Derived:
    """Averaged equations, and what leads from the program's symbols to the paper's.

    put: substitutions, one after the other. named: definitions of the system that the paper has a symbol for.
    """

    averaged_equations: AveragedEquations
    put: tuple[Substitution, ...] = ()
    named: Mapping[str, sp.Expr] = field(default_factory=dict)

    def __call__(self, expression: sp.Expr) -> sp.Expr:
        """An expression of the system with all definitions put in, in the paper's symbols."""
        pairs = [(s, self.named.get(s.name, e)) for s, e in self.averaged_equations.system.definitions]
        actual = substitute_definitions(expression, pairs)
        for mapping in self.put:
            actual = actual.xreplace(mapping)
        return actual

    def rate(self, state: str) -> sp.Expr:
        """The right-hand side of a state."""
        system = self.averaged_equations.system
        return self(system.derivatives[system.state_names.index(state)])

    def output(self, name: str) -> sp.Expr:
        """An output."""
        return self(self.averaged_equations.system.output(name).expression)

    def definition(self, name: str) -> sp.Expr:
        """What a symbol of the system means."""
        return self(sp.Symbol(name, real=True))

    def carrier(self, direction: str, theta: sp.Expr) -> sp.Expr:
        """The displacement Re[z exp(i theta)]."""
        z = [self.output(f"amplitude.{part}[{direction}]") for part in ("re", "im")]
        return z[0] * sp.cos(theta) - z[1] * sp.sin(theta)

    def fluctuation(self, body: str, theta: sp.Expr) -> sp.Expr:
        """psi = Re[P exp(2 i theta)]."""
        fast = self.averaged_equations.fast
        p = [self(fast.explicit(fast.output(f"ripple.{part}[{body}]").expression)) for part in ("re", "im")]
        return p[0] * sp.cos(2 * theta) - p[1] * sp.sin(2 * theta)


def full_rows(machine: Machine, put: Substitution) -> dict[str, sp.Expr]:
    """The full equations M a - F, by coordinate, with ``NAME.acceleration`` for the accelerations."""
    motion = equations_of_motion(machine.energies, machine.coordinates)
    rows = motion.mass * sp.Matrix([acceleration(c) for c in machine.coordinates]) - motion.forces
    return {c.position.name: row.xreplace(put) for c, row in zip(machine.coordinates, rows, strict=True)}
