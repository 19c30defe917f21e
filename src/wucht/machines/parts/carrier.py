"""The carrier: what only translates, on springs and dampers."""

from __future__ import annotations

from typing import ClassVar, Literal

import sympy as sp

from wucht.machines.parts.base import Frame, Part, si
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate


class Carrier(Part):
    """A mass that moves in x, y or both, held by linear springs and dampers; y points up, against gravity.

    Stiffness and damping are one number (isotropic) or a pair [x, y]. Bodies add their own mass.
    """

    kind: ClassVar[str] = "carrier"
    not_yet: ClassVar[frozenset[str]] = frozenset(
        {"inertia", "rotation_stiffness", "rotation_damping", "mounts", "motion", "foundation"}
    )

    mass: float = si("kg", "mass", "m", 0.0, ge=0)
    directions: Literal["x", "y", "xy"] = "xy"
    stiffness: float | tuple[float, float] = si("N/m", "stiffness", "c")
    damping: float | tuple[float, float] = si("N s/m", "damping", "b", 0.0)
    gravity: float = si("m/s^2", "acceleration of gravity", "g", 0.0)

    @property
    def path(self) -> str:
        """``carrier``."""
        return "carrier"

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The displacement of the axis from the place where the springs are free of force."""
        return tuple(Coordinate.named(f"carrier.{d}", f"carrier.v{d}") for d in self.directions)

    def check(self) -> None:
        """Stiffness and damping are not negative; a pair needs both directions; something must hold the weight."""
        for name in ("stiffness", "damping"):
            value = getattr(self, name)
            if isinstance(value, tuple) and self.directions != "xy":
                raise ValueError(name, f"allowed is one number, because directions = {self.directions!r}")
            if min(value if isinstance(value, tuple) else (value,)) < 0:
                raise ValueError(name, f"allowed is a {name} of at least 0")
        vertical = self.stiffness[1] if isinstance(self.stiffness, tuple) else self.stiffness
        if self.gravity and "y" in self.directions and vertical == 0:
            raise ValueError("stiffness", "allowed is a positive stiffness in y, because gravity would make the carrier fall")

    def component(self, name: str, direction: str) -> sp.Symbol:
        """The symbol of a stiffness or damping in a direction."""
        return self.symbol(f"{name}.{direction}" if isinstance(getattr(self, name), tuple) else name)

    def energies(self, frame: Frame) -> Energies:
        """T = m v^2/2, V = sum c x^2/2 + m g y, R = sum b x'^2/2."""
        m = self.symbol("mass")
        axes = tuple(zip(self.directions, self.coordinates(), strict=True))
        return Energies(
            kinetic=m * (frame.vx**2 + frame.vy**2) / 2,
            potential=sp.Add(*(self.component("stiffness", d) * q.position**2 / 2 for d, q in axes))
            + m * frame.gravity * frame.y,
            dissipation=sp.Add(*(self.component("damping", d) * q.velocity**2 / 2 for d, q in axes)),
        )
