"""Woehler lines, the damage sum after Palmgren and Miner, and its accumulation while a load is recorded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.counting import closed_cycles, half_cycles, turning_points


@dataclass(frozen=True)
class WoehlerLine:
    """Woehler (S-N) line N = ND (S/SD)^-k above the knee, with another slope below it; S is the amplitude, half the range.

    Parameters
    ----------
    k : float
        The slope above the knee.
    ND : float
        The number of cycles at the knee.
    SD : float
        The amplitude at the knee, in the unit of the load.
    k2 : float
        The slope below the knee. It is infinite for Miner's original rule (amplitudes below the knee do no damage: A. Palmgren
        1924, M. A. Miner, J. Appl. Mech. 12 (1945) A159), k for the elementary one, 2 k - 1 after E. Haibach, Laboratorium fuer
        Betriebsfestigkeit, TM 50/70 (1970): see ``slope_below``.

    Examples
    --------
    >>> from wucht.fatigue import WoehlerLine, slope_below
    >>> line = WoehlerLine(k=5, ND=2e6, SD=100.0, k2=slope_below(5, "haibach"))
    >>> line.life([200.0, 100.0, 50.0]).tolist()
    [62500.0, 2000000.0, 1024000000.0]
    """

    k: float
    ND: float
    SD: float
    k2: float

    def life(self, amplitudes: Sequence[float] | np.ndarray) -> np.ndarray:
        """Return the number of cycles (m,) to failure at constant amplitudes (m,); infinite without damage."""
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.damage_of_a_cycle(amplitudes))

    def damage_of_a_cycle(self, amplitudes: Sequence[float] | np.ndarray) -> np.ndarray:
        """Return the damage (m,) of one cycle of each amplitude (m,)."""
        share = np.asarray(amplitudes, dtype=float) / self.SD
        below = np.zeros_like(share) if math.isinf(self.k2) else share**self.k2
        return np.asarray(np.where(share >= 1, share**self.k, below) / self.ND)

    def damages(self, cycles: LoadCycles) -> np.ndarray:
        """Return the damage (m,) of each cycle as often as it was counted: their sum is Miner's, and at 1 the part fails."""
        return np.asarray(cycles.counts * self.damage_of_a_cycle(cycles.ranges / 2))


def slope_below(k: float, miner: str) -> float:
    """Return the slope of a Woehler line below its knee after a rule of damage accumulation.

    Parameters
    ----------
    k : float
        The slope above the knee.
    miner : {"original", "elementary", "haibach"}

    Returns
    -------
    float
        Infinite (no damage below the knee), k, or 2 k - 1.

    Raises
    ------
    KeyError
        For another rule.
    """
    return {"original": math.inf, "elementary": k, "haibach": 2 * k - 1}[miner]


@dataclass(frozen=True, eq=False)
class AccumulatedDamage:
    """The damage so far of a load whose turning points come in parts.

    Parameters
    ----------
    line : WoehlerLine
    closed_damage : float, optional
        Of the closed rainflow cycles.
    open_points : numpy.ndarray, (k,), optional
        Turning points of the ranges that have closed none: these count one half each (ASTM E1049-85, 5.4.4), and may close
        later.
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
