"""Where a slow signal goes: what an approach still adds, whether it drifts or grows, estimated from equal windows at its end."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

LOOKAHEAD = 15.0  # times the length of the record: so long a drift or a growth is followed into the future
_WINDOWS = 5
_SHARE = 0.1  # of the record, each window
_ROUNDING = 1e-10
_CONTRACTING = 0.98  # ratio of successive changes: above, it is taken for a drift
_DIRECTED = 0.95  # of the sum of all changes: the whole change of a drift, which does not go to and fro


@dataclass(frozen=True)
class Trend:
    """How far a signal still moves, estimated from the means over equal windows.

    change: between the last two windows. remaining: what is still to come: of an approach all of it, of a drift or a growth
    what it adds in ``LOOKAHEAD`` times the length of the record; inf if that cannot be told. windows_needed: how many more
    windows until change and rest together fall below the tolerance (inf likewise).
    """

    change: float
    remaining: float
    windows_needed: float = math.inf

    def steady(self, tolerance: float) -> bool:
        """Whether what is left to change is below the tolerance."""
        return self.change + self.remaining <= tolerance


UNKNOWN = Trend(math.inf, math.inf)


def trend(signals: np.ndarray, tolerance: float) -> Trend:
    """The trend of signals (k, N), complex or real, already scaled so that 1 is large: over the last five tenths of them."""
    n = int(signals.shape[1] * _SHARE)
    if n < 1:
        return UNKNOWN
    return trend_of(window_means(signals, n, _WINDOWS), tolerance, LOOKAHEAD / _SHARE)


def window_means(signals: np.ndarray, n: int, count: int) -> np.ndarray:
    """The means (count, k) over the last windows of n samples of signals (k, N)."""
    return np.asarray(signals[:, signals.shape[1] - count * n :].reshape(len(signals), count, n).mean(axis=2).T)


def trend_of(
    means: np.ndarray, tolerance: float, ahead: float, rounding: float = _ROUNDING, fluctuation: float | None = None
) -> Trend:
    """The trend of the means (w, k) over successive windows, w >= 3.

    For a geometric approach, of ratio rho between windows, the rest is change rho/(1 - rho). A drift is followed over so many
    windows ``ahead``. Changes below ``rounding`` are none. Changes to and fro that do not contract are fluctuations: they are left out if they are below
    ``fluctuation``, a hundredth of the tolerance if that is not given.
    """
    changes = np.diff(means, axis=0)
    sizes = np.abs(changes).max(axis=1)
    after = float(sizes[-1])
    negligible = after <= (1e-2 * tolerance if fluctuation is None else fluctuation)
    if after <= rounding:
        return Trend(after, 0.0, 0.0)
    with np.errstate(divide="ignore"):
        ratios = sizes[1:] / sizes[:-1]
    directed = np.abs(means[-1] - means[0]).max() >= _DIRECTED * sizes.sum()
    if (ratios < _CONTRACTING).all():
        rho = float(ratios[-2:].max())
        remaining = after * rho / (1 - rho)
        needed = max(0.0, math.log(max(after + remaining, 1e-300) / tolerance) / -math.log(rho))
        return Trend(after, remaining, needed)
    if directed:
        growing = len(ratios) > 1 and bool((ratios > 1).all())
        growth = float(ratios[-2:].min()) if growing else 1.0
        with np.errstate(over="ignore"):
            remaining = after * (
                ahead if growth - 1 < 1e-9 else float(np.expm1(min(ahead * math.log(growth), 700.0))) / (growth - 1)
            )
        return Trend(after, remaining, 0.0 if after + remaining <= tolerance else math.inf)
    return Trend(after, 0.0, 0.0) if negligible else Trend(after, math.inf)
