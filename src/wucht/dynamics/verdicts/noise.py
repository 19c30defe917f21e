"""What rounding and the tolerance of an integration make of a motion at rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from wucht.numerics.flow.compiled import DEFAULT_TOLERANCE

_SPEED, _ANGLE = 1.0, 10.0  # times the tolerance: measured on random machines of all drives, tests/studies/run_up/test_rest.py
_SPEED_ROUNDING, _ANGLE_ROUNDING = 1e-10, 1e-7


@dataclass(frozen=True)
class Noise:
    """By how much what is at rest changes from window to window: smaller changes are none.

    Attributes
    ----------
    speed : float
        Of mean, lowest and highest speed averaged over turns, as a share of the speed.
    angle : float
        Of a phase in rad; and of what is left of an unbalance, as a share of it.
    """

    speed: float
    angle: float

    @classmethod
    def of(cls, tolerance: float = DEFAULT_TOLERANCE) -> Self:
        """The noise of an integration with a tolerance: its steps are accurate to that share of the largest speed."""
        return cls(max(_SPEED_ROUNDING, _SPEED * tolerance), max(_ANGLE_ROUNDING, _ANGLE * tolerance))

    def widened(self, bounds: np.ndarray) -> np.ndarray:
        """Bounds (2, ...) of what is left of an unbalance; where they are no further apart than noise, wider by as much."""
        low, high = bounds
        margin = np.where(high - low <= 2 * self.angle, high - low, 0.0)
        return np.array([low - margin, high + margin])
