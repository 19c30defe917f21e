"""The switchable pendulum: balanced until the centrifugal force pulls a mass in it off its inner stop, 002 section 6.1."""

from __future__ import annotations

import math

import sympy as sp
from pydantic import Field

from wucht.machines.parts.base import SI, Body, Frame, si
from wucht.machines.parts.stop import stop
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate

CONTACT_RATIO = 50.0  # frequency of the stops over the speed of activation: the inner one gives way by 1/2500 of its radius
RESTITUTION = 0.5


class SwitchablePendulum(Body):
    """A rigid frame on the axis of ``about``, with a mass in a radial guide that a preloaded spring holds at the inner stop.

    The angle points from the axis to that mass. Its radius is inner_stop + s; s is the second coordinate, and
    V = preload s + stiffness s^2/2. The frame's centre of mass lies opposite. Both stops are compliant (``stop``) with a
    restitution; they are 50 times as fast as the speed of activation sqrt(preload/(moving_mass inner_stop)), or have
    ``contact_frequency``.
    """

    kind = "switchable-pendulum"

    about: str = Field(description="name of the body turned about")
    mass: SI[float] = si("kg", "mass of the frame", "m", gt=0)
    length: SI[float | None] = si("m", "distance of the frame's centre of mass behind the axis", "l", default=None, ge=0, help=(
        "distance of the frame's centre of mass behind the axis, by default so that the closed pendulum is balanced, except "
        "for `permanent_unbalance`"
    ))  # fmt: skip
    inertia: SI[float | None] = si("kg m^2", "moment of inertia of the frame about the axis", "J", default=None, gt=0)
    damping: SI[float] = si(
        "N m s", "damping", "beta", default=0.0, ge=0, help="viscous damping to the body that it turns about"
    )
    moving_mass: SI[float] = si("kg", "moving mass", "m_s", gt=0, help="mass in the radial guide")
    inner_stop: SI[float] = si("m", "radius of the moving mass at the inner stop", "r_i", gt=0)
    outer_stop: SI[float] = si("m", "radius of the moving mass at the outer stop", "r_o", gt=0)
    stiffness: SI[float] = si("N/m", "stiffness of the spring", "c", ge=0)
    preload: SI[float] = si("N", "force of the spring at the inner stop", "F_0", gt=0)
    restitution: SI[float] = si("", "coefficient of restitution at the stops", "e_c", default=RESTITUTION, ge=0.01, le=1)
    permanent_unbalance: SI[float] = si("kg m", "permanent unbalance", "U_p", default=0.0, help=(
        "small unbalance while closed, towards the moving mass, or away from it where negative"
    ))  # fmt: skip
    guide_damping: SI[float] = si("N s/m", "damping of the moving mass in its guide", "b", default=0.0, ge=0)
    contact_frequency: SI[float | None] = si("rad/s", "frequency of the stops", "omega_c", default=None, gt=0, help=(
        "frequency of the compliant stops, by default 50 times the speed of activation"
    ))  # fmt: skip

    def check(self) -> None:
        """Check that the outer stop is farther out, and that the frame's inertia is at least that of its unbalance."""
        if self.outer_stop <= self.inner_stop:
            raise ValueError("outer_stop", f"must be more than the inner stop, {self.inner_stop:g} m")
        moment = self.number(self._frame_moment())
        least = moment * moment / self.mass
        if not math.isfinite(least):
            raise ValueError("inner_stop", "must be a radius with which the frame's unbalance can still be computed")
        if self.inertia is not None and self.inertia < least * (1 - 1e-12):
            reason = f"that of the frame as a point mass with its unbalance of {moment:.6g} kg m, which is the default"
            raise ValueError("inertia", f"must be at least {least:.6g} kg m^2, {reason}")

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Return the absolute angle, and the displacement of the moving mass outward from the inner stop, in m."""
        return (*super().coordinates(), Coordinate.from_names(f"{self.name}.displacement", f"{self.name}.velocity"))

    def moment(self) -> sp.Expr:
        """The unbalance while the moving mass is at its inner stop: the permanent one, if the frame balances the rest."""
        return self._frame_moment() + self.symbol("moving_mass") * self.symbol("inner_stop")

    def moment_along_guide(self) -> sp.Expr:
        """The moving mass."""
        return self.symbol("moving_mass")

    def largest_moment(self) -> sp.Expr:
        """The unbalance while the moving mass is at its outer stop."""
        return self.moment() + self.symbol("moving_mass") * (self.symbol("outer_stop") - self.symbol("inner_stop"))

    def axis_inertia(self) -> sp.Expr:
        """The inertia while the moving mass is at its inner stop."""
        return self._frame_inertia() + self.symbol("moving_mass") * self.symbol("inner_stop") ** 2

    def doubts(self) -> tuple[str, ...]:
        """Return a warning for a frame that is not balanced."""
        residual = self.number(self.moment()) - self.permanent_unbalance
        stroke = self.moving_mass * (self.outer_stop - self.inner_stop)
        if abs(residual) <= 1e-9 * stroke:
            return ()
        balanced_length = self.moving_mass * self.inner_stop / self.mass
        cure = f"with length = {balanced_length:.6g} m, or without this key, it would be balanced"
        return (f"{self.name!r} keeps an unbalance of {residual:.4g} kg m while its mass is at the inner stop: {cure}",)

    def energies(self, frame: Frame) -> Energies:
        """With psi the angle, r = r_i + s and v the velocity of the axis:

        T = m v^2/2 + U_f psi' v.n + J psi'^2/2 of the frame, m_s |v + d/dt(r e(psi))|^2/2 of the moving mass;
        V = F_0 s + c s^2/2 and gravity; R = b (psi' - phi')^2/2 + d s'^2/2; and the two stops.
        """
        m, b, d = self.symbols("mass", "damping", "guide_damping")
        moving, inner, outer, c, preload = self.symbols("moving_mass", "inner_stop", "outer_stop", "stiffness", "preload")
        guide, at, psi, w = self.coordinates()[1], frame.axis(self.name), frame.angle(self.name), frame.speed(self.name)
        s, v, radius = guide.position, guide.velocity, inner + guide.position
        body_energies = Energies(
            kinetic=self._frame_inertia() * w**2 / 2 + moving * (v**2 + radius**2 * w**2) / 2
            + moving * v * (at.vx * sp.cos(psi) + at.vy * sp.sin(psi)),
            potential=preload * s + c * s**2 / 2,
            dissipation=b * (w - frame.speed(self.about)) ** 2 / 2 + d * v**2 / 2,
        )  # fmt: skip
        carried_energies = frame.carried_energies(m + moving, self._frame_moment() + moving * radius, self.name)
        bounce, frequency = sp.log(self.symbol("restitution")), self._contact_frequency()
        gaps = ((s, v), (outer - inner - s, -v))
        stops = [stop(gap, rate, moving, frequency, bounce) for gap, rate in gaps]
        return carried_energies + body_energies + stops[0] + stops[1]

    def _frame_moment(self) -> sp.Expr:
        """Return U_f: the permanent unbalance less the moment that balances the moving mass at its inner stop."""
        m, length, moving, inner, permanent = self.symbols("mass", "length", "moving_mass", "inner_stop", "permanent_unbalance")
        return permanent - (moving * inner if self.length is None else m * length)

    def _frame_inertia(self) -> sp.Expr:
        return self._frame_moment() ** 2 / self.symbol("mass") if self.inertia is None else self.symbol("inertia")

    def _contact_frequency(self) -> sp.Expr:
        moving, inner, preload = self.symbols("moving_mass", "inner_stop", "preload")
        if self.contact_frequency is not None:
            return self.symbol("contact_frequency")
        return CONTACT_RATIO * sp.sqrt(preload / (moving * inner))
