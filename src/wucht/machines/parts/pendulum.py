"""The pendulum: a balancing mass that turns about another body's axis; with its default inertia, a point ball."""

from __future__ import annotations

import math
from typing import ClassVar

import sympy as sp
from pydantic import Field

from wucht.machines.parts.base import Body, Frame, si
from wucht.mechanics.energies import Energies, total


class Pendulum(Body):
    """A pendulum on the axis of ``about``, coupled to it by viscous damping: 002 (4.1)-(4.4)."""

    kind: ClassVar[str] = "pendulum"
    not_yet: ClassVar[frozenset[str]] = Body.not_yet | {"suspension", "track", "diameter", "restitution"}

    about: str = Field(description="name of the body turned about")
    mass: float = si("kg", "mass", "m", gt=0)
    length: float = si("m", "length", "l", gt=0)
    inertia: float | None = si("kg m^2", "moment of inertia about its axis of rotation", "J", None, gt=0)
    damping: float = si("N m s", "damping", "b", 0.0, ge=0)

    def check(self) -> None:
        """The inertia about the axis is at least m l^2, which is its default."""
        least = self.mass * self.length * self.length
        if not math.isfinite(least):
            raise ValueError("length", "allowed is a length with which m l^2 can still be computed")
        if self.inertia is not None and self.inertia < least * (1 - 1e-12):
            raise ValueError(
                "inertia", f"allowed is at least m l^2 = {least:.6g} kg m^2, that of a point ball, which is the default"
            )

    def moment(self) -> sp.Expr:
        """The unbalance m l."""
        return self.symbol("mass") * self.symbol("length")

    def energies(self, frame: Frame) -> Energies:
        """Carried mass with unbalance m l, J theta'^2/2, and b (theta' - phi')^2/2 lost against ``about``."""
        m, l, j, b = self.symbols("mass", "length", "inertia", "damping")  # noqa: E741
        about_axis = m * l**2 if self.inertia is None else j
        w, relative = frame.speed(self.name), frame.speed(self.name) - frame.speed(self.about)
        own = Energies(kinetic=about_axis * w**2 / 2, dissipation=b * relative**2 / 2)
        return total((frame.carried(m, self.moment(), self.name), own))
