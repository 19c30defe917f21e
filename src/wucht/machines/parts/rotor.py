"""The rotor: an unbalanced body that turns on the carrier."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import sympy as sp
from pydantic import Field, model_validator

from wucht.errors import FieldError
from wucht.machines.parts.base import SI, Body, Frame, si
from wucht.machines.parts.bearing import Bearing
from wucht.machines.parts.nameplate import Nameplate
from wucht.mechanics.energies import Energies
from wucht.schema import Composite, Unit, composite

_SHEET = ("working_moment", "centrifugal_force")  # the keys of a data sheet from which the unbalance follows


class CentrifugalForce(Nameplate):
    """The centrifugal force of an exciter at a speed, by its data sheet: F = U w^2."""

    force: SI[float] = si("N", "centrifugal force", "F", gt=0, help="largest centrifugal force of the exciter at this speed")
    speed: SI[float] = si("rad/s", "speed", "n", gt=0, help="speed at which the data sheet states the force")

    @property
    def unbalance(self) -> float:
        """The unbalance in kg m."""
        return self.force / self.speed**2


class Rotor(Body):
    """An unbalanced rotor. Its unbalance is ``mass * eccentricity``, or given directly: Drozdetskaya (3.28)-(3.29).

    Of an exciter it may follow from the data sheet: half the working moment, which is the stroke times the mass that
    vibrates, 2 m r (NetterVibration, Formelsammlung, (1) and (4): F/N = 54.84 M/(kg cm) (n/1000 rpm)^2); or the centrifugal
    force at a speed; times the setting of its weights, 0 where they are opposite to each other and 100 % where they cover.
    """

    kind = "rotor"

    mass: SI[float] = si("kg", "mass", "M", gt=0, help="mass of the rotor with its unbalance")
    eccentricity: SI[float | None] = si(
        "m", "eccentricity", "e", default=None, ge=0, help="distance of the centre of mass from the axis; or give `unbalance`"
    )
    unbalance: SI[float | None] = si(
        "kg m", "unbalance", "U", default=None, ge=0, help="mass times eccentricity, given directly: the static moment m r"
    )
    working_moment: SI[float | None] = si("kg m", "working moment", "M_A", default=None, gt=0, help=(
        "instead of `unbalance`, working moment 2 m r of an exciter, by its data sheet: twice the unbalance"
    ))  # fmt: skip
    centrifugal_force: Composite[CentrifugalForce | None] = composite(
        default=None, description="instead of `unbalance`, { force, speed } of an exciter, by its data sheet"
    )
    setting: SI[float | None] = si("", "setting of the weights", "s", default=None, gt=0, le=1, help=(
        "part of `working_moment` or `centrifugal_force` to which the exciter's weights are set, as `\"70 %\"`; by default all"
    ))  # fmt: skip
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

    origin: str = Field(default="", exclude=True)

    @model_validator(mode="before")
    @classmethod
    def _unbalance_of_the_data_sheet(cls, table: Any) -> Any:
        ways = [key for key in _SHEET if isinstance(table, Mapping) and table.get(key) is not None]
        if not ways:
            return table
        for key in ("unbalance", "eccentricity", "couple_unbalance", *ways[1:]):
            if table.get(key) is not None:
                raise FieldError(key, f"not allowed beside {ways[0]}, from which the unbalance follows", code="either-or")
        try:
            unbalance, origin = _stated_unbalance(table)
        except ValueError:  # which the field reports
            return table
        return {k: v for k, v in table.items() if k not in (*_SHEET, "setting")} | {"unbalance": unbalance, "origin": origin}

    def check(self) -> None:
        """Check for one of eccentricity, unbalance and couple_unbalance, and an inertia about the axis of at least m e^2."""
        if (self.eccentricity, self.unbalance, self.couple_unbalance).count(None) != 2:
            options = "either eccentricity or unbalance (0 for a balanced rotor), or couple_unbalance on a carrier 'r'"
            raise ValueError("eccentricity", f"give {options}; of an exciter, its working_moment or centrifugal_force")
        if self.setting is not None:
            raise ValueError("setting", "allowed only beside working_moment or centrifugal_force, of which it is a part")
        e = self.eccentricity if self.eccentricity is not None else (self.unbalance or 0.0) / self.mass
        least = self.mass * e * e
        if self.inertia < least * (1 - 1e-12):
            reason = "because it is the inertia about the axis of rotation, not about the centre of mass"
            twice = "" if self.unbalance is None else "; of a data sheet's working moment 2 m r write working_moment"
            raise ValueError("inertia", f"must be at least m e^2 = {least:.6g} kg m^2, {reason}{twice}")
        if self.bearing is not None and self.couple_unbalance is not None:
            raise ValueError("bearing", "not allowed: a couple unbalance has no force in the plane that the bearing would take")

    def derivation_notes(self) -> tuple[str, ...]:
        """Return the origin of the unbalance, where it follows from a data sheet."""
        return (f"{self.name}: unbalance {self.unbalance:.5g} kg m, {self.origin}",) if self.origin else ()

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


def _stated_unbalance(table: Mapping[str, Any]) -> tuple[float, str]:
    """Return the unbalance in kg m that a data sheet states, and its origin as text. Raises ``ValueError``."""
    setting = Unit("", "setting").parse_positive(1.0 if table.get("setting") is None else table["setting"])
    if setting > 1:
        raise ValueError("more than all of the weights")
    part = "" if table.get("setting") is None else f"{100 * setting:.4g} % of "
    if table.get("working_moment") is not None:
        moment = Unit("kg m", "working moment").parse_positive(table["working_moment"])
        return setting * moment / 2, f"half of the working moment, {part}{moment:.5g} kg m"
    sheet = CentrifugalForce.model_validate(table["centrifugal_force"])
    force = f"{part}{sheet.force / 1e3:.5g} kN at {sheet.speed * 30 / math.pi:.5g} rpm"
    return setting * sheet.unbalance, f"from the centrifugal force, {force}"
