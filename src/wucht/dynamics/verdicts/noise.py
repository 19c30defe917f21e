"""Noise of a motion at rest, from rounding and the tolerance of an integration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE

_SPEED, _ANGLE = 1.0, 10.0  # times the tolerance: measured on random machines of all drives
_SPEED_ROUNDING, _ANGLE_ROUNDING = 1e-10, 1e-7


@dataclass(frozen=True)
class Noise:
    """Change of a number at rest from window to window: smaller changes are treated as zero.

    Attributes
    ----------
    speed : float
        For mean, lowest and highest speed averaged over turns, as a share of the speed.
    angle : float
        For a phase in rad; and for the residual of an unbalance, as a share of it.
    """

    speed: float
    angle: float

    @classmethod
    def of(cls, tolerance: float = DEFAULT_TOLERANCE) -> Self:
        """Return the noise of an integration with a tolerance: its steps are accurate to that share of the largest speed."""
        return cls(max(_SPEED_ROUNDING, _SPEED * tolerance), max(_ANGLE_ROUNDING, _ANGLE * tolerance))

    def without(self, value: float, largest: float) -> float:
        """Return an amplitude or a force of an unbalance, zero where it is noise beside the largest of the run.

        Both are in proportion to the unbalance, of whose residual ``angle`` is the noise.
        """
        return value if abs(value) > self.angle * largest else 0.0

    def widen(self, bounds: np.ndarray) -> np.ndarray:
        """Widen bounds (2, ...) of a residual unbalance by their distance if that is no larger than the noise."""
        low, high = bounds
        margin = np.where(high - low <= 2 * self.angle, high - low, 0.0)
        return np.array([low - margin, high + margin])
