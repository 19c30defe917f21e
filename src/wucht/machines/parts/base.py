"""What a part is: a few physical quantities and the energies made of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import sympy as sp
from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.quantities import Unit


def si(unit: str, what: str, symbol: str, default: Any = ..., alias: str | None = None, **limits: Any) -> Any:
    """A field that holds a physical quantity: its SI unit, its name in words, its symbol in equations, its limits (gt, ge)."""
    return Field(default, alias=alias, description=what, json_schema_extra={"unit": unit, "symbol": symbol}, **limits)


def unit_of(cls: type[BaseModel], name: str) -> Unit | None:
    """The unit of a field made by ``si``, None for other fields."""
    extra = cls.model_fields[name].json_schema_extra
    if not isinstance(extra, dict):
        return None
    return Unit(str(extra["unit"]), cls.model_fields[name].description or name, str(extra["symbol"]))


@dataclass(frozen=True)
class Parameter:
    """A number of a machine: its path, value, unit, symbol in equations and name in words."""

    path: str
    value: float
    unit: str
    symbol: str
    what: str


@dataclass(frozen=True)
class Frame:
    """Where bodies live: position and velocity of the axis (zero where it is blocked), gravity, and all turning bodies."""

    x: sp.Expr = sp.S.Zero
    y: sp.Expr = sp.S.Zero
    vx: sp.Expr = sp.S.Zero
    vy: sp.Expr = sp.S.Zero
    gravity: sp.Expr = sp.S.Zero
    bodies: Mapping[str, Coordinate] = field(default_factory=dict)

    def angle(self, body: str) -> sp.Symbol:
        """The absolute angle of a body."""
        return self.bodies[body].position

    def speed(self, body: str) -> sp.Symbol:
        """The absolute angular velocity of a body."""
        return self.bodies[body].velocity

    def carried(self, mass: sp.Expr, unbalance: sp.Expr, body: str) -> Energies:
        """Energies of a mass carried by the axis, its centre off the axis: unbalance = mass times distance.

        T = m (x'^2 + y'^2)/2 + U phi' (-x' sin phi + y' cos phi), V = m g y + U g sin phi; the part of T that is
        quadratic in phi' belongs to the body's inertia about the axis.
        """
        phi, speed = self.angle(body), self.speed(body)
        return Energies(
            kinetic=mass * (self.vx**2 + self.vy**2) / 2 + unbalance * speed * (-self.vx * sp.sin(phi) + self.vy * sp.cos(phi)),
            potential=self.gravity * (mass * self.y + unbalance * sp.sin(phi)),
        )


class Part(BaseModel, ABC):
    """A part states its kinetic and potential energy, its dissipation and the power applied to it.

    Quantities are fields made by ``si``: given as a number in SI or a string with a unit. Every one of them that is given
    becomes a parameter ``path.field`` of the machine.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    kind: ClassVar[str] = ""
    not_yet: ClassVar[frozenset[str]] = frozenset()

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, given: Any, info: ValidationInfo) -> Any:
        unit = unit_of(cls, info.field_name) if info.field_name else None
        if unit is None or given is None:
            return given
        return [unit.parse(g) for g in given] if isinstance(given, list) else unit.parse(given)

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

    def check(self) -> None:
        """Raises ``ValueError(field, sentence)`` where the values cannot be those of a real part."""

    def symbol(self, name: str) -> sp.Symbol:
        """The symbol of one of the part's parameters."""
        return sp.Symbol(f"{self.path}.{name}", real=True)

    def symbols(self, *names: str) -> tuple[sp.Symbol, ...]:
        """The symbols of several parameters."""
        return tuple(self.symbol(n) for n in names)

    def parameters(self) -> tuple[Parameter, ...]:
        """The part's parameters: its quantities that are given, lists by component ``.x``, ``.y``."""
        found = []
        for name, described in type(self).model_fields.items():
            unit, value = unit_of(type(self), name), getattr(self, name)
            if unit is None or value is None:
                continue
            pairs = zip((".x", ".y"), value, strict=True) if isinstance(value, tuple) else (("", value),)
            for suffix, number in pairs:
                label = unit.symbol + (f"_{suffix[1:]}" if suffix else "")
                found.append(
                    Parameter(f"{self.path}.{described.alias or name}{suffix}", float(number), unit.si, label, unit.what)
                )
        return tuple(found)


class Body(Part):
    """A body that turns: it brings one angle."""

    name: str = Field(description="name", pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")
    not_yet: ClassVar[frozenset[str]] = frozenset({"release"})

    @property
    def path(self) -> str:
        """The body's name."""
        return self.name

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The absolute angle, counter-clockwise from +x to the centre of mass."""
        return (Coordinate.named(f"{self.name}.angle", f"{self.name}.speed", angle=True),)

    @abstractmethod
    def moment(self) -> sp.Expr:
        """The unbalance: mass times the distance of the centre of mass from the axis."""

    @property
    def reference(self) -> str | None:
        """The body it turns about, if any."""
        about = getattr(self, "about", None)
        return None if about is None else str(about)


class Drive(Part):
    """A drive acts between the foundation and one body."""

    on: str = Field(description="name of the driven body")
    several: bool = Field(False, exclude=True)

    @property
    def path(self) -> str:
        """``drive`` for the only one; ``drives.BODY`` where a machine has several."""
        return f"drives.{self.on}" if self.several else "drive"

    def prescribed(self) -> sp.Expr | None:
        """The speed it enforces, or None if it applies a torque."""
        return None

    def start_angle(self) -> float:
        """The angle at t = 0 of a body whose motion is prescribed."""
        return 0.0
