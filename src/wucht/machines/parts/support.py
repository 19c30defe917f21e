"""The common base of carriers: a prescribed motion, and springs and dampers by natural frequency and damping ratio."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, Literal, Self

import sympy as sp
from pydantic import Field, ValidationInfo, field_validator, model_validator

from wucht.errors import FieldError
from wucht.machines.parts.base import Body, Frame, Part, Point
from wucht.mechanics.lagrange import Coordinate
from wucht.piecewise import Pieces, PiecewiseCubic, interpolated_pieces
from wucht.schema import SI, Composite, Parameter, TableModel, Unit, composite, is_pairs, si
from wucht.system import TIME

SHAKING = sp.symbols("carrier.motion.amplitude carrier.motion.frequency", real=True)
Pair = float | tuple[float, float]  # of x and y, or one that holds for both
Inertia = Callable[[str], float]  # the mass or moment of inertia that moves with a coordinate of the carrier, by its label
_UNITS = {
    "stiffness": "N/m", "damping": "N s/m", "rotation_stiffness": "N m", "rotation_damping": "N m s",
}  # fmt: skip
NO_TUNING = dict.fromkeys(("rotation_frequency", "rotation_damping_ratio"))  # once their spring and damper are known
_STRONGEST = 1e7  # m/s^2: in ultracentrifuges; bodies swing the faster, the stronger it is


class PrescribedMotion(TableModel):
    """x = amplitude cos(frequency t), Sperling et al. (13), or a measured displacement as points (time, displacement).

    Between points the displacement is a cubic spline, so that its velocity and acceleration are continuous; before the first
    and after the last it holds still, so the spline begins and ends with zero velocity.
    """

    direction: Literal["x", "y", "r"] = Field(title="direction", description="direction of the motion, r: of the rotation")
    amplitude: SI[float | None] = si(
        "m", "amplitude", "x_0", default=None, help="amplitude of a harmonic motion, in direction r an angle"
    )
    frequency: SI[float | None] = si(
        "rad/s", "angular frequency", "Omega", default=None, gt=0, help="frequency of a harmonic motion"
    )
    points: Composite[tuple[tuple[float, float], ...] | None] = composite(
        default=None,
        min_length=4,
        title="points (time, displacement)",
        description="points (time, displacement) of a measured motion",
    )

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, value: Any, info: ValidationInfo) -> Any:
        """Read amplitude and displacements as lengths, in direction r as angles; points may have units."""
        length, name = "rad" if info.data.get("direction") == "r" else "m", info.field_name
        if value is None or name == "direction":
            return value
        if name != "points":
            return (Unit("rad/s", "angular frequency") if name == "frequency" else Unit(length, "amplitude")).parse_quantity(
                value
            )
        if not is_pairs(value):
            raise ValueError("must be points = [[time, displacement], ...]")
        units = Unit("s", "time"), Unit(length, "displacement")
        return [[u.parse_quantity(x) for u, x in zip(units, point, strict=True)] for point in value]

    @model_validator(mode="after")
    def _check_alternatives(self) -> PrescribedMotion:
        flags = [self.amplitude is not None, self.frequency is not None, self.points is not None]
        if flags not in ([True, True, False], [False, False, True]):
            sentence = "give amplitude and frequency, or table = FILE (points = [[time, displacement], ...])"
            raise FieldError(sentence, code="either-or")
        if self.points is not None and any(b[0] <= a[0] for a, b in zip(self.points, self.points[1:], strict=False)):
            raise ValueError("must be points whose times increase")
        return self

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """Return amplitude and frequency; the amplitude in direction r is an angle."""
        length = "rad" if self.direction == "r" else "m"
        return tuple(replace(p, unit=length if p.unit == "m" else p.unit) for p in super().parameters_at(path))

    def velocity(self) -> sp.Expr:
        """Return the velocity over time."""
        if self.points is not None:
            return PiecewiseCubic(TIME, self._spline().derivative)
        amplitude, frequency = SHAKING
        return -amplitude * frequency * sp.sin(frequency * TIME)

    def start(self) -> float:
        """Return the displacement at t = 0."""
        return float(self._spline()(0.0)) if self.points is not None else float(self.amplitude or 0.0)

    def _spline(self) -> Pieces:
        times, values = zip(*(self.points or ()), strict=True)
        return interpolated_pieces("motion", times, values, "spline")


def tuned_stiffness(inertia: float, frequency: Pair) -> Pair:
    """Return c for a natural frequency in rad/s."""
    return map_components(lambda w: inertia * w**2, frequency)


def tuned_damping(inertia: float, stiffness: Pair, ratio: Pair) -> Pair:
    """Return b for a damping ratio."""
    return map_components(lambda c, d: 2 * d * math.sqrt(c * inertia), stiffness, ratio)


def tuned_rotation(carrier: Any, inertia: Inertia) -> dict[str, Pair]:
    """Return spring and damper of a carrier's rotation, by their keys, as far as its frequency and ratio determine them."""
    tuning: dict[str, Pair] = {}
    if carrier.rotation_frequency is not None:
        tuning["rotation_stiffness"] = tuned_stiffness(inertia("r"), carrier.rotation_frequency)
    if carrier.rotation_damping_ratio is not None:
        stiffness = tuning.get("rotation_stiffness", carrier.rotation_stiffness or 0.0)
        tuning["rotation_damping"] = tuned_damping(inertia("r"), stiffness, carrier.rotation_damping_ratio)
    return tuning


def refuse_both(carrier: Any, first: str, second: str) -> None:
    """Raise ``ValueError(field, sentence)`` where two keys state the same quantity."""
    if getattr(carrier, second) is not None and first in carrier.model_fields_set and getattr(carrier, first) is not None:
        raise FieldError(second, f"give either {first} or {second}", code="either-or")


def refuse_rotation_both_ways(carrier: Any) -> None:
    """Raise ``ValueError(field, sentence)`` where the rotation's spring or damper is given in two ways, or has no spring."""
    refuse_both(carrier, "rotation_stiffness", "rotation_frequency")
    refuse_both(carrier, "rotation_damping", "rotation_damping_ratio")
    spring = carrier.rotation_stiffness if carrier.rotation_frequency is None else carrier.rotation_frequency
    refuse_ratio_without_spring("rotation_damping_ratio", carrier.rotation_damping_ratio, spring)


def refuse_ratio_without_spring(key: str, ratio: Pair | None, spring: Pair | None) -> None:
    """Raise ``ValueError(field, sentence)`` for a damping ratio in a direction without a spring. spring: or a frequency."""
    missing = map_components(lambda d, c: float(d > 0 and c == 0), ratio or 0.0, spring or 0.0)
    if missing == 1.0 or (isinstance(missing, tuple) and any(missing)):
        raise FieldError(
            key, "must go with a stiffness or frequency above 0: without a spring no damping is critical", code="no-stiffness"
        )


def map_components(function: Callable[..., float], *values: Pair) -> Pair:
    """Apply a function to the values of both directions: one number where all are."""
    if not any(isinstance(v, tuple) for v in values):
        return function(*values)
    pairs = [v if isinstance(v, tuple) else (v, v) for v in values]
    return function(*(x for x, _ in pairs)), function(*(y for _, y in pairs))


def tuning_text(values: Mapping[str, Pair | None], inertia: str) -> str:
    """Return the values that follow from frequency and damping ratio, by key, as text. inertia: used for them, as text."""
    entries = (f"{key} {format_pair(value)} {_UNITS[key]}" for key, value in values.items())
    return f"{', '.join(entries)}, from frequency or damping ratio with {inertia}"


def format_pair(value: Pair | None) -> str:
    """Return the value of both directions, or each, as text."""
    return " and ".join(f"{v:.6g}" for v in (value if isinstance(value, tuple) else (value or 0.0,)))


class Support(Part):
    """A carrier: the coordinates of the support of the bodies, and the positions of their axes."""

    gravity: SI[float] = si("m/s^2", "acceleration of gravity", "g", default=0.0, ge=-_STRONGEST, le=_STRONGEST)
    directions: str = Field(default="xy", description="directions in which the carrier moves")
    motion: Composite[PrescribedMotion | None] = composite(
        default=None, description="prescribed motion, a table: `[machine.carrier.motion]`"
    )

    @property
    def path(self) -> str:
        """``carrier``."""
        return "carrier"

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the coordinates: x, y, r, foundation."""
        return tuple(self.directions)

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Return the displacements, and the angle, from where the springs are free of force."""
        names = [d for d in self.labels if d != "foundation"]
        return tuple(
            Coordinate.from_names(f"carrier.{d}", f"carrier.v{d}", prescribed_velocity=self.prescribed_velocity(d))
            for d in names
        )

    def component(self, name: str, direction: str) -> sp.Expr:
        """Return the symbol of a stiffness or damping in a direction."""
        value = getattr(self, name)
        if value is None:
            return sp.S.Zero
        return self.symbol(f"{name}.{direction}" if isinstance(value, tuple) else name)

    def reference_frame(self) -> Frame:
        """Return the frame without bodies."""
        coordinates = dict(zip(self.labels, self.coordinates(), strict=True))
        rotation = coordinates["r"].velocity if "r" in coordinates else sp.S.Zero
        return Frame(centre=Point.from_coordinates(coordinates), rotation=rotation, gravity=self.symbol("gravity"))

    def axis_at(self, position: tuple[sp.Expr, sp.Expr]) -> Point:
        """Return position and velocity of an axis at a place (a, b) on the carrier: (x - b chi, y + a chi) for an angle chi."""
        frame, (a, b) = self.reference_frame(), position
        at = frame.centre
        if frame.rotation == 0:
            return at
        chi = self.coordinates()[self.labels.index("r")]
        vx, vy = at.vx - b * chi.velocity, at.vy + a * chi.velocity
        return Point(at.x - b * chi.position, at.y + a * chi.position, vx, vy)

    def check_body(self, body: Body) -> None:
        """Raise ``ValueError(field, sentence)`` where a body cannot be on this carrier."""
        if body.place() is not None:
            raise ValueError("position", f"allowed only on a carrier 'xyr'; this one is {self.directions!r}")
        self.check_couple(body)

    def check_couple(self, body: Body) -> None:
        """Raise ``ValueError(field, sentence)`` for a couple unbalance, which acts only on a carrier that tilts."""
        if body.couple() is not None:
            raise ValueError("couple_unbalance", f"allowed only on a carrier 'r'; this one is {self.directions!r}")

    def with_bodies(self, bodies: Iterable[Body]) -> Self:
        """Return the carrier with these bodies on it."""
        return self

    def tune_springs(self, inertia: Inertia) -> tuple[Self, str]:
        """Return the carrier with springs and dampers from natural frequencies, and a text of their values; empty without any.

        inertia: in kg, or kg m^2, of all that moves with a coordinate.
        """
        return self, ""

    def prescribed_velocity(self, label: str) -> sp.Expr | None:
        """Return the velocity of a coordinate whose motion is given, None if it is free."""
        return self.motion.velocity() if self.motion is not None and self.motion.direction == label else None

    def shaking(self) -> tuple[sp.Symbol, sp.Symbol] | None:
        """Return amplitude and frequency of the prescribed motion, unless it is a table."""
        return None if self.motion is None or self.motion.points is not None else SHAKING

    def start_positions(self) -> Mapping[str, float]:
        """Return the displacements at t = 0 of the coordinates whose motion is given, by label."""
        return {self.motion.direction: self.motion.start()} if self.motion is not None else {}

    def check_motion(self) -> None:
        """Check that the motion is in a direction of the carrier. Raises ``ValueError(field, sentence)``."""
        if self.motion is not None and self.motion.direction not in self.labels:
            sentence = f"must be a direction of the carrier: {', '.join(self.labels) or 'it has none'}"
            raise FieldError("motion", sentence, code="direction")


def is_negative(value: float | tuple[float, ...] | None) -> bool:
    """True if a stiffness or damping, or one of a pair, is below zero."""
    return any(v < 0 for v in (value if isinstance(value, tuple) else (value or 0.0,)))
