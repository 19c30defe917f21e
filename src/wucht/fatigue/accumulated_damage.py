"""Miner's sum of a load as it comes: what each new turning point adds to the damage."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from wucht.fatigue.rainflow_counting import closed_cycles, half_cycles
from wucht.fatigue.turning_points import turning_points
from wucht.fatigue.woehler_line import WoehlerLine


@dataclass(frozen=True, eq=False)
class AccumulatedDamage:
    """The damage so far.

    closed: of the rainflow cycles that have closed. open_points (k,): turning points of the ranges that have closed none: these
    count one half each (ASTM E1049-85, 5.4.4), and may close later.
    """

    line: WoehlerLine
    closed: float = 0.0
    open_points: np.ndarray = field(default_factory=lambda: np.empty(0))

    def after(self, values: np.ndarray) -> AccumulatedDamage:
        """After more turning points (m,): the same as if all had been counted at once."""
        cycles, left = closed_cycles(turning_points(np.concatenate([self.open_points, values])))
        return replace(self, closed=self.closed + float(self.line.damages(cycles).sum()), open_points=left)

    @property
    def total(self) -> float:
        """Miner's sum, from 0 on; at 1 the part fails."""
        return self.closed + float(self.line.damages(half_cycles(self.open_points)).sum())
