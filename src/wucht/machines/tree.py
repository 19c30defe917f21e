"""The tree of bodies that ``about`` makes, its roots on the carrier, and the rotating and sliding bodies of a machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from wucht.errors import WuchtError
from wucht.machines.parts.base import Frame, Point, Release
from wucht.mechanics.energies import Energies, InternalState
from wucht.mechanics.lagrange import Coordinate


@dataclass(frozen=True)
class RotatingBody:
    """A rotating body: name, kind, coordinate, the body it turns about, and its release from that."""

    name: str
    kind: str
    coordinate: Coordinate
    about: str | None = None
    release: Release | None = None

    @property
    def lock_symbol(self) -> sp.Symbol:
        """The parameter that is 1 while the body is locked."""
        return sp.Symbol(f"{self.name}.locked", real=True)


@dataclass(frozen=True)
class SlidingBody:
    """A body in a guide, or the mass that slides in a turning one: name, kind, displacement, and the body with the guide."""

    name: str
    kind: str
    coordinate: Coordinate
    about: str

    @property
    def words(self) -> str:
        """Description of the sliding mass."""
        return self.name if self.about != self.name else f"the mass in {self.name}"


@dataclass(frozen=True)
class Tree:
    """The tree of bodies by name. above: the body that each turns about, None for those on the carrier."""

    above: Mapping[str, str | None]

    def path(self, body: str) -> list[str]:
        """Return the body, the one it turns about, and so on to the one on the carrier. Raises ``WuchtError``: a circle."""
        way = [body]
        while (above := self.above.get(way[-1])) is not None:
            if above in way:
                raise WuchtError(
                    "bodies turn about each other in a circle; one must turn about the carrier's axis", code="circle"
                )
            way.append(above)
        return way

    def root(self, body: str) -> str:
        """Return the body on the carrier that it turns about, directly or through others; itself if it is one."""
        return self.path(body)[-1]

    @cached_property
    def outward(self) -> list[str]:
        """All bodies from the axis out: those on the carrier, those about them, and so on, each in the order given."""
        return sorted(self.above, key=lambda body: len(self.path(body)))

    def group(self, body: str) -> list[str]:
        """Return a body and all that turn about it, directly or through others, from the axis out."""
        return [name for name in self.outward if body in self.path(name)]


@dataclass(frozen=True)
class Bodies:
    """The bodies on a carrier, their tree, and their energies. See ``Machine`` for the fields."""

    carrier: tuple[Coordinate, ...]
    labels: tuple[str, ...]
    bodies: tuple[RotatingBody, ...]
    sliders: tuple[SlidingBody, ...]
    energies: tuple[Energies, ...]
    frame: Frame

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates, then the bodies' angles, then the sliders' displacements."""
        return (*self.carrier, *(b.coordinate for b in self.bodies), *(s.coordinate for s in self.sliders))

    @cached_property
    def internal(self) -> tuple[InternalState, ...]:
        """The internal states of the parts, such as a controller's."""
        return tuple(state for e in self.energies for state in e.internal_states)

    @cached_property
    def free_carrier(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates without those whose motion is prescribed."""
        return tuple(c for c in self.carrier if c.prescribed_velocity is None)

    @cached_property
    def shaken_coordinate(self) -> Coordinate | None:
        """The carrier's coordinate whose motion is prescribed, if one is."""
        return next((c for c in self.carrier if c.prescribed_velocity is not None), None)

    @cached_property
    def rotation_coordinate(self) -> Coordinate | None:
        """The carrier's turning about the normal of the plane, with which a locked rotor turns; None where it does not turn."""
        return next((c for c in self.carrier if c.velocity == self.frame.rotation), None)

    @cached_property
    def orbit(self) -> dict[str, tuple[sp.Expr, sp.Expr]]:
        """The motion whose amplitude is evaluated: x, y of the main rotor's axis, or the angle of a carrier that only turns."""
        if self.labels == ("r",):
            return {"r": (self.carrier[0].position, self.carrier[0].velocity)}
        axis = self.frame.axes.get(self.rotor.name, Point())
        return {n: motion for n, motion in {"x": (axis.x, axis.vx), "y": (axis.y, axis.vy)}.items() if motion[0] != 0}

    @cached_property
    def rotor(self) -> RotatingBody:
        """The main rotor: the first body that turns about no other."""
        return self.rotors[0]

    @cached_property
    def rotors(self) -> tuple[RotatingBody, ...]:
        """The bodies that turn about no other."""
        return tuple(b for b in self.bodies if b.about is None)

    @cached_property
    def tree(self) -> Tree:
        """The tree of the bodies, by name."""
        return Tree({b.name: b.about for b in self.bodies})

    @cached_property
    def outward(self) -> tuple[RotatingBody, ...]:
        """The bodies from the axis out."""
        return tuple(map(self.body, self.tree.outward))

    def body(self, name: str) -> RotatingBody:
        """Return the rotating body of a name."""
        return next(b for b in self.bodies if b.name == name)

    def rotor_of(self, body: RotatingBody) -> RotatingBody:
        """Return the rotor that a body turns about, directly or through others; itself if it is one."""
        return self.body(self.tree.root(body.name))

    def group(self, rotor: RotatingBody) -> list[RotatingBody]:
        """Return a rotor and all bodies that turn about it, directly or through others."""
        return [self.body(name) for name in self.tree.group(rotor.name)]
