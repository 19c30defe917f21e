"""What carriers have in common."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Self

import sympy as sp
from pydantic import Field

from wucht.errors import FieldError
from wucht.machines.parts.base import Body, Frame, Part, Point, si
from wucht.machines.parts.motion import SHAKING, PrescribedMotion
from wucht.machines.parts.tuning import Inertia
from wucht.mechanics.lagrange import Coordinate

_STRONGEST = 1e7  # m/s^2: in ultracentrifuges; bodies swing the faster, the stronger it is


class Support(Part):
    """A carrier: the coordinates of what bears the bodies, and where their axes are."""

    gravity: float = si("m/s^2", "acceleration of gravity", "g", 0.0, ge=-_STRONGEST, le=_STRONGEST)
    directions: str = Field("xy", description="directions in which the carrier moves")
    motion: PrescribedMotion | None = Field(None, description="prescribed motion, a table: `[machine.carrier.motion]`")

    @property
    def path(self) -> str:
        """``carrier``."""
        return "carrier"

    @property
    def labels(self) -> tuple[str, ...]:
        """What the coordinates are called: x, y, r, foundation."""
        return tuple(self.directions)

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Displacements, and the angle, from where the springs are free of force."""
        names = [d for d in self.labels if d != "foundation"]
        return tuple(Coordinate.named(f"carrier.{d}", f"carrier.v{d}", prescribed=self.prescribed(d)) for d in names)

    def component(self, name: str, direction: str) -> sp.Expr:
        """The symbol of a stiffness or damping in a direction."""
        value = getattr(self, name)
        if value is None:
            return sp.S.Zero
        return self.symbol(f"{name}.{direction}" if isinstance(value, tuple) else name)

    def placed(self) -> Frame:
        """The frame without bodies."""
        named = dict(zip(self.labels, self.coordinates(), strict=True))
        rotation = named["r"].velocity if "r" in named else sp.S.Zero
        return Frame(centre=Point.of(named), rotation=rotation, gravity=self.symbol("gravity"))

    def axis_at(self, position: tuple[sp.Expr, sp.Expr]) -> Point:
        """Position and velocity of an axis at a place (a, b) on the carrier: (x - b chi, y + a chi) where it turns by chi."""
        frame, (a, b) = self.placed(), position
        at = frame.centre
        if frame.rotation == 0:
            return at
        chi = self.coordinates()[self.labels.index("r")]
        vx, vy = at.vx - b * chi.velocity, at.vy + a * chi.velocity
        return Point(at.x - b * chi.position, at.y + a * chi.position, vx, vy)

    def check_body(self, body: Body) -> None:
        """Raises ``ValueError(field, sentence)`` where a body cannot be on this carrier."""
        if body.place() is not None:
            raise ValueError("position", f"allowed on a carrier 'xyr'; this one is {self.directions!r}")
        self.check_couple(body)

    def check_couple(self, body: Body) -> None:
        """Raises ``ValueError(field, sentence)`` for a couple unbalance, which only a carrier that tilts feels."""
        if body.couple() is not None:
            raise ValueError("couple_unbalance", f"allowed on a carrier 'r'; this one is {self.directions!r}")

    def bearing(self, bodies: Iterable[Body]) -> Self:
        """The carrier as it is with these bodies on it."""
        return self

    def tuned(self, inertia: Inertia) -> tuple[Self, str]:
        """The carrier with the springs and dampers that follow from natural frequencies, and these in words; empty if none do.

        inertia: in kg, or kg m^2, of all that moves with a coordinate.
        """
        return self, ""

    def prescribed(self, label: str) -> sp.Expr | None:
        """The velocity of a coordinate whose motion is given, None if it is free."""
        return self.motion.velocity() if self.motion is not None and self.motion.direction == label else None

    def shaking(self) -> tuple[sp.Symbol, sp.Symbol] | None:
        """Of the prescribed motion, unless it is a table."""
        return None if self.motion is None or self.motion.points is not None else SHAKING

    def start_positions(self) -> Mapping[str, float]:
        """Displacements at t = 0 of the coordinates whose motion is given, by label."""
        return {self.motion.direction: self.motion.start()} if self.motion is not None else {}

    def check_motion(self) -> None:
        """The motion is in a direction that the carrier has. Raises ``ValueError(field, sentence)``."""
        if self.motion is not None and self.motion.direction not in self.labels:
            sentence = f"must be a direction of the carrier: {', '.join(self.labels) or 'it has none'}"
            raise FieldError("motion", sentence, code="direction")


def is_negative(value: float | tuple[float, ...] | None) -> bool:
    """Whether a stiffness or damping, or one of a pair, is below zero."""
    return any(v < 0 for v in (value if isinstance(value, tuple) else (value or 0.0,)))
