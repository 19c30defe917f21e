"""A measured characteristic: points of speed and torque, and the curve through them."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from wucht.piecewise import Pieces, interpolated_pieces
from wucht.schema import Unit, is_pairs

SPEED_TORQUE = (Unit("rad/s", "speed"), Unit("N m", "torque"))


def _parse_points(value: Any) -> tuple[tuple[float, float], ...]:
    """Return points in SI from ``[[speed, torque], ...]``, numbers or strings with units. Raises ``ValueError``."""
    if not is_pairs(value):
        raise ValueError("must be pairs: [[speed, torque], ...]")
    if len(value) < 2:
        raise ValueError("must be at least 2 points [speed, torque]")
    points = [(SPEED_TORQUE[0].parse_quantity(w), SPEED_TORQUE[1].parse_quantity(t)) for w, t in value]
    for (before, _), (after, _) in pairwise(points):
        if after <= before:
            raise ValueError(f"must be increasing speeds; {after:g} rad/s follows {before:g} rad/s")
    return tuple(points)


# Points are no parameters: as a curve they can only be changed together.
Points = Annotated[
    tuple[tuple[float, float], ...], BeforeValidator(_parse_points), Field(description="points [[speed, torque], ...]")
]


def curve(name: str, points: tuple[tuple[float, float], ...]) -> Pieces:
    """Return the monotone cubic through the points; beyond its ends the torque of the end holds."""
    speeds, torques = zip(*points, strict=True)
    return interpolated_pieces(name, speeds, torques, kind="monotone")
