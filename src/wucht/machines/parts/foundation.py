"""A foundation mass under one direction of the carrier."""

from __future__ import annotations

from typing import Literal

import sympy as sp
from pydantic import Field

from wucht.fields import Described, si
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate


class Foundation(Described):
    """A mass on its own springs and dampers, on which the carrier's springs of one direction stand: 000, end of section 5."""

    direction: Literal["x", "y"] = Field(description="direction")
    mass: float = si("kg", "mass", "m_f", gt=0)
    stiffness: float = si("N/m", "stiffness", "c_f", gt=0)
    damping: float = si("N s/m", "damping", "b_f", 0.0, ge=0)

    def energies(self, at: Coordinate, gravity: sp.Expr) -> Energies:
        """T = m v^2/2, V = c z^2/2 + m g z (in y), R = b v^2/2."""
        m, c, b = (sp.Symbol(f"carrier.foundation.{n}", real=True) for n in ("mass", "stiffness", "damping"))
        weight = m * gravity * at.position if self.direction == "y" else sp.S.Zero
        return Energies(m * at.velocity**2 / 2, c * at.position**2 / 2 + weight, b * at.velocity**2 / 2)
