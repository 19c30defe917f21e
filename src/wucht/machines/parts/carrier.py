"""The carrier that translates: on springs and dampers, on a foundation, or with a prescribed motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, Self

import sympy as sp
from pydantic import Field

from wucht.errors import FieldError
from wucht.machines.parts.base import SI, Frame, si
from wucht.machines.parts.support import (
    Inertia,
    Pair,
    Support,
    is_negative,
    refuse_both,
    refuse_ratio_without_spring,
    tuned_damping,
    tuned_stiffness,
    tuning_text,
)
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.schema import Composite, TableModel, composite


class Foundation(TableModel):
    """A mass on springs and dampers, on which the carrier's springs of one direction rest: 000, end of section 5."""

    direction: Literal["x", "y"] = Field(title="direction", description="direction in which the foundation moves")
    mass: SI[float] = si("kg", "mass", "m_f", gt=0, help="mass of the foundation")
    stiffness: SI[float] = si("N/m", "stiffness", "c_f", gt=0, help="stiffness of the springs under the foundation")
    damping: SI[float] = si(
        "N s/m", "damping", "b_f", default=0.0, ge=0, help="viscous damping of the springs under the foundation"
    )

    def energies(self, at: Coordinate, gravity: sp.Expr) -> Energies:
        """T = m v^2/2, V = c z^2/2 + m g z (in y), R = b v^2/2."""
        m, c, b = (sp.Symbol(f"carrier.foundation.{n}", real=True) for n in ("mass", "stiffness", "damping"))
        weight = m * gravity * at.position if self.direction == "y" else sp.S.Zero
        return Energies(m * at.velocity**2 / 2, c * at.position**2 / 2 + weight, b * at.velocity**2 / 2)


class Carrier(Support):
    """A mass that moves in x, y or both, held by linear springs and dampers; y points up, against gravity.

    Its displacement in one direction may be prescribed; its springs of one direction may be on a foundation.
    """

    kind = "carrier"

    mass: SI[float] = si("kg", "mass", "m", default=0.0, ge=0, help="mass of the carrier without the bodies on it")
    directions: Literal["x", "y", "xy", "fixed"] = Field(
        default="xy", description='directions in which the carrier moves; `"fixed"`: the axis does not move'
    )
    stiffness: SI[float | tuple[float, float] | None] = si("N/m", "stiffness", "c", default=None, help=(
        "stiffness of the springs, one number (isotropic) or a pair [x, y]; or give `frequency`"
    ))  # fmt: skip
    damping: SI[float | tuple[float, float]] = si("N s/m", "damping", "b", default=0.0, help=(
        "viscous damping of the carrier, one number (isotropic) or a pair [x, y]; or give `damping_ratio`"
    ))  # fmt: skip
    frequency: SI[float | tuple[float, float] | None] = si(
        "rad/s", "natural frequency with all bodies on it", "omega_0", default=None,
        help="natural frequency with all bodies on the carrier, from which the stiffness follows",
    )  # fmt: skip
    damping_ratio: SI[float | tuple[float, float] | None] = si(
        "",
        "damping ratio with all bodies on it",
        "zeta",
        default=None,
        help="damping ratio with all bodies on the carrier, from which the damping follows",
    )
    foundation: Composite[Foundation | None] = composite(
        default=None, description="mass on springs under the carrier's springs of one direction"
    )

    @property
    def labels(self) -> tuple[str, ...]:
        """x, y, and foundation."""
        axes = () if self.directions == "fixed" else tuple(self.directions)
        return (*axes, "foundation") if self.foundation else axes

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Return the displacement of the axis from where the springs are free of force, then that of the foundation."""
        if not self.foundation:
            return super().coordinates()
        d = self.foundation.direction
        return (*super().coordinates(), Coordinate.from_names(f"foundation.{d}", f"foundation.v{d}"))

    def supported_directions(self) -> Mapping[str, str]:
        """Return the direction whose springs rest on the foundation."""
        return {"foundation": self.foundation.direction} if self.foundation else {}

    def check(self) -> None:
        """Check that stiffness and damping are not negative, that a pair has both directions, and that the weight is held."""
        self.check_motion()
        free = [d for d in self.labels if self.prescribed_velocity(d) is None and d != "foundation"]
        if self.stiffness is None and self.frequency is None and free:
            raise FieldError("stiffness", "this key is missing; give the stiffness in N/m", code="missing")
        refuse_both(self, "stiffness", "frequency")
        refuse_both(self, "damping", "damping_ratio")
        keys = ("stiffness", "damping", "frequency", "damping_ratio")
        for name, value in ((name, getattr(self, name)) for name in keys):
            if isinstance(value, tuple) and self.directions != "xy":
                raise ValueError(name, f"must be one number, because directions = {self.directions!r}")
            if is_negative(value):
                raise ValueError(name, f"must be a {name.replace('_', ' ')} of at least 0")
        if self.foundation and self.foundation.direction not in free:
            sentence = f"must be a foundation under one of the free directions: {', '.join(free) or 'none'}"
            raise ValueError("foundation", sentence)
        spring = self.stiffness if self.frequency is None else self.frequency
        refuse_ratio_without_spring("damping_ratio", self.damping_ratio, spring)
        vertical = spring[1] if isinstance(spring, tuple) else spring
        if self.gravity and "y" in free and not vertical:
            raise ValueError("stiffness", "must be a positive stiffness in y, because gravity would make the carrier fall")

    def tune_springs(self, inertia: Inertia) -> tuple[Self, str]:
        """See ``Support``."""
        if self.frequency is None and self.damping_ratio is None:
            return self, ""
        free = [d for d in self.labels if d != "foundation"]
        whole = inertia(free[0]) if free else 0.0
        stiffness = self.stiffness if self.frequency is None else tuned_stiffness(whole, self.frequency)
        tuning: dict[str, Pair | None] = {"stiffness": stiffness}
        if self.damping_ratio is not None:
            tuning["damping"] = tuned_damping(whole, stiffness or 0.0, self.damping_ratio)
        carrier = self.model_copy(update=tuning | {"frequency": None, "damping_ratio": None})
        changes = {name: value for name, value in tuning.items() if getattr(self, name) != value}
        return carrier, f"carrier: {tuning_text(changes, f'{whole:.6g} kg')}"

    def energies(self, frame: Frame) -> Energies:
        """T = m v^2/2, V = sum c x^2/2 + m g y, R = sum b x'^2/2; on a foundation, x against it, and its energies."""
        m, at = self.symbol("mass"), frame.centre
        coordinates = dict(zip(self.labels, self.coordinates(), strict=True))
        base = coordinates.pop("foundation", None)
        potential, dissipation = [m * frame.gravity * at.y], []
        for d, q in coordinates.items():
            below = base if self.foundation and self.foundation.direction == d else None
            x = q.position - (below.position if below else 0)
            v = q.velocity - (below.velocity if below else 0)
            potential.append(self.component("stiffness", d) * x**2 / 2)
            dissipation.append(self.component("damping", d) * v**2 / 2)
        carrier_energies = Energies(m * (at.vx**2 + at.vy**2) / 2, sp.Add(*potential), sp.Add(*dissipation))
        return (
            carrier_energies + self.foundation.energies(base, frame.gravity) if base and self.foundation else carrier_energies
        )
