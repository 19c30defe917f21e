"""The slider: a mass in a radial guide of a turning body."""

from __future__ import annotations

import sympy as sp
from pydantic import Field

from wucht.machines.parts.base import SI, Body, Frame, si
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate


class Slider(Body):
    """A point mass in a radial guide of ``about``, on a spring and a damper. Sperling et al. (64)-(65), on any carrier.

    Its coordinate is the displacement outward from where the spring is free of force.
    """

    kind = "slider"

    about: str = Field(description="name of the body with the guide")
    mass: SI[float] = si("kg", "mass", "m", gt=0, help="mass of the slider")
    angle: SI[float] = si(
        "rad", "angle of the guide", "gamma", default=0.0, help="angle of the guide in the frame of the body that has it"
    )
    radius: SI[float] = si("m", "radius", "R", ge=0, help="radius at which the spring is free of force")
    stiffness: SI[float] = si("N/m", "stiffness", "c", gt=0, help="stiffness of its spring")
    damping: SI[float] = si("N s/m", "damping", "b", default=0.0, ge=0, help="damping of the damper beside the spring")

    def turns(self) -> bool:
        """False: it has a displacement, not an angle."""
        return False

    def check(self) -> None:
        """Check that there is no release: a slider always turns with its guide."""
        if self.release is not None:
            raise ValueError("release", "not allowed: a slider always turns with its guide")

    def moment_on_reference(self) -> sp.Expr:
        """m R in the direction of the guide."""
        m, angle, radius = self.symbols("mass", "angle", "radius")
        return m * radius * sp.exp(sp.I * angle)

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The displacement outward, in m."""
        return (Coordinate.from_names(f"{self.name}.displacement", f"{self.name}.velocity"),)

    def energies(self, frame: Frame) -> Energies:
        """T = m |v + d/dt[(R + x) e(psi)]|^2/2, psi = phi + angle; V = c x^2/2 + m g (y + (R + x) sin psi), R = b x'^2/2."""
        m, angle, radius, c, b = self.symbols("mass", "angle", "radius", "stiffness", "damping")
        (guide,) = self.coordinates()
        at, w = frame.axis(self.name), frame.speed(self.about)
        psi, out, v = frame.angle(self.about) + angle, radius + guide.position, guide.velocity
        along = at.vx * sp.cos(psi) + at.vy * sp.sin(psi)
        across = -at.vx * sp.sin(psi) + at.vy * sp.cos(psi)
        return Energies(
            kinetic=m * (at.vx**2 + at.vy**2 + v**2 + out**2 * w**2) / 2 + m * (v * along + out * w * across),
            potential=c * guide.position**2 / 2 + m * frame.gravity * (at.y + out * sp.sin(psi)),
            dissipation=b * v**2 / 2,
        )
