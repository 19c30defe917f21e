"""Woehler lines, the damage sum after Palmgren and Miner, and its accumulation while a load is recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.counting import closed_cycles, half_cycles, turning_points


@dataclass(frozen=True)
class WoehlerLine:
    """N = ND (S/SD)^-k above the knee, with slope k2 below it; S is the amplitude, half the range.

    k2 is infinite for Miner's original rule (amplitudes below the knee do no damage: A. Palmgren 1924, M. A. Miner, J. Appl.
    Mech. 12 (1945) A159), k for the elementary one, 2 k - 1 after E. Haibach, Laboratorium fuer Betriebsfestigkeit, TM 50/70
    (1970).
    """

    k: float
    ND: float
    SD: float
    k2: float

    def life(self, amplitudes: np.ndarray) -> np.ndarray:
        """Return the number of cycles (m,) to failure at constant amplitudes (m,); infinite without damage."""
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.damage_of_a_cycle(amplitudes))

    def damage_of_a_cycle(self, amplitudes: np.ndarray) -> np.ndarray:
        """Return the damage (m,) of one cycle of each amplitude (m,)."""
        share = np.asarray(amplitudes, dtype=float) / self.SD
        below = np.zeros_like(share) if math.isinf(self.k2) else share**self.k2
        return np.asarray(np.where(share >= 1, share**self.k, below) / self.ND)

    def damages(self, cycles: LoadCycles) -> np.ndarray:
        """Return the damage (m,) of each cycle as often as it was counted: their sum is Miner's, and at 1 the part fails."""
        return np.asarray(cycles.counts * self.damage_of_a_cycle(cycles.ranges / 2))


def slope_below(k: float, miner: str) -> float:
    """Return the slope below the knee of a rule: ``original``, ``elementary`` or ``haibach``."""
    return {"original": math.inf, "elementary": k, "haibach": 2 * k - 1}[miner]


@dataclass(frozen=True, eq=False)
class AccumulatedDamage:
    """The damage so far.

    closed_damage: of the closed rainflow cycles. open_points (k,): turning points of the ranges that have closed none: these
    count one half each (ASTM E1049-85, 5.4.4), and may close later.
    """

    line: WoehlerLine
    closed_damage: float = 0.0
    open_points: np.ndarray = field(default_factory=lambda: np.empty(0))

    def update(self, values: np.ndarray) -> AccumulatedDamage:
        """Return the damage after more turning points (m,): the same as if all had been counted at once."""
        cycles, open_points = closed_cycles(turning_points(np.concatenate([self.open_points, values])))
        return replace(self, closed_damage=self.closed_damage + float(self.line.damages(cycles).sum()), open_points=open_points)

    @property
    def total(self) -> float:
        """Miner's sum, from 0 on; at 1 the part fails."""
        return self.closed_damage + float(self.line.damages(half_cycles(self.open_points)).sum())
