"""Base classes of parts: a few physical quantities and the energies made of them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Literal, Self

import sympy as sp
from pydantic import Field, model_validator

from wucht.machines.parts.frame import Frame, Point
from wucht.machines.parts.release import Release
from wucht.machines.parts.transmission import Transmission
from wucht.mechanics.energies import AppliedForce, Energies, StateDescription
from wucht.mechanics.lagrange import Coordinate
from wucht.schema import SI, Composite, Parameter, TableModel, composite, si

__all__ = ["SI", "Body", "Drive", "Frame", "Load", "Parameter", "Part", "Point", "Release", "ShaftPart", "TableModel", "si"]


class Part(TableModel, ABC):
    """A part states its kinetic and potential energy, its dissipation and the power applied to it.

    Its fields made by ``si`` are given as a number in SI or a string with a unit. Every one of them that is given
    becomes a parameter ``path.field`` of the machine. A part is checked when it is built, from a file or in Python:
    ``InputError`` for what no real part can have.
    """

    internal_states: ClassVar[tuple[StateDescription, ...]] = ()

    @property
    @abstractmethod
    def path(self) -> str:
        """Prefix of the parameters of this part: ``path.field``."""

    @abstractmethod
    def energies(self, frame: Frame) -> Energies:
        """Return the formulas of the part."""

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Return the coordinates the part brings along."""
        return ()

    def arms(self) -> Mapping[str, sp.Expr]:
        """Return the distances of the centres of mass of rigid bodies from their axes, by body, as far as known to the part."""
        return {}

    def shaking(self) -> tuple[sp.Symbol, sp.Symbol] | None:
        """Return amplitude and angular frequency of a harmonic motion that the part prescribes."""
        return None

    def supported_directions(self) -> Mapping[str, str]:
        """Return the carrier's coordinates, by label, on which another one rests: ``{"foundation": "y"}``."""
        return {}

    def check(self) -> None:
        """Raise ``ValueError(field, sentence)`` where the values cannot be those of a real part; called when it is built."""

    @model_validator(mode="after")
    def _check_itself(self) -> Self:
        self.check()
        return self

    def derivation_notes(self) -> tuple[str, ...]:
        """Return notes on the origin of its parameters, where they are derived from other data."""
        return ()

    def doubts(self) -> tuple[str, ...]:
        """Warnings: what runs but is doubtful."""
        return ()

    def number(self, expression: sp.Expr) -> float:
        """Return the value of an expression in the part's parameters."""
        values = {sp.Symbol(p.path, real=True): sp.Float(p.value) for p in self.parameters()}
        return float(sp.sympify(expression).xreplace(values))

    def symbol(self, name: str) -> sp.Symbol:
        """Return the symbol of one of the part's parameters."""
        return sp.Symbol(f"{self.path}.{name}" if self.path else name, real=True)

    def symbols(self, *names: str) -> tuple[sp.Symbol, ...]:
        """Return the symbols of several parameters."""
        return tuple(self.symbol(n) for n in names)

    def parameters(self) -> tuple[Parameter, ...]:
        """Return the part's parameters, each with path, value, unit and symbol: its quantities that are given."""
        return self.parameters_at(self.path)


class Body(Part):
    """A body of the machine, on the carrier or on another body (``about``)."""

    name: str = Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$", title="name", description="name in parameters and results")
    release: Composite[Release | None] = composite(
        default=None, description="release of the body, { time = ... } or { speed = ... }"
    )

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
        """True if the body's coordinate is its absolute angle."""
        return True

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Return the absolute angle, counter-clockwise from +x to the centre of mass."""
        return (Coordinate.from_names(f"{self.name}.angle", f"{self.name}.speed", angle=True),)

    def moment(self) -> sp.Expr:
        """Return the unbalance: mass times the distance of the centre of mass from the axis."""
        return sp.S.Zero

    def moment_along_guide(self) -> sp.Expr:
        """Return the derivative of its unbalance by the displacement of the mass that slides in it."""
        return sp.S.Zero

    def largest_moment(self) -> sp.Expr:
        """Return the largest unbalance that it can have."""
        return self.moment()

    def couple(self) -> sp.Expr | None:
        """Return the couple unbalance, m e a of 001 (10), None where it has none."""
        return None

    def axis_inertia(self) -> sp.Expr | None:
        """Return the moment of inertia about its axis, None where it is not defined."""
        return None

    def place(self) -> tuple[sp.Expr, sp.Expr] | None:
        """Return the position of its axis on the carrier, None for the centre."""
        return None

    def is_on_axis(self) -> bool:
        """True if it turns about the very axis of ``about``."""
        return True

    def moment_on_reference(self) -> sp.Expr:
        """Return its share in the unbalance of the body it turns about, as a complex number in that body's frame."""
        return sp.S.Zero


class ShaftPart(Part):
    """A part that acts on the shaft of one body: a torque that depends on its speed."""

    on: str = Field(default="", title="name of the body", description="name of the body, by default the machine's only rotor")
    label: str = Field(default="", exclude=True)
    group: ClassVar[str] = ""

    @property
    def path(self) -> str:
        """``drive`` for the only drive, ``drives.BODY`` where a machine has several; loads likewise."""
        return f"{self.group}s.{self.label}" if self.label else self.group

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        """Refuse a kind that states neither a torque nor a speed. Raises ``TypeError``."""
        super().__pydantic_init_subclass__(**options)
        base = next(c for c in reversed(cls.__mro__) if issubclass(c, ShaftPart) and c.group)
        methods = ("torque", "prescribed_speed", "energies")
        if getattr(cls, "kind", "") and all(getattr(cls, name, None) is getattr(base, name, None) for name in methods):
            raise TypeError(f"{cls.__name__}, a {cls.group} of the kind {cls.kind!r}, must have a method torque(self, speed)")

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """Return the torque at a speed: of a drive in the direction of positive speeds, of a load against it.

        Zero of a drive that enforces a speed.
        """
        return sp.S.Zero

    def body_torque(self, speed: sp.Expr) -> sp.Expr:
        """Return the torque on the body at its speed: that of ``torque``, but for a drive with a transmission."""
        return self.torque(speed)

    def torque_at(self, speed: float) -> float:
        """Return the torque on the body in N m at a speed in rad/s, as a number."""
        w = sp.Symbol("speed", real=True)
        return self.number(self.body_torque(w).subs(w, speed))


class Drive(ShaftPart):
    """A drive of one body. Its stator rests on the foundation, or on the carrier, which then bears its reaction."""

    group: ClassVar[str] = "drive"
    stator: Literal["foundation", "carrier"] = Field(
        default="foundation", description="base of the stator, which bears its reaction"
    )
    transmission: Composite[Transmission | None] = composite(
        default=None, description="gear or belt, { ratio = ..., inertia = ..., efficiency = ... }"
    )

    @model_validator(mode="after")
    def _check_transmission(self) -> Self:
        if self.transmission is not None and self.transmission.efficiency is not None and self.prescribed_speed() is not None:
            raise ValueError("transmission", "must be one without efficiency: this drive enforces a speed, at any torque")
        return self

    def prescribed_speed(self) -> sp.Expr | None:
        """Return the speed it enforces on the motor's side of a transmission, or None if it applies a torque."""
        return None

    def estimates(self) -> tuple[str, ...]:
        """Return what is estimated because no one gave it, each with its range, as text."""
        return ()

    def circuit_loss(self, speed: sp.Expr) -> sp.Expr | None:
        """Return the heat in its circuit at a speed, in W: the power from the supply less that of the torque at the speed.

        None of a drive that is known by its torque alone.
        """
        return None

    def no_load_path(self) -> str | None:
        """Return the path of the parameter that is the speed at which its torque is zero, None where there is none."""
        return None

    def synchronous_speed(self) -> float | None:
        """Return the synchronous speed in rad/s, None where the drive has no slip."""
        return None

    def held_speed(self) -> float | None:
        """Return the speed of the body in rad/s that is held at any torque within limits, None without such a speed."""
        return None

    def breakdown(self) -> tuple[float, float, float] | None:
        """Return slip, speed in rad/s and torque in N m at which it pulls out, None where it does not."""
        return None

    def start_angle(self) -> float:
        """Return the angle at t = 0 of a body whose motion is prescribed: the field ``angle``, if there is one."""
        return float(getattr(self, "angle", 0.0))

    @property
    def ratio(self) -> sp.Expr:
        """The speed of the motor over that of the body."""
        return sp.S.One if self.transmission is None else self.transmission.symbol(self.path, "ratio")

    def prescribed_body_speed(self) -> sp.Expr | None:
        """Return the speed of the body that it enforces."""
        speed = self.prescribed_speed()
        return speed if speed is None or self.transmission is None else speed / self.ratio

    def reduced_torque(self, speed: sp.Expr, law: Callable[[sp.Expr], sp.Expr] | None = None) -> tuple[sp.Expr, sp.Expr]:
        """Return the motor's torque on the body at a speed of the body, and the loss of the transmission, against the speed.

        law: the motor's torque over its speed, by default that of steady operation.
        """
        law = law or self.torque
        if self.transmission is None:
            return law(speed), sp.S.Zero
        torque = self.ratio * law(self.ratio * speed)
        return torque, self.transmission.loss_torque(self.path, torque, speed)

    def body_torque(self, speed: sp.Expr) -> sp.Expr:
        """Return the torque that arrives at the body."""
        torque, loss = self.reduced_torque(speed)
        return torque - loss

    def reduced_synchronous_speed(self) -> float | None:
        """Return the speed of the body in rad/s at which there is no slip."""
        synchronous = self.synchronous_speed()
        return synchronous if synchronous is None or self.transmission is None else synchronous / self.transmission.ratio

    def reduced_breakdown(self) -> tuple[float, float, float] | None:
        """Return slip, speed of the body in rad/s and torque on it in N m at which the drive pulls out."""
        point = self.breakdown()
        if point is None or self.transmission is None:
            return point
        slip, speed = point[0], point[1] / self.transmission.ratio
        return slip, speed, self.torque_at(speed)

    def reduced_inertia(self) -> sp.Expr:
        """Return the inertia on the motor's side, reduced to the body."""
        return sp.S.Zero if self.transmission is None else self.transmission.symbol(self.path, "inertia") * self.ratio**2

    def energies(self, frame: Frame) -> Energies:
        """Return the power of the torque at the speed against the stator; with loss and kinetic energy of a transmission."""
        return self.torque_energies(frame, self.torque)

    def torque_energies(self, frame: Frame, law: Callable[[sp.Expr], sp.Expr]) -> Energies:
        """Return the energies for a law of the motor's torque over its speed."""
        base = frame.rotation if self.stator == "carrier" else sp.S.Zero
        speed = frame.speed(self.on) - base
        torque, loss = self.reduced_torque(speed, law)
        motor = AppliedForce(torque, speed, name=self.path)
        if self.transmission is None:
            return Energies(applied_forces=(motor,))
        transmission_loss = (
            () if loss == 0 else (AppliedForce(-loss, speed, f"{self.path}.transmission", "lost", of_drive=True),)
        )
        turning = base + self.ratio * speed
        return Energies(
            kinetic=self.transmission.symbol(self.path, "inertia") * turning**2 / 2, applied_forces=(motor, *transmission_loss)
        )

    def linearisation(self, speed: float) -> tuple[float, float]:
        """Return slope and no-load speed of the tangent at a working point: torque = slope (no_load_speed - speed).

        speed: of the body, in rad/s. Returns slope in N m s, positive where the torque falls, and the no-load speed in rad/s,
        infinite where the torque does not depend on the speed.
        """
        w = sp.Symbol("speed", real=True)
        torque, slope = self.torque_at(speed), -self.number(sp.diff(self.body_torque(w), w).subs(w, speed))
        return slope, speed + torque / slope if slope else math.copysign(math.inf, torque)


class Load(ShaftPart):
    """A load on one body: it dissipates work of its rotation."""

    group: ClassVar[str] = "load"

    def energies(self, frame: Frame) -> Energies:
        """Return the torque against the speed of the body, booked as lost."""
        speed = frame.speed(self.on)
        return Energies(applied_forces=(AppliedForce(-self.torque(speed), speed, name=self.path, energy_side="lost"),))
