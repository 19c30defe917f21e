"""The energy balance of a motion, part by part."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class EnergyBalance:
    """Residual of an energy balance: |gains - change of energy| over the largest energy or work.

    initial_energy: the energy at the start. scale: the largest so far.
    """

    initial_energy: float = math.nan
    scale: float = 0.0

    def update(self, energy: np.ndarray, works: np.ndarray, losses: np.ndarray) -> tuple[EnergyBalance, np.ndarray]:
        """Update the balance by a part of the motion; return also the residual (N,) over it.

        energy: (N,). works: since the start (k, N), of which the motion gains the sum; losses: (N,).
        """
        gains = works.sum(axis=0) - losses
        first = float(energy[0] - gains[0]) if math.isnan(self.initial_energy) else self.initial_energy
        scale = max(self.scale, float(np.abs(energy).max(initial=0.0)), float(np.abs(works).max(initial=0.0)))
        return EnergyBalance(first, scale), np.abs(gains - (energy - first)) / (scale or 1.0)
