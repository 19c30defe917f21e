"""Bodies of one track, which cannot pass each other."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

import sympy as sp
from pydantic import BeforeValidator, Field

from wucht.errors import FieldError, InputError
from wucht.machines.parts.base import Body
from wucht.schema import SI, Unit, si

RESTITUTION = 0.5


def _angle(value: Any) -> float | None:
    return None if value is None else Unit("rad", "angle at the start").parse_quantity(value)


# The start of a motion is not a parameter of the machine.
Start = Annotated[float | None, BeforeValidator(_angle)]


class TrackBody(Body):
    """A body that turns about another, and may share a circular track with others. Without ``track`` it can pass them."""

    track: str | None = Field(default=None, pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$", title="name of the track", description=(
        "name of the track that bodies share; without one a body can pass the others"
    ))  # fmt: skip
    diameter: SI[float | None] = si("m", "diameter", "d", default=None, gt=0, help="diameter of the body on its track")
    restitution: SI[float | None] = si("", "coefficient of restitution", "e_c", default=None, ge=0.01, le=1)
    start: Start = Field(default=None, description="angle at the start in rad, from the body turned about")
    about: str = Field(description="name of the body turned about")
    mass: SI[float] = si("kg", "mass", "m", gt=0, help="mass of the body")

    @abstractmethod
    def centre_radius(self) -> float:
        """Radius of the circle on which the body's centre runs, in m."""

    @abstractmethod
    def axis_inertia(self) -> sp.Expr:
        """The moment of inertia about its axis."""

    def width(self) -> float | None:
        """The diameter in m, None if it is not given."""
        return self.diameter

    def check_track(self) -> None:
        """Check that a body of a track has a diameter. Raises ``ValueError(field, sentence)``."""
        if self.track is None:
            for key in ("diameter", "restitution"):
                if getattr(self, key) is not None:
                    raise ValueError(key, "allowed only with track = NAME: bodies without a track can pass each other")
            return
        width = self.width()
        if width is None:
            raise FieldError("diameter", "this key is missing; bodies of a track need their diameter in m", code="missing")
        if width >= 2 * self.centre_radius():
            raise ValueError("diameter", f"must be less than twice the radius of the track, {2 * self.centre_radius():g} m")


@dataclass(frozen=True)
class Track:
    """The bodies of a track, in the order of the file.

    frequency: of its contacts, in rad/s; is_frequency_given: in the file. order: the names, counter-clockwise.
    """

    name: str
    bodies: tuple[TrackBody, ...]
    frequency: float
    is_frequency_given: bool = False
    order: tuple[str, ...] = ()

    def symbol(self, key: str) -> sp.Symbol:
        """The symbol of a parameter of the track."""
        return sp.Symbol(f"tracks.{self.name}.{key}", real=True)

    def with_values(self, values: Mapping[str, float]) -> Track:
        """Return the track with the frequency that is among values of parameters, as if the file gave it.

        Raises ``InputError`` for one that is not allowed.
        """
        path = self.symbol("contact_frequency").name
        if path not in values:
            return self
        check_frequency(values[path], values[path], path)
        return replace(self, frequency=values[path], is_frequency_given=True)


def check_frequency(frequency: float, value: object, location: str) -> None:
    """Raise ``InputError`` for a frequency of contacts that is not allowed. value: as it is given."""
    if frequency <= 0:
        raise InputError(location, value, "must be a contact frequency greater than 0")
