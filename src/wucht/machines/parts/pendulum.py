"""The pendulum: a balancing mass that turns about another body's axis; with its default inertia, a point ball."""

from __future__ import annotations

import math
from collections.abc import Mapping

import sympy as sp

from wucht.machines.parts.base import SI, Frame, si
from wucht.machines.parts.track import TrackBody
from wucht.mechanics.energies import Energies


class Pendulum(TrackBody):
    """A pendulum on the axis of ``about``, or on a pivot that turns with it, with viscous damping. Drozdetskaya (4.1)-(4.4)."""

    kind = "pendulum"

    length: SI[float] = si("m", "length", "l", gt=0, help="distance of the centre of mass from the axis or pivot")
    inertia: SI[float | None] = si("kg m^2", "moment of inertia about its axis of rotation", "J", default=None, gt=0)
    damping: SI[float] = si(
        "N m s", "damping", "beta", default=0.0, ge=0, help="viscous damping to the body that it turns about"
    )
    suspension: SI[tuple[float, float] | None] = si(
        "m",
        "pivot in the frame of the body turned about",
        "s",
        default=None,
        help="pivot in the frame of the body turned about, by default its axis",
    )

    def check(self) -> None:
        """Check that the inertia is at least m l^2, its default, and that a track has a diameter and no suspension."""
        least = self.mass * self.length * self.length
        if not math.isfinite(least):
            raise ValueError("length", "must be a length with which m l^2 can still be computed")
        if self.inertia is not None and self.inertia < least * (1 - 1e-12):
            sentence = f"must be at least m l^2 = {least:.6g} kg m^2, that of a point ball, which is the default"
            raise ValueError("inertia", sentence)
        if self.track is not None and not self.is_on_axis():
            raise ValueError("suspension", "not allowed on a track: its bodies turn about one axis")
        self.check_track()

    def arms(self) -> Mapping[str, sp.Expr]:
        """The length."""
        return {self.name: self.symbol("length")}

    def is_on_axis(self) -> bool:
        """True without a suspension."""
        return self.suspension in (None, (0.0, 0.0))

    def centre_radius(self) -> float:
        """The length."""
        return self.length

    def moment(self) -> sp.Expr:
        """The unbalance m l."""
        return self.symbol("mass") * self.symbol("length")

    def moment_on_reference(self) -> sp.Expr:
        """Return the moment of the mass at the pivot: m (s_x + i s_y)."""
        if self.suspension is None:
            return sp.S.Zero
        m, a, b = self.symbols("mass", "suspension.x", "suspension.y")
        return m * (a + sp.I * b)

    def axis_inertia(self) -> sp.Expr:
        """The inertia about the pivot."""
        m, l, j = self.symbols("mass", "length", "inertia")  # noqa: E741
        return m * l**2 if self.inertia is None else j

    def energies(self, frame: Frame) -> Energies:
        """Carried mass with unbalance m l, J theta'^2/2, and b (theta' - phi')^2/2 lost against ``about``."""
        m, b = self.symbols("mass", "damping")
        w, relative = frame.speed(self.name), frame.speed(self.name) - frame.speed(self.about)
        body_energies = Energies(kinetic=self.axis_inertia() * w**2 / 2, dissipation=b * relative**2 / 2)
        on_axis = frame.carried_energies(m, self.moment(), self.name) + body_energies
        return on_axis if self.suspension is None else on_axis + self._offset_energies(frame)

    def _offset_energies(self, frame: Frame) -> Energies:
        """Return the energies added by a pivot at s on ``about``: m v.p' + m p'^2/2 + m l theta' p'.n(theta), p = R(phi) s."""
        m, l, a, b = self.symbols("mass", "length", "suspension.x", "suspension.y")  # noqa: E741
        at, phi, theta = frame.axis(self.name), frame.angle(self.about), frame.angle(self.name)
        w0, w = frame.speed(self.about), frame.speed(self.name)
        px, py = (-a * sp.sin(phi) - b * sp.cos(phi)) * w0, (a * sp.cos(phi) - b * sp.sin(phi)) * w0
        swing = w0 * w * (a * sp.cos(theta - phi) + b * sp.sin(theta - phi))
        return Energies(
            kinetic=m * (at.vx * px + at.vy * py) + m * (a**2 + b**2) * w0**2 / 2 + m * l * swing,
            potential=m * frame.gravity * (a * sp.sin(phi) + b * sp.cos(phi)),
        )
