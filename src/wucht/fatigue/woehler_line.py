"""Woehler lines and the damage sum after Palmgren and Miner."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.fatigue.counted_cycles import Cycles


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
        """The number of cycles (m,) to failure at constant amplitudes (m,); infinite where nothing is damaged."""
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.damage_of_a_cycle(amplitudes))

    def damage_of_a_cycle(self, amplitudes: np.ndarray) -> np.ndarray:
        """The damage (m,) of one cycle of each amplitude (m,)."""
        share = np.asarray(amplitudes, dtype=float) / self.SD
        below = np.zeros_like(share) if math.isinf(self.k2) else share**self.k2
        return np.asarray(np.where(share >= 1, share**self.k, below) / self.ND)

    def damages(self, cycles: Cycles) -> np.ndarray:
        """The damage (m,) of each of the cycles as often as it was counted: their sum is Miner's, and at 1 the part fails."""
        return np.asarray(cycles.counts * self.damage_of_a_cycle(cycles.ranges / 2))


def slope_below(k: float, miner: str) -> float:
    """The slope below the knee of a rule: ``original``, ``elementary`` or ``haibach``."""
    return {"original": math.inf, "elementary": k, "haibach": 2 * k - 1}[miner]
