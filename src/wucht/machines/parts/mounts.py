"""The mounts of a carrier that is a rigid body in its plane: each by itself, or equal ones in a pattern."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from wucht.machines.parts.base import SI, si
from wucht.machines.parts.nameplate import Nameplate
from wucht.machines.parts.support import format_pair, is_negative, tuned_damping
from wucht.schema import TableModel, Unit, is_pairs

GRAVITY = 9.80665  # m/s^2, standard: 3rd CGPM (1901); under which springs deflect where the file gives none
_KEYS = {"line": ("count", "length"), "corners": ("length", "height")}  # keys of a pattern
_Places = tuple[tuple[float, float], ...]


class Mount(TableModel):
    """A spring and damper at a place on the carrier, measured from its centre of mass."""

    at: SI[tuple[float, float]] = si("m", "place", "a", help="place on the carrier, measured from its centre of mass")
    stiffness: SI[float | tuple[float, float] | None] = si("N/m", "stiffness", "c", default=None, help=(
        "stiffness of the spring, one for x and y, or a pair; without it a share of the stiffness that `frequency` requires"
    ))  # fmt: skip
    damping: SI[float | tuple[float, float]] = si(
        "N s/m", "damping", "b", default=(0.0, 0.0), help="viscous damping of the mount, one for x and y, or a pair"
    )


def _read_pattern(value: Any) -> Any:
    if isinstance(value, str) and value in _KEYS:
        return value
    if not value or not is_pairs(value):
        raise ValueError(f"must be places [[x, y], ...], or one of: {', '.join(_KEYS)}")
    place = Unit("m", "place")
    return tuple(tuple(place.parse_quantity(x) for x in pair) for pair in value)


_Pattern = Annotated[Literal["line", "corners"] | _Places, BeforeValidator(_read_pattern)]


class EqualMounts(Nameplate):
    """Equal mounts in a pattern, by one table; those side by side in the plane are at one place."""

    count: int | None = Field(default=None, ge=1, le=1000, description=(
        "number of mounts in all, by default one at each place of the pattern"
    ))  # fmt: skip
    pattern: _Pattern = Field(title="pattern of places", description=(
        "places [[x, y], ...] from the centre of mass; or `line` from end to end of `length`; or `corners`, also of `height`"
    ))  # fmt: skip
    length: SI[float | None] = si("m", "length", default=None, gt=0, help="length of the line, or of the rectangle")
    height: SI[float | None] = si("m", "height", default=None, gt=0, help="height of the rectangle of `corners`")
    at: SI[tuple[float, float] | None] = si("m", "middle of the pattern", default=None, help=(
        "middle of `line` or `corners`, by default the centre of mass"
    ))  # fmt: skip
    stiffness: SI[float | tuple[float, float] | None] = si("N/m", "stiffness of one mount", default=None, help=(
        "stiffness of one mount, one for x and y, or a pair; or give `static_deflection`"
    ))  # fmt: skip
    static_deflection: SI[float | None] = si("m", "static deflection", default=None, gt=0, help=(
        "deflection of the springs under the weight of the machine, from which their stiffness follows"
    ))  # fmt: skip
    stiffness_ratio: SI[float | None] = si("", "stiffness in x over that in y", default=None, gt=0, help=(
        "beside `static_deflection`, stiffness across the springs over that along them, by default 1"
    ))  # fmt: skip
    damping: SI[float | tuple[float, float] | None] = si("N s/m", "damping of one mount", default=None, help=(
        "viscous damping of one mount, one for x and y, or a pair; or give `damping_ratio`"
    ))  # fmt: skip
    damping_ratio: SI[float | tuple[float, float] | None] = si("", "damping ratio", default=None, help=(
        "damping ratio in x or y alone with all bodies on the carrier, from which the damping follows"
    ))  # fmt: skip

    @model_validator(mode="after")
    def _check_pattern(self) -> Self:
        needed = _KEYS.get(str(self.pattern), ())
        for key in ("count", "length", "height", "at"):
            is_given = getattr(self, key) is not None
            if key in needed and not is_given:
                raise ValueError(key, f"this key is missing; the pattern {self.pattern!r} needs it")
            if is_given and key not in (*needed, *(("count", "at") if needed else ("count",))):
                raise ValueError(key, "not allowed with this pattern, whose places are known without it")
        if self.pattern == "line" and self.count == 1:
            raise ValueError("count", "must be at least 2 in a line from end to end")
        if self.count is not None and self.count % len(self.places):
            raise ValueError("count", f"must be a multiple of {len(self.places)}, the number of places of the pattern")
        for first, second in (("stiffness", "static_deflection"), ("damping", "damping_ratio")):
            if getattr(self, first) is not None and getattr(self, second) is not None:
                raise ValueError(second, f"give either {first} or {second}")
        if self.stiffness_ratio is not None and self.static_deflection is None:
            raise ValueError("stiffness_ratio", "allowed only beside static_deflection: of a stiffness give a pair [x, y]")
        if self.damping_ratio is not None and self.stiffness is None and self.static_deflection is None:
            raise ValueError(
                "damping_ratio", "needs stiffness or static_deflection; beside `frequency` give that of the carrier"
            )
        for key in ("stiffness", "damping", "damping_ratio"):
            if is_negative(getattr(self, key)):
                raise ValueError(key, f"must be a {key.replace('_', ' ')} of at least 0")
        return self

    @property
    def places(self) -> _Places:
        """The places in m; several mounts may be at one."""
        if isinstance(self.pattern, tuple):
            return self.pattern
        (x, y), length, height = self.at or (0.0, 0.0), self.length or 0.0, self.height or 0.0
        if self.pattern == "corners":
            return tuple((x + i * length / 2, y + j * height / 2) for i in (-1, 1) for j in (-1, 1))
        return tuple((x + length * float(share), y) for share in np.linspace(-0.5, 0.5, self.count or 2))

    def mounts(self, mass: float, gravity: float) -> tuple[Mount, ...]:
        """Return the mounts, place after place. mass: of all that the springs carry, in kg. gravity: in m/s^2."""
        count, places = self.count or len(self.places), self.places
        stiffness, damping = self.stiffness, self.damping
        if self.static_deflection is not None:
            along = mass * gravity / self.static_deflection / count
            stiffness = along * (self.stiffness_ratio or 1.0), along
        if self.damping_ratio is not None and stiffness is not None:
            damping = tuned_damping(mass / count, stiffness, self.damping_ratio)
        one_mount = {"stiffness": stiffness, "damping": damping}
        values = {key: value for key, value in one_mount.items() if value is not None}
        return tuple(Mount(at=place, **values) for place in places for _ in range(count // len(places)))

    def note(self, mass: float, gravity: float) -> str:
        """Return stiffness and damping of one mount, as far as they follow from other values, as text."""
        origins = []
        if self.static_deflection is not None:
            origins.append(f"{mass:.5g} kg deflect them by {1e3 * self.static_deflection:.4g} mm under {gravity:.4g} m/s^2")
        if self.damping_ratio is not None:
            origins.append(f"damping ratio {format_pair(self.damping_ratio)}")
        if not origins:
            return ""
        count, first = self.count or len(self.places), self.mounts(mass, gravity)[0]
        stiffness, damping = (format_pair(value or 0.0) for value in (first.stiffness, first.damping))
        return f"{count} mounts, each with stiffness {stiffness} N/m, damping {damping} N s/m: {'; '.join(origins)}"
