"""Energies of a part: stored, dissipated and supplied."""

from __future__ import annotations

from dataclasses import dataclass, fields

import sympy as sp


@dataclass(frozen=True)
class AppliedForce:
    """A force or torque and the rate on which it works: the applied power is ``force * rate``.

    Parameters
    ----------
    force : sympy.Expr
        In N, or N m.
    rate : sympy.Expr
        A combination of velocities, in m/s or rad/s.
    name : str, optional
    energy_side : {"supplied", "lost"}, optional
        The side of the energy balance to which its work belongs: ``"supplied"`` (a motor) or ``"lost"`` (a damper that has no
        dissipation function because it is not reciprocal).
    of_drive : bool, optional
        A loss on the way from a motor to its body, which ends when the motor is switched off.
    """

    force: sp.Expr
    rate: sp.Expr
    name: str = ""
    energy_side: str = "supplied"
    of_drive: bool = False

    @property
    def power(self) -> sp.Expr:
        """Force times rate."""
        return self.force * self.rate


@dataclass(frozen=True)
class StateDescription:
    """Description of an internal state of a part: name after the part's path, SI unit, long name, symbol in equations."""

    name: str
    unit: str
    what: str
    letter: str

    def at(self, path: str) -> sp.Symbol:
        """The symbol of the state in a part of that path."""
        return sp.Symbol(f"{path}.{self.name}", real=True)


@dataclass(frozen=True)
class InternalState:
    """An internal state of a part, of first order, zero at the start: the integrator of a controller, the strain of a friction.

    rate: d state/dt, in coordinates, velocities, parameters and internal states. description: name, unit and symbol. size: its
    order of magnitude, in parameters. steady: its value in steady rotation while the carrier rests.
    """

    state: sp.Symbol
    rate: sp.Expr
    description: StateDescription
    size: sp.Expr
    steady: sp.Expr = sp.S.Zero

    @property
    def path(self) -> str:
        """The path of the part."""
        return str(self.state.name).removesuffix(f".{self.description.name}")

    @property
    def change(self) -> sp.Symbol:
        """The symbol of the rate in formulas: needed for the power of a force that moves no coordinate."""
        return sp.Symbol(f"{self.state.name}.rate", real=True)


@dataclass(frozen=True)
class Energies:
    """The four formulas of a part, as on paper, in coordinates, velocities and parameters.

    The energies of several parts are added with ``+``, or given as a list to ``equations_of_motion``.

    Parameters
    ----------
    kinetic : sympy.Expr, optional
        T, quadratic in the velocities.
    potential : sympy.Expr, optional
        V.
    dissipation : sympy.Expr, optional
        Rayleigh's function R, half the power lost in linear dampers.
    applied_forces : tuple of AppliedForce, optional
        Forces with the rates on which they work.
    internal_states : tuple of InternalState, optional
        Of the part, of first order.
    nonlinear : str, optional
        Its forces on the carrier that are not proportional to displacements and velocities, as text; a linear carrier neglects
        them.
    """

    kinetic: sp.Expr = sp.S.Zero
    potential: sp.Expr = sp.S.Zero
    dissipation: sp.Expr = sp.S.Zero
    applied_forces: tuple[AppliedForce, ...] = ()
    internal_states: tuple[InternalState, ...] = ()
    nonlinear: str = ""

    @property
    def formulas(self) -> tuple[sp.Expr, ...]:
        """The formulas of energies and forces."""
        return self.kinetic, self.potential, self.dissipation, *(e for a in self.applied_forces for e in (a.force, a.rate))

    @property
    def symbols(self) -> set[sp.Symbol]:
        """All symbols in the formulas of energies and forces."""
        return set().union(*(sp.sympify(e).free_symbols for e in self.formulas))

    def __add__(self, addend: Energies) -> Energies:
        """The sum of two energies."""
        return Energies(*(getattr(self, f.name) + getattr(addend, f.name) for f in fields(Energies)))
