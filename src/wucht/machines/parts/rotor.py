"""The rotor: an unbalanced body that turns on the carrier."""

from __future__ import annotations

from typing import ClassVar

import sympy as sp

from wucht.machines.parts.base import Body, Frame, si
from wucht.mechanics.energies import Energies, total


class Rotor(Body):
    """An unbalanced rotor, 002 (3.28)-(3.29). Its unbalance is ``mass * eccentricity``, or given directly."""

    kind: ClassVar[str] = "rotor"
    not_yet: ClassVar[frozenset[str]] = Body.not_yet | {"position", "couple_unbalance"}

    mass: float = si("kg", "mass", "M", gt=0)
    eccentricity: float | None = si("m", "eccentricity", "e", None, ge=0)
    unbalance: float | None = si("kg m", "unbalance", "U", None, ge=0)
    inertia: float = si("kg m^2", "moment of inertia about its axis of rotation", "J", gt=0)
    bearing_damping: float = si("N m s", "bearing damping", "b_L", 0.0, ge=0)

    def check(self) -> None:
        """One of eccentricity and unbalance; the inertia about the axis is at least m e^2."""
        if (self.eccentricity is None) == (self.unbalance is None):
            raise ValueError("eccentricity", "needed is either eccentricity or unbalance (0 for a balanced rotor)")
        e = self.eccentricity if self.eccentricity is not None else (self.unbalance or 0.0) / self.mass
        least = self.mass * e * e
        if self.inertia < least * (1 - 1e-12):
            raise ValueError(
                "inertia",
                f"allowed is at least m e^2 = {least:.6g} kg m^2, because it is the inertia about the axis of rotation, "
                "not about the centre of mass",
            )

    def moment(self) -> sp.Expr:
        """The unbalance U = m e."""
        m, e, u = self.symbols("mass", "eccentricity", "unbalance")
        return u if self.unbalance is not None else m * e

    def energies(self, frame: Frame) -> Energies:
        """Carried mass with unbalance, J phi'^2/2, and b_L phi'^2/2 lost in the bearing."""
        m, j, b = self.symbols("mass", "inertia", "bearing_damping")
        w = frame.speed(self.name)
        return total((frame.carried(m, self.moment(), self.name), Energies(kinetic=j * w**2 / 2, dissipation=b * w**2 / 2)))
