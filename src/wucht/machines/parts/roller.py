"""The roller: a ball or cylinder that rolls without slip in a circular track of another body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import sympy as sp
from pydantic import Field, model_validator

from wucht.errors import FieldError
from wucht.machines.parts.base import SI, Frame, si
from wucht.machines.parts.oil import WIDEST, Oil
from wucht.machines.parts.track import TrackBody
from wucht.mechanics.energies import Energies
from wucht.schema import Composite, composite

_BALL = 0.4  # shape factor


class Roller(TrackBody):
    """A ball or roller on a track of radius R. Its centre runs on the circle R - r: Sperling et al., rollers (3)-(12).

    Rolling couples it to the body that it turns about: its spin is (R phi_0' - (R - r) phi') / r, so its energy holds both
    speeds.
    """

    kind = "roller"

    track_radius: SI[float] = si("m", "track radius", "R", gt=0, help="radius of the track on which it rolls")
    radius: SI[float] = si("m", "radius", "r", gt=0, help="radius of the ball or roller")
    shape_factor: SI[float] = si("", "shape factor (2/5 ball, 1/2 cylinder, 1 tube)", "mu", default=0.4, ge=0, le=1)
    damping: SI[float] = si(
        "N m s", "damping", "beta", default=0.0, ge=0, help="viscous damping to the body that it turns about; or give `oil`"
    )
    oil: Composite[Oil | None] = composite(default=None, description=(
        "oil around a ball, from which its damping follows, { viscosity = \"0.5 Pa s\", gap = \"1 mm\" }"
    ))  # fmt: skip
    origin: str = Field(default="", exclude=True)

    @model_validator(mode="before")
    @classmethod
    def _no_damping_beside_oil(cls, table: Any) -> Any:
        if isinstance(table, Mapping) and table.get("oil") is not None and table.get("damping") is not None:
            raise FieldError("damping", "not allowed beside oil, from which it follows", code="either-or")
        return table

    @model_validator(mode="after")
    def _damping_of_the_oil(self) -> Self:
        if self.oil is None:
            return self
        arm, drag, fastest = self.centre_radius(), self.oil.drag(self.radius), self.oil.fastest(self.radius)
        reynolds = 2 * self.oil.density * fastest * self.radius / self.oil.viscosity
        oil = f"oil of {self.oil.viscosity:.4g} Pa s, gap {1e3 * self.oil.gap:.4g} mm"
        limit = (
            f"up to a slip of about {fastest / arm:.2g} rad/s (Reynolds number {reynolds:.2g}); faster balls are damped more"
        )
        origin = f"damping {drag * arm**2:.4g} N m s of each ball about {self.about!r}: {oil}; {limit}"
        return self.model_copy(update={"damping": drag * arm**2, "oil": None, "origin": origin})

    def check(self) -> None:
        """Check that the roller fits into its track, and that its diameter is twice its radius."""
        if self.radius >= self.track_radius:
            raise ValueError("radius", f"must be less than the track radius of {self.track_radius:g} m")
        if self.diameter is not None and abs(self.diameter - 2 * self.radius) > 1e-9 * self.radius:
            raise ValueError("diameter", f"must be twice the radius, {2 * self.radius:g} m, which is the default")
        if self.oil is not None and self.shape_factor != _BALL:
            raise ValueError("oil", f"allowed for balls only, of shape_factor = {_BALL}; give the damping")
        if self.oil is not None and self.oil.gap > WIDEST * self.radius:
            raise ValueError(
                "oil", f"must be oil in a gap of at most half the radius, {WIDEST * self.radius:.4g} m; or give the damping"
            )
        self.check_track()

    def derivation_notes(self) -> tuple[str, ...]:
        """Return the origin of the damping, where it follows from that of oil."""
        return (self.origin,) if self.origin else ()

    def centre_radius(self) -> float:
        """R - r."""
        return self.track_radius - self.radius

    def width(self) -> float | None:
        """Twice the radius."""
        return 2 * self.radius

    def moment(self) -> sp.Expr:
        """The unbalance m (R - r)."""
        return self.symbol("mass") * (self.symbol("track_radius") - self.symbol("radius"))

    def axis_inertia(self) -> sp.Expr:
        """The inertia J_ii of 000 (7): (1 + mu) m (R - r)^2."""
        m, track, r, mu = self.symbols("mass", "track_radius", "radius", "shape_factor")
        return (1 + mu) * m * (track - r) ** 2

    def energies(self, frame: Frame) -> Energies:
        """000 (5): carried mass, m eps^2 phi'^2/2, and mu m (R phi_0' - eps phi')^2/2 of the rolling; 000 (12) is lost."""
        m, track, r, mu, beta = self.symbols("mass", "track_radius", "radius", "shape_factor", "damping")
        eps = track - r
        w, w0 = frame.speed(self.name), frame.speed(self.about)
        body_energies = Energies(
            kinetic=m * eps**2 * w**2 / 2 + mu * m * (track * w0 - eps * w) ** 2 / 2,
            dissipation=beta * (w - w0) ** 2 / 2,
        )
        return frame.carried_energies(m, self.moment(), self.name) + body_energies
