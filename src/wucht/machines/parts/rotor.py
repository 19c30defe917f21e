"""The rotor: an unbalanced body that turns on the carrier."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from wucht.machines.parts.base import SI, Body, Frame, si
from wucht.machines.parts.bearing import Bearing
from wucht.mechanics.energies import Energies
from wucht.schema import Composite, composite


class Rotor(Body):
    """An unbalanced rotor. Its unbalance is ``mass * eccentricity``, or given directly: Drozdetskaya (3.28)-(3.29)."""

    kind = "rotor"

    mass: SI[float] = si("kg", "mass", "M", gt=0, help="mass of the rotor with its unbalance")
    eccentricity: SI[float | None] = si(
        "m", "eccentricity", "e", default=None, ge=0, help="distance of the centre of mass from the axis; or give `unbalance`"
    )
    unbalance: SI[float | None] = si(
        "kg m", "unbalance", "U", default=None, ge=0, help="mass times eccentricity, given directly"
    )
    couple_unbalance: SI[float | None] = si(
        "kg m^2",
        "couple unbalance",
        "D",
        default=None,
        ge=0,
        help="couple unbalance m e a of 001 (10), on a carrier that only turns",
    )
    inertia: SI[float] = si("kg m^2", "moment of inertia about its axis of rotation", "J", gt=0)
    bearing_damping: SI[float] = si(
        "N m s", "bearing damping", "b_L", default=0.0, ge=0, help="viscous damping of the bearings"
    )
    position: SI[tuple[float, float] | None] = si(
        "m", "position", "a", default=None, help="position of its axis on a carrier that turns"
    )
    bearing: Composite[Bearing | None] = composite(
        default=None, description='rating of its bearing for the life after ISO 281, { C = "45 kN", p = 3 }'
    )

    def check(self) -> None:
        """Check for one of eccentricity, unbalance and couple_unbalance, and an inertia about the axis of at least m e^2."""
        if (self.eccentricity, self.unbalance, self.couple_unbalance).count(None) != 2:
            options = "either eccentricity or unbalance (0 for a balanced rotor), or couple_unbalance on a carrier 'r'"
            raise ValueError("eccentricity", f"give {options}")
        e = self.eccentricity if self.eccentricity is not None else (self.unbalance or 0.0) / self.mass
        least = self.mass * e * e
        if self.inertia < least * (1 - 1e-12):
            reason = "because it is the inertia about the axis of rotation, not about the centre of mass"
            raise ValueError("inertia", f"must be at least m e^2 = {least:.6g} kg m^2, {reason}")
        if self.bearing is not None and self.couple_unbalance is not None:
            raise ValueError("bearing", "not allowed: a couple unbalance has no force in the plane that the bearing would take")

    def moment(self) -> sp.Expr:
        """The unbalance U = m e."""
        m, e, u = self.symbols("mass", "eccentricity", "unbalance")
        if self.unbalance is not None:
            return u
        return m * e if self.eccentricity is not None else sp.S.Zero

    def arms(self) -> Mapping[str, sp.Expr]:
        """The eccentricity."""
        m, e, u = self.symbols("mass", "eccentricity", "unbalance")
        if self.couple_unbalance is not None:
            return {}
        return {self.name: e if self.unbalance is None else u / m}

    def couple(self) -> sp.Expr | None:
        """The couple unbalance, if it is given."""
        return None if self.couple_unbalance is None else self.symbol("couple_unbalance")

    def axis_inertia(self) -> sp.Expr:
        """The inertia."""
        return self.symbol("inertia")

    def place(self) -> tuple[sp.Expr, sp.Expr] | None:
        """The position, if it is given."""
        return None if self.position is None else (self.symbol("position.x"), self.symbol("position.y"))

    def energies(self, frame: Frame) -> Energies:
        """Carried mass with unbalance, J phi'^2/2, b_L phi'^2/2 lost in the bearing; -D phi' chi' sin phi: 001 (10)-(11)."""
        m, j, b, couple = self.symbols("mass", "inertia", "bearing_damping", "couple_unbalance")
        w = frame.speed(self.name)
        body_energies = Energies(kinetic=j * w**2 / 2, dissipation=b * (w - frame.rotation) ** 2 / 2)
        if self.couple_unbalance is not None:
            body_energies += Energies(kinetic=-couple * w * frame.tilt * sp.sin(frame.angle(self.name)))
        return frame.carried_energies(m, self.moment(), self.name) + body_energies
