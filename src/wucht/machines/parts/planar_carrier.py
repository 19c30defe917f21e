"""The planar rigid carrier: a body that translates and turns in its plane, such as a vibratory screen."""

from __future__ import annotations

from typing import Literal

import numpy as np
import sympy as sp
from pydantic import Field

from wucht.fields import Described
from wucht.machines.parts.base import Body, Frame, si
from wucht.machines.parts.support import Support, is_negative
from wucht.mechanics.energies import Energies


class Mount(Described):
    """A spring and damper at a place on the carrier, measured from its centre of mass: one value for x and y, or a pair."""

    at: tuple[float, float] = si("m", "place", "a")
    stiffness: float | tuple[float, float] = si("N/m", "stiffness", "c")
    damping: float | tuple[float, float] = si("N s/m", "damping", "b", (0.0, 0.0))


class PlanarCarrier(Support):
    """``directions = "xyr"``: a rigid body with rotors at given positions, on mounts or on springs at its centre of mass.

    Its angle chi is small: a place (a, b) on it moves by (x - b chi, y + a chi), so that the carrier stays linear.
    """

    kind = "carrier-xyr"

    mass: float = si("kg", "mass", "m", gt=0)
    inertia: float = si("kg m^2", "moment of inertia about the centre of mass", "J", gt=0)
    directions: Literal["xyr"] = "xyr"
    stiffness: float | tuple[float, float] | None = si("N/m", "stiffness", "c", None)
    damping: float | tuple[float, float] = si("N s/m", "damping", "b", 0.0)
    rotation_stiffness: float | None = si("N m", "rotation stiffness", "c_r", None, ge=0)
    rotation_damping: float = si("N m s", "rotation damping", "b_r", 0.0, ge=0)
    mounts: tuple[Mount, ...] = Field((), description="mounts")

    def check(self) -> None:
        """Mounts, or stiffness and rotation_stiffness; none of them negative."""
        self.check_motion()
        if self.mounts and (self.stiffness is not None or self.rotation_stiffness is not None):
            raise ValueError("mounts", "give either mounts, or stiffness with rotation_stiffness")
        if not self.mounts and self.stiffness is None:
            raise ValueError("stiffness", "this key is missing; needed are mounts, or stiffness and rotation_stiffness")
        pairs = [("stiffness", self.stiffness), ("damping", self.damping)]
        pairs += [("mounts", v) for m in self.mounts for v in (m.stiffness, m.damping)]
        for key, value in pairs:
            if is_negative(value):
                raise ValueError(key, "must be a stiffness or damping of at least 0")
        if self.mounts and not any(np.any(m.stiffness) for m in self.mounts):
            raise ValueError("mounts", "there must be at least one mount with stiffness")

    def check_body(self, body: Body) -> None:
        """Bodies may be anywhere on it."""
        self.check_couple(body)

    def energies(self, frame: Frame) -> Energies:
        """T = m v^2/2 + J chi'^2/2; springs and dampers on the displacements of their places."""
        m, j = self.symbols("mass", "inertia")
        at, r = frame.centre, self.coordinates()[2]
        potential, dissipation = [m * frame.gravity * at.y], []
        for place, c, b in self._springs():
            p = self.axis_at(place)
            potential.append((c[0] * p.x**2 + c[1] * p.y**2) / 2)
            dissipation.append((b[0] * p.vx**2 + b[1] * p.vy**2) / 2)
        if not self.mounts:
            cr, br = self.symbols("rotation_stiffness", "rotation_damping")
            potential.append(cr * r.position**2 / 2 if self.rotation_stiffness is not None else sp.S.Zero)
            dissipation.append(br * r.velocity**2 / 2)
        return Energies(m * (at.vx**2 + at.vy**2) / 2 + j * r.velocity**2 / 2, sp.Add(*potential), sp.Add(*dissipation))

    def _springs(self) -> list[tuple[tuple[sp.Expr, sp.Expr], tuple[sp.Expr, ...], tuple[sp.Expr, ...]]]:
        """(place, (cx, cy), (bx, by)) of every spring."""
        if not self.mounts:
            c, b = (tuple(self.component(name, d) for d in "xy") for name in ("stiffness", "damping"))
            return [((sp.S.Zero, sp.S.Zero), c, b)]
        springs = []
        for i, mount in enumerate(self.mounts, 1):
            place = self.symbols(f"mounts.{i}.at.x", f"mounts.{i}.at.y")
            c, b = (self._both(f"mounts.{i}.{name}", getattr(mount, name)) for name in ("stiffness", "damping"))
            springs.append((place, c, b))
        return springs

    def _both(self, path: str, value: float | tuple[float, float]) -> tuple[sp.Expr, sp.Expr]:
        """The symbols of x and y; the same where one value holds for both."""
        x, y = self.symbols(f"{path}.x", f"{path}.y") if isinstance(value, tuple) else 2 * self.symbols(path)
        return x, y
