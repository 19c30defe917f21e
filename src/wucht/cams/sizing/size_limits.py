"""Permitted limits of a cam, and the smallest cam that keeps them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Protocol, Self

from pydantic import model_validator

from wucht.schema import SI, TableModel, si

Size = Literal["base", "blank"]
LARGEST_ANGLE = math.radians(89)


class CamLimits(TableModel):
    """Limits by which the cam is judged.

    With a pressure angle (for a flat face: with a least radius or a shaft radius) the smallest cam that keeps them is computed
    as well, in any case with a base circle that is not negative.
    """

    pressure_angle: SI[float | None] = si("rad", "largest pressure angle", default=None, gt=0)
    least_radius: SI[float | None] = si(
        "m", "least radius of curvature", default=None, ge=0, help="least radius of curvature where the contour is convex"
    )
    shaft_radius: SI[float | None] = si("m", "radius of the shaft or hub", default=None, ge=0, help=(
        "radius of the shaft or the hub, which the base circle must not be smaller than"
    ))  # fmt: skip
    contact_pressure: SI[float | None] = si("Pa", "largest contact pressure", default=None, gt=0)

    @model_validator(mode="after")
    def _check_pressure_angle(self) -> Self:
        if self.pressure_angle is not None and self.pressure_angle > LARGEST_ANGLE:
            raise ValueError("pressure_angle", f"must be at most {math.degrees(LARGEST_ANGLE):g} deg")
        return self


class Placeable(Protocol):
    """A follower. placing: its keys that a smaller or larger cam changes."""

    placing: ClassVar[tuple[str, ...]]


@dataclass(frozen=True)
class SmallestCam:
    """A cam as small as it can be.

    follower: that makes it this cam, in the frame of ``followers``. base_radius, largest_radius: in m, of the pitch curve of a
    roller, outside the contour by the distance ``inward``, else of the contour. least_radius: of curvature of the contour in m
    where it is convex, negative where it is undercut, infinite where it is nowhere convex; sharpest: the cam angle there.
    pressure_angle: the largest that is reached; binding: cam angles at which a permitted one is reached. face: the least and
    the largest distance from the rod's axis at which a face is touched, in m along +y. Angles in rad.
    """

    follower: Placeable
    base_radius: float
    largest_radius: float
    least_radius: float
    sharpest: float
    inward: float = 0.0
    pressure_angle: float | None = None
    binding: tuple[float, ...] = ()
    face: tuple[float, float] | None = None

    @property
    def placement(self) -> Mapping[str, float]:
        """The keys of the follower that make it this cam, in SI."""
        return {key: getattr(self.follower, key) for key in self.follower.placing}

    def summary(self) -> dict[str, Any]:
        """Return the summary of its contour, as in a result."""
        pressure_angle = {} if self.pressure_angle is None else {"max_pressure_angle": self.pressure_angle}
        return {
            "follower": dict(self.placement),
            "base_radius": self.base_radius - self.inward,
            "largest_radius": self.largest_radius - self.inward,
            "min_curvature_radius": self.least_radius if math.isfinite(self.least_radius) else None,
            **pressure_angle,
            **({} if self.face is None else {"face": list(self.face)}),
        }
