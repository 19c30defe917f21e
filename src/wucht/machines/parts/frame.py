"""Frame of a machine: the quantities in which a part's formulas are written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy as sp

from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate


@dataclass(frozen=True)
class Point:
    """Position and velocity of a point of the carrier; zero where it is blocked."""

    x: sp.Expr = sp.S.Zero
    y: sp.Expr = sp.S.Zero
    vx: sp.Expr = sp.S.Zero
    vy: sp.Expr = sp.S.Zero

    @classmethod
    def from_coordinates(cls, coordinates: Mapping[str, Coordinate]) -> Point:
        """Return the point with the coordinates x and y as far as present."""
        plane_coordinates = {d: c for d, c in coordinates.items() if d in ("x", "y")}
        return cls(
            **{d: c.position for d, c in plane_coordinates.items()},
            **{f"v{d}": c.velocity for d, c in plane_coordinates.items()},
        )


@dataclass(frozen=True)
class Frame:
    """Frame of the bodies: the carrier, the axes on it, gravity, and all turning bodies.

    centre: the carrier's centre of mass. rotation: the velocity of its turning about the plane's normal (zero where it does
    not turn). tilt: the velocity of its turning about an axis in the plane (a couple unbalance excites it). axes: the axis of
    each body.
    """

    centre: Point = field(default_factory=Point)
    rotation: sp.Expr = sp.S.Zero
    tilt: sp.Expr = sp.S.Zero
    gravity: sp.Expr = sp.S.Zero
    bodies: Mapping[str, Coordinate] = field(default_factory=dict)
    axes: Mapping[str, Point] = field(default_factory=dict)

    def angle(self, body: str) -> sp.Symbol:
        """Return the absolute angle of a body."""
        return self.bodies[body].position

    def speed(self, body: str) -> sp.Symbol:
        """Return the absolute angular velocity of a body."""
        return self.bodies[body].velocity

    def axis(self, body: str) -> Point:
        """Return the axis about which a body turns."""
        return self.axes.get(body, self.centre)

    def carried_energies(self, mass: sp.Expr, unbalance: sp.Expr, body: str) -> Energies:
        """Return the energies of a mass carried by a body's axis, its centre off the axis: unbalance = mass times distance.

        T = m (x'^2 + y'^2)/2 + U phi' (-x' sin phi + y' cos phi), V = m g y + U g sin phi; the part of T that is
        quadratic in phi' belongs to the body's inertia about the axis.
        """
        phi, speed, at = self.angle(body), self.speed(body), self.axis(body)
        return Energies(
            kinetic=mass * (at.vx**2 + at.vy**2) / 2 + unbalance * speed * (-at.vx * sp.sin(phi) + at.vy * sp.cos(phi)),
            potential=self.gravity * (mass * at.y + unbalance * sp.sin(phi)),
        )
