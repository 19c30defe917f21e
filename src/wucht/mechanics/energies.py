"""What a part stores, loses and is given."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import sympy as sp


@dataclass(frozen=True)
class Applied:
    """A force or torque and the rate on which it works: the applied power is ``force * rate``.

    ``booked`` says on which side of the energy balance its work stands: ``"supplied"`` (a motor) or ``"lost"`` (a damper that
    has no dissipation function because it is not reciprocal).
    """

    force: sp.Expr
    rate: sp.Expr
    name: str = ""
    booked: str = "supplied"

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
        return total((self, other))


def total(parts: Iterable[Energies]) -> Energies:
    """The energies of a machine: the sum over its parts."""
    energies = tuple(parts)
    return Energies(
        kinetic=sp.Add(*(e.kinetic for e in energies)),
        potential=sp.Add(*(e.potential for e in energies)),
        dissipation=sp.Add(*(e.dissipation for e in energies)),
        applied=tuple(a for e in energies for a in e.applied),
    )
