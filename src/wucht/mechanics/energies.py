"""What a part stores, loses and is given."""

from __future__ import annotations

from dataclasses import dataclass, fields

import sympy as sp


@dataclass(frozen=True)
class Applied:
    """A force or torque and the rate on which it works: the applied power is ``force * rate``.

    ``booked`` says on which side of the energy balance its work stands: ``"supplied"`` (a motor) or ``"lost"`` (a damper that
    has no dissipation function because it is not reciprocal). ``of_drive``: a loss on the way from a motor to its body, which
    ends when the motor is switched off.
    """

    force: sp.Expr
    rate: sp.Expr
    name: str = ""
    booked: str = "supplied"
    of_drive: bool = False

    @property
    def power(self) -> sp.Expr:
        """Force times rate."""
        return self.force * self.rate


@dataclass(frozen=True)
class Energies:
    """The four formulas of a part, as on paper, in coordinates, velocities and parameters.

    kinetic: T. potential: V. dissipation: Rayleigh's function R, half the power lost in linear dampers.
    applied: forces with the rates on which they work.
    """

    kinetic: sp.Expr = sp.S.Zero
    potential: sp.Expr = sp.S.Zero
    dissipation: sp.Expr = sp.S.Zero
    applied: tuple[Applied, ...] = ()

    def __add__(self, other: Energies) -> Energies:
        """The energies of both."""
        return Energies(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(Energies)))
