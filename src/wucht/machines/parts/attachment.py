"""Attachments of the carrier beside its springs: dampers, stops, a load that lies on it."""

from __future__ import annotations

import sympy as sp
from pydantic import Field

from wucht.machines.parts.base import SI, Frame, Part, si


class Attachment(Part):
    """A part between the carrier and the ground, or on the carrier."""

    name: str = Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$", title="name", description="name in parameters and results")
    at: SI[tuple[float, float] | None] = si("m", "place on the carrier, from its centre of mass", "a", default=None, help=(
        "place on a carrier that turns, from its centre of mass"
    ))  # fmt: skip

    @property
    def path(self) -> str:
        """The attachment's name."""
        return self.name

    def place(self) -> tuple[sp.Expr, sp.Expr] | None:
        """Return its position on the carrier, None for the centre."""
        return None if self.at is None else (self.symbol("at.x"), self.symbol("at.y"))

    def motion(self, frame: Frame) -> tuple[sp.Expr, ...]:
        """Return the velocities on which it acts."""
        at = frame.axis(self.name)
        return at.vx, at.vy


class LineAttachment(Attachment):
    """An attachment that acts along a line: on the small displacement of its place on the carrier in direction ``angle``."""

    angle: SI[float] = si("rad", "direction of its line, counter-clockwise from +x", "gamma")

    def line_motion(self, frame: Frame) -> tuple[sp.Expr, sp.Expr]:
        """Return displacement and velocity of its place on the carrier along the line."""
        at, gamma = frame.axis(self.name), self.symbol("angle")
        return at.x * sp.cos(gamma) + at.y * sp.sin(gamma), at.vx * sp.cos(gamma) + at.vy * sp.sin(gamma)

    def doubts_at(self, rest: float) -> tuple[str, ...]:
        """Return warnings where the carrier, without this part, rests at a displacement along the line, in m."""
        return ()

    def motion(self, frame: Frame) -> tuple[sp.Expr, ...]:
        """Return the velocity along the line."""
        return (self.line_motion(frame)[1],)
