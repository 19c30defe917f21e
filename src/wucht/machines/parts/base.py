"""What a part is: a few physical quantities and the energies made of them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar, Literal, Self

import sympy as sp
from pydantic import Field, model_validator

from wucht.machines.parts.frame import Frame, Point
from wucht.machines.parts.release import Release
from wucht.machines.parts.transmission import Transmission
from wucht.mechanics.energies import Applied, Energies, OwnState
from wucht.mechanics.lagrange import Coordinate
from wucht.schema import Described, Parameter, si

__all__ = ["Body", "Described", "Drive", "Frame", "Load", "OnShaft", "Parameter", "Part", "Point", "Release", "si"]


class Part(Described, ABC):
    """A part states its kinetic and potential energy, its dissipation and the power applied to it.

    Its fields made by ``si`` are given as a number in SI or a string with a unit. Every one of them that is given
    becomes a parameter ``path.field`` of the machine. A part is checked when it is built, from a file or in Python:
    ``InputError`` for what no real part can have.
    """

    own_states: ClassVar[tuple[OwnState, ...]] = ()

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

    name: str = Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$", title="name", description="name in parameters and results")
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
    """What acts on the shaft of one body: a torque that depends on its speed."""

    on: str = Field("", title="name of the body", description="name of the body, by default the machine's only rotor")
    label: str = Field("", exclude=True)
    group: ClassVar[str] = ""

    @property
    def path(self) -> str:
        """``drive`` for the only drive, ``drives.BODY`` where a machine has several; loads likewise."""
        return f"{self.group}s.{self.label}" if self.label else self.group

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """The torque at a speed: of a drive in the direction of positive speeds, of a load against it; zero if not given."""
        return sp.S.Zero

    def on_body(self, speed: sp.Expr) -> sp.Expr:
        """The torque on the body at its speed: that of ``torque``, but for a drive with a transmission."""
        return self.torque(speed)

    def torque_at(self, speed: float) -> float:
        """The torque on the body in N m at a speed in rad/s, in numbers."""
        w = sp.Symbol("speed", real=True)
        return self.number(self.on_body(w).subs(w, speed))

    def made_of(self) -> tuple[str, ...]:
        """What its parameters were made of, in words, where they are not as given."""
        return ()

    def doubts(self) -> tuple[str, ...]:
        """Warnings: what runs but is doubtful."""
        return ()


class Drive(OnShaft):
    """A drive acts on one body. Its stator stands on the foundation, or on the carrier, which then feels its reaction."""

    group: ClassVar[str] = "drive"
    stator: Literal["foundation", "carrier"] = Field("foundation", description="base of the stator, which feels its reaction")
    transmission: Transmission | None = Field(
        None, description="gear or belt, { ratio = ..., inertia = ..., efficiency = ... }"
    )

    @model_validator(mode="after")
    def _loses_what_it_gives(self) -> Self:
        if self.transmission is not None and self.transmission.efficiency is not None and self.prescribed() is not None:
            raise ValueError("transmission", "must be one without efficiency: this drive enforces a speed, whatever that takes")
        return self

    def prescribed(self) -> sp.Expr | None:
        """The speed it enforces on its own side of a transmission, or None if it applies a torque."""
        return None

    def no_load_path(self) -> str | None:
        """The path of the parameter that is the speed at which its torque is zero, None where none is."""
        return None

    def synchronous_speed(self) -> float | None:
        """The synchronous speed in rad/s, None where the drive has no slip."""
        return None

    def held_speed(self) -> float | None:
        """The speed of the body in rad/s at which any torque within limits is given, None where it follows from the speed."""
        return None

    def breakdown(self) -> tuple[float, float, float] | None:
        """Slip, speed in rad/s and torque in N m at which it pulls out, None where it does not."""
        return None

    def start_angle(self) -> float:
        """The angle at t = 0 of a body whose motion is prescribed: the field ``angle``, if there is one."""
        return float(getattr(self, "angle", 0.0))

    @property
    def ratio(self) -> sp.Expr:
        """The speed of the motor over that of the body."""
        return sp.S.One if self.transmission is None else self.transmission.symbol(self.path, "ratio")

    def prescribed_on_body(self) -> sp.Expr | None:
        """The speed of the body that it enforces."""
        speed = self.prescribed()
        return speed if speed is None or self.transmission is None else speed / self.ratio

    def reduced(self, speed: sp.Expr, law: Callable[[sp.Expr], sp.Expr] | None = None) -> tuple[sp.Expr, sp.Expr]:
        """The motor's torque on the body at a speed of the body, and what the transmission takes of it, against the speed.

        law: its torque at its own speed, by default that of steady operation.
        """
        law = law or self.torque
        if self.transmission is None:
            return law(speed), sp.S.Zero
        torque = self.ratio * law(self.ratio * speed)
        return torque, self.transmission.lost(self.path, torque, speed)

    def on_body(self, speed: sp.Expr) -> sp.Expr:
        """What arrives at the body."""
        torque, lost = self.reduced(speed)
        return torque - lost

    def reduced_synchronous_speed(self) -> float | None:
        """The speed of the body in rad/s at which there is no slip."""
        synchronous = self.synchronous_speed()
        return synchronous if synchronous is None or self.transmission is None else synchronous / self.transmission.ratio

    def reduced_breakdown(self) -> tuple[float, float, float] | None:
        """Slip, speed of the body in rad/s and torque on it in N m at which the drive pulls out."""
        found = self.breakdown()
        if found is None or self.transmission is None:
            return found
        slip, speed = found[0], found[1] / self.transmission.ratio
        return slip, speed, self.torque_at(speed)

    def reduced_inertia(self) -> sp.Expr:
        """The inertia on the motor's side, as the body feels it."""
        return sp.S.Zero if self.transmission is None else self.transmission.symbol(self.path, "inertia") * self.ratio**2

    def energies(self, frame: Frame) -> Energies:
        """The torque, on the speed of the body against the stator; through a transmission with what that loses and stores."""
        return self.acting(frame, self.torque)

    def acting(self, frame: Frame, law: Callable[[sp.Expr], sp.Expr]) -> Energies:
        """The same with a law of the motor's torque at its own speed."""
        base = frame.rotation if self.stator == "carrier" else sp.S.Zero
        speed = frame.speed(self.on) - base
        torque, lost = self.reduced(speed, law)
        motor = Applied(torque, speed, name=self.path)
        if self.transmission is None:
            return Energies(applied=(motor,))
        taken = () if lost == 0 else (Applied(-lost, speed, f"{self.path}.transmission", "lost", of_drive=True),)
        turning = base + self.ratio * speed
        return Energies(kinetic=self.transmission.symbol(self.path, "inertia") * turning**2 / 2, applied=(motor, *taken))

    def linearised(self, speed: float) -> tuple[float, float]:
        """Slope and no-load speed of the straight line through a working point: torque = slope (no_load_speed - speed).

        speed: of the body, in rad/s. Returns slope in N m s, positive where the torque falls, and the no-load speed in rad/s,
        infinite where the torque does not depend on the speed.
        """
        w = sp.Symbol("speed", real=True)
        torque, slope = self.torque_at(speed), -self.number(sp.diff(self.on_body(w), w).subs(w, speed))
        return slope, speed + torque / slope if slope else math.copysign(math.inf, torque)


class Load(OnShaft):
    """A load on one body: it takes work out of its rotation."""

    group: ClassVar[str] = "load"

    def energies(self, frame: Frame) -> Energies:
        """The torque against the speed of the body, booked as lost."""
        speed = frame.speed(self.on)
        return Energies(applied=(Applied(-self.torque(speed), speed, name=self.path, booked="lost"),))
