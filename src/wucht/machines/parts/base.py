"""What a part is: a few physical quantities and the energies made of them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal, Self

import sympy as sp
from pydantic import Field, model_validator

from wucht.fields import Described, Parameter, si, unit_of
from wucht.mechanics.energies import Applied, Energies
from wucht.mechanics.lagrange import Coordinate

__all__ = ["Body", "Described", "Drive", "Frame", "Load", "OnShaft", "Parameter", "Part", "Point", "Release", "si", "unit_of"]


@dataclass(frozen=True)
class Point:
    """Position and velocity of a point of the carrier; zero where it is blocked."""

    x: sp.Expr = sp.S.Zero
    y: sp.Expr = sp.S.Zero
    vx: sp.Expr = sp.S.Zero
    vy: sp.Expr = sp.S.Zero

    @classmethod
    def of(cls, coordinates: Mapping[str, Coordinate]) -> Point:
        """The point with the coordinates x and y, those that there are."""
        named = {d: c for d, c in coordinates.items() if d in ("x", "y")}
        return cls(**{d: c.position for d, c in named.items()}, **{f"v{d}": c.velocity for d, c in named.items()})


@dataclass(frozen=True)
class Frame:
    """Where bodies live: the carrier, the axes on it, gravity, and all turning bodies.

    centre: the carrier's own centre of mass. rotation: the velocity of its turning about the plane's normal (zero where it does
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
        """The absolute angle of a body."""
        return self.bodies[body].position

    def speed(self, body: str) -> sp.Symbol:
        """The absolute angular velocity of a body."""
        return self.bodies[body].velocity

    def axis(self, body: str) -> Point:
        """The axis about which a body turns."""
        return self.axes.get(body, self.centre)

    def carried(self, mass: sp.Expr, unbalance: sp.Expr, body: str) -> Energies:
        """Energies of a mass carried by a body's axis, its centre off the axis: unbalance = mass times distance.

        T = m (x'^2 + y'^2)/2 + U phi' (-x' sin phi + y' cos phi), V = m g y + U g sin phi; the part of T that is
        quadratic in phi' belongs to the body's inertia about the axis.
        """
        phi, speed, at = self.angle(body), self.speed(body), self.axis(body)
        return Energies(
            kinetic=mass * (at.vx**2 + at.vy**2) / 2 + unbalance * speed * (-at.vx * sp.sin(phi) + at.vy * sp.cos(phi)),
            potential=self.gravity * (mass * at.y + unbalance * sp.sin(phi)),
        )


class Release(Described):
    """Until a time, or until the body it turns about has reached a speed for the first time, a body turns with that body."""

    time: float | None = si("s", "time of release", "t_0", None, gt=0)
    speed: float | None = si("rad/s", "speed of release", "w_0", None, gt=0)

    @model_validator(mode="after")
    def _one_of_both(self) -> Release:
        if (self.time is None) == (self.speed is None):
            raise ValueError("must be { time = ... } or { speed = ... }, one of both")
        return self


class Part(Described, ABC):
    """A part states its kinetic and potential energy, its dissipation and the power applied to it.

    Its fields made by ``si`` are given as a number in SI or a string with a unit. Every one of them that is given
    becomes a parameter ``path.field`` of the machine. A part is checked when it is built, from a file or in Python:
    ``InputError`` for what no real part can have.
    """

    @property
    @abstractmethod
    def path(self) -> str:
        """How parameters of this part are addressed: ``path.field``."""

    @abstractmethod
    def energies(self, frame: Frame) -> Energies:
        """The formulas of the part."""

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates the part brings along."""
        return ()

    def arms(self) -> Mapping[str, sp.Expr]:
        """How far the centres of mass of rigid bodies are from their axes, by body: of those the part stands for and knows."""
        return {}

    def shaking(self) -> tuple[sp.Symbol, sp.Symbol] | None:
        """Amplitude and angular frequency of a harmonic motion that the part prescribes."""
        return None

    def standing(self) -> Mapping[str, str]:
        """Of the carrier's coordinates by label, on which another one stands: ``{"foundation": "y"}``."""
        return {}

    def check(self) -> None:
        """Raises ``ValueError(field, sentence)`` where the values cannot be those of a real part; called when it is built."""

    @model_validator(mode="after")
    def _check_itself(self) -> Self:
        self.check()
        return self

    def number(self, expression: sp.Expr) -> float:
        """The value of an expression in the part's own parameters."""
        values = {sp.Symbol(p.path, real=True): sp.Float(p.value) for p in self.parameters()}
        return float(sp.sympify(expression).xreplace(values))

    def symbol(self, name: str) -> sp.Symbol:
        """The symbol of one of the part's parameters."""
        return sp.Symbol(f"{self.path}.{name}" if self.path else name, real=True)

    def symbols(self, *names: str) -> tuple[sp.Symbol, ...]:
        """The symbols of several parameters."""
        return tuple(self.symbol(n) for n in names)

    def parameters(self) -> tuple[Parameter, ...]:
        """The part's parameters: its quantities that are given."""
        return self.parameters_at(self.path)


class Body(Part):
    """A body of the machine, on the carrier or on another body (``about``)."""

    name: str = Field(description="name", pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")
    release: Release | None = Field(None, description="release, { time = ... } or { speed = ... }")

    @property
    def path(self) -> str:
        """The body's name."""
        return self.name

    @property
    def reference(self) -> str | None:
        """The body it turns about, if any."""
        about = getattr(self, "about", None)
        return None if about is None else str(about)

    def turns(self) -> bool:
        """Whether the body's coordinate is its absolute angle."""
        return True

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The absolute angle, counter-clockwise from +x to the centre of mass."""
        return (Coordinate.named(f"{self.name}.angle", f"{self.name}.speed", angle=True),)

    def moment(self) -> sp.Expr:
        """The unbalance: mass times the distance of the centre of mass from the axis."""
        return sp.S.Zero

    def moment_along_guide(self) -> sp.Expr:
        """By how much its unbalance grows with the displacement of the mass that slides in it."""
        return sp.S.Zero

    def largest_moment(self) -> sp.Expr:
        """The largest unbalance that it can have."""
        return self.moment()

    def doubts(self) -> tuple[str, ...]:
        """Warnings: what runs but is doubtful."""
        return ()

    def couple(self) -> sp.Expr | None:
        """The couple unbalance, m e a of 001 (10), None where it has none."""
        return None

    def about_axis(self) -> sp.Expr | None:
        """The moment of inertia about its axis, None where the body does not say."""
        return None

    def place(self) -> tuple[sp.Expr, sp.Expr] | None:
        """Where on the carrier its axis is, None for the centre."""
        return None

    def on_axis(self) -> bool:
        """Whether it turns about the very axis of ``about``."""
        return True

    def moment_on_reference(self) -> sp.Expr:
        """What it adds to the unbalance of the body it turns about, as a complex number in that body's frame."""
        return sp.S.Zero


class OnShaft(Part):
    """What acts on the shaft of one body: a torque that depends on its speed. ``on``: by default the machine's only rotor."""

    on: str = Field("", description="name of the body")
    label: str = Field("", exclude=True)
    group: ClassVar[str] = ""

    @property
    def path(self) -> str:
        """``drive`` for the only drive, ``drives.BODY`` where a machine has several; loads likewise."""
        return f"{self.group}s.{self.label}" if self.label else self.group

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """The torque at a speed: of a drive in the direction of positive speeds, of a load against it; zero if not given."""
        return sp.S.Zero

    def torque_at(self, speed: float) -> float:
        """The torque in N m at a speed in rad/s, in numbers."""
        w = sp.Symbol("speed", real=True)
        return self.number(self.torque(w).subs(w, speed))


class Drive(OnShaft):
    """A drive acts on one body. Its stator stands on the foundation, or on the carrier, which then feels its reaction."""

    group: ClassVar[str] = "drive"
    stator: Literal["foundation", "carrier"] = "foundation"

    def prescribed(self) -> sp.Expr | None:
        """The speed it enforces, or None if it applies a torque."""
        return None

    def no_load_path(self) -> str | None:
        """The path of the parameter that is the speed at which its torque is zero, None where none is."""
        return None

    def synchronous_speed(self) -> float | None:
        """The synchronous speed in rad/s, None where the drive has no slip."""
        return None

    def held_speed(self) -> float | None:
        """The speed in rad/s at which it gives any torque within its limits, None where its torque follows from the speed."""
        return None

    def breakdown(self) -> tuple[float, float, float] | None:
        """Slip, speed in rad/s and torque in N m at which it pulls out, None where it does not."""
        return None

    def start_angle(self) -> float:
        """The angle at t = 0 of a body whose motion is prescribed: the field ``angle``, if there is one."""
        return float(getattr(self, "angle", 0.0))

    def energies(self, frame: Frame) -> Energies:
        """The torque, on the speed of the body against the stator."""
        speed = frame.speed(self.on) - (frame.rotation if self.stator == "carrier" else 0)
        return Energies(applied=(Applied(self.torque(speed), speed, name=self.path),))

    def linearised(self, speed: float) -> tuple[float, float]:
        """Slope and no-load speed of the straight line through a working point: torque = slope (no_load_speed - speed).

        speed: in rad/s. Returns slope in N m s, positive where the torque falls, and the no-load speed in rad/s, infinite
        where the torque does not depend on the speed.
        """
        w = sp.Symbol("speed", real=True)
        torque, slope = self.torque_at(speed), -self.number(sp.diff(self.torque(w), w).subs(w, speed))
        return slope, speed + torque / slope if slope else math.copysign(math.inf, torque)


class Load(OnShaft):
    """A load on one body: it takes work out of its rotation."""

    group: ClassVar[str] = "load"

    def energies(self, frame: Frame) -> Energies:
        """The torque against the speed of the body, booked as lost."""
        speed = frame.speed(self.on)
        return Energies(applied=(Applied(-self.torque(speed), speed, name=self.path, booked="lost"),))
