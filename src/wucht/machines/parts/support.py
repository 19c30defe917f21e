"""What carriers have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping

import sympy as sp

from wucht.machines.parts.base import Frame, Part, Point, si
from wucht.machines.parts.motion import Motion


class Support(Part):
    """A carrier: the coordinates of what bears the bodies, and where their axes are."""

    gravity: float = si("m/s^2", "acceleration of gravity", "g", 0.0)

    @property
    def path(self) -> str:
        """``carrier``."""
        return "carrier"

    @property
    @abstractmethod
    def labels(self) -> tuple[str, ...]:
        """What the coordinates are called: x, y, r, foundation."""

    @abstractmethod
    def placed(self) -> Frame:
        """The frame without bodies."""

    def axis_at(self, position: tuple[sp.Expr, sp.Expr]) -> Point:
        """Position and velocity of an axis at a place on the carrier."""
        return self.placed().centre

    def prescribed(self, label: str) -> sp.Expr | None:
        """The velocity of a coordinate whose motion is given, None if it is free."""
        motion: Motion | None = getattr(self, "motion", None)
        return motion.velocity() if motion is not None and motion.direction == label else None

    def start_positions(self) -> Mapping[str, float]:
        """Displacements at t = 0 of the coordinates whose motion is given, by label."""
        motion: Motion | None = getattr(self, "motion", None)
        return {motion.direction: motion.start()} if motion is not None else {}

    def check_motion(self) -> None:
        """The motion is in a direction that the carrier has. Raises ``ValueError(field, sentence)``."""
        motion: Motion | None = getattr(self, "motion", None)
        if motion is not None and motion.direction not in self.labels:
            raise ValueError("motion", f"allowed is a direction of the carrier: {', '.join(self.labels) or 'it has none'}")
