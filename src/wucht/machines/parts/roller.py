"""The roller: a ball or cylinder that rolls without slip in a circular track of another body."""

from __future__ import annotations

from typing import ClassVar

import sympy as sp
from pydantic import Field

from wucht.machines.parts.base import Body, Frame, si
from wucht.mechanics.energies import Energies, total


class Roller(Body):
    """A ball or roller on a track of radius R: 000 (3)-(12). Its centre runs on the circle R - r.

    Rolling couples it to ``about``: its spin is (R phi_0' - (R - r) phi') / r, so its energy holds both speeds.
    """

    kind: ClassVar[str] = "roller"
    not_yet: ClassVar[frozenset[str]] = Body.not_yet | {"track", "diameter", "restitution"}

    about: str = Field(description="name of the body turned about")
    mass: float = si("kg", "mass", "m", gt=0)
    track_radius: float = si("m", "track radius", "R", gt=0)
    radius: float = si("m", "radius", "r", gt=0)
    shape_factor: float = si("", "shape factor (2/5 ball, 1/2 cylinder, 1 tube)", "mu", 0.4, ge=0, le=1)
    damping: float = si("N m s", "damping", "beta", 0.0, ge=0)

    def check(self) -> None:
        """The roller fits into its track."""
        if self.radius >= self.track_radius:
            raise ValueError("radius", f"allowed is less than the track radius of {self.track_radius:g} m")

    def moment(self) -> sp.Expr:
        """The unbalance m (R - r)."""
        return self.symbol("mass") * (self.symbol("track_radius") - self.symbol("radius"))

    def energies(self, frame: Frame) -> Energies:
        """000 (5): carried mass, m eps^2 phi'^2/2, and mu m (R phi_0' - eps phi')^2/2 of the rolling; 000 (12) is lost."""
        m, track, r, mu, beta = self.symbols("mass", "track_radius", "radius", "shape_factor", "damping")
        eps = track - r
        w, w0 = frame.speed(self.name), frame.speed(self.about)
        own = Energies(
            kinetic=m * eps**2 * w**2 / 2 + mu * m * (track * w0 - eps * w) ** 2 / 2,
            dissipation=beta * (w - w0) ** 2 / 2,
        )
        return total((frame.carried(m, self.moment(), self.name), own))
