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

    stored: float = math.nan
    scale: float = 0.0

    def after(self, stored: np.ndarray, supplied: np.ndarray, lost: np.ndarray) -> tuple[EnergyBalance, np.ndarray]:
        """Update the balance by a part of the motion; return also the residual (N,) over it.

        energy: (N,). works: since the start (k, N), of which the motion gains the sum; losses: (N,).
        """
        gained = supplied.sum(axis=0) - lost
        first = float(stored[0] - gained[0]) if math.isnan(self.stored) else self.stored
        scale = max(self.scale, float(np.abs(stored).max(initial=0.0)), float(np.abs(supplied).max(initial=0.0)))
        return EnergyBalance(first, scale), np.abs(gained - (stored - first)) / (scale or 1.0)
