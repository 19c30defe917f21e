"""Where a slow signal goes: between which values it will stay, estimated from its means over equal windows at its end."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

LOOKAHEAD = 15.0  # times the length of the record: so long a drift or a growth is followed into the future
WINDOWS = 5
SHARE = 0.1  # of the record, each window
AHEAD = LOOKAHEAD / SHARE
_CONTRACTING = 0.98  # ratio of successive changes: above, it is taken for a drift
_DIRECTED = 0.95  # of the sum of all changes: the whole change of a drift, which does not go to and fro
_ALIKE = 2.0  # times: rates of a growth differ by no more
_LAST_RATIOS = 3  # that are to be alike where a decay is observed
_OBSERVED = 20 / 3  # windows, of which five are seen: what takes longer to fall by the factor e is no observed decay
_MOSTLY = 0.8  # of all pairs of windows
_FARTHEST = 1e300
_FALLS = 1e-3  # of a number, from the first to the last window: less is no fall


class Course(Enum):
    """What a signal does."""

    APPROACHING = "approaching"  # a limit, ever more slowly
    STATIONARY = "stationary"  # to and fro, or not at all
    DRIFTING = "drifting"  # one way, or growing


@dataclass(frozen=True)
class Projection:
    """A signal's last mean, and the bounds between which it will stay, as far as it can be told.

    course: what it does. windows: in how many windows its distance from the limit falls (or grows) by the factor e; inf where
    it does not.
    """

    last: float
    low: float
    high: float
    course: Course
    windows: float = math.inf

    @property
    def bounds(self) -> tuple[float, float]:
        """Between which it will stay."""
        return self.low, self.high

    @property
    def width(self) -> float:
        """How far the bounds are apart."""
        return self.high - self.low

    def windows_until(self, width: float) -> float:
        """In how many windows an approach will have come so near to its limit; inf where no decay is observed."""
        if self.width <= width:
            return 0.0
        observed = self.course is Course.APPROACHING and self.windows <= _OBSERVED
        return self.windows * math.log(self.width / width) if observed else math.inf


def projected(means: np.ndarray, ahead: float = AHEAD, rounding: float = 0.0, wider: float = 0.25) -> Projection:
    """The projection of the means (w,), w >= 2, over successive windows.

    An approach contracts from change to change: of ratio rho it adds the last change times rho/(1 - rho), and half of that
    again is allowed for. A drift goes on as it does for so many windows ``ahead``, a growth grows on. Changes to and fro stay
    within their range, widened on both sides by a share ``wider`` of it. Changes below ``rounding`` are none.
    """
    changes = np.diff(means)
    sizes, last = np.abs(changes), float(means[-1])
    low, high = float(means.min()), float(means.max())
    after = float(sizes[-1])
    if (sizes[-2:] <= rounding).all():
        return Projection(last, float(means[-3:].min()), float(means[-3:].max()), Course.STATIONARY)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = sizes[1:] / sizes[:-1]
    if len(ratios) > 1 and (ratios < _CONTRACTING).all():
        rho = float(ratios[-2:].max())
        rest = after * rho / (1 - rho)
        windows = _time_constant(ratios)
        # Changes to and fro have their limit between the last two.
        toward = last + math.copysign(1.5 * rest, changes[-1]) if changes[-1] * changes[-2] > 0 else float(means[-2])
        return Projection(last, min(last, toward), max(last, toward), Course.APPROACHING, windows)
    if after > rounding and abs(changes.sum()) >= _DIRECTED * sizes.sum():
        growth = _growth(ratios)
        count = math.exp(growth) * math.expm1(min(ahead * growth, 600.0)) / math.expm1(growth) if growth > 1e-9 else ahead
        toward = last + math.copysign(min(after * count, _FARTHEST), changes[-1])
        windows = 1 / growth if growth > 0 else math.inf
        return Projection(last, min(last, toward), max(last, toward), Course.DRIFTING, windows)
    margin = wider * (high - low)
    return Projection(last, low - margin, high + margin, Course.STATIONARY)


def projected_each(
    means: np.ndarray, ahead: float = AHEAD, rounding: np.ndarray | float = 0.0, wider: float = 0.25
) -> np.ndarray:
    """The bounds (2, M) of ``projected`` for many signals (w, M) at once, w >= 4. rounding: of all, or of each (M,)."""
    changes = np.diff(means, axis=0)
    sizes, last = np.abs(changes), means[-1]
    low, high, after = means.min(axis=0), means.max(axis=0), sizes[-1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratios = sizes[1:] / sizes[:-1]
        rho, logs = ratios[-2:].max(axis=0), np.log(ratios)
        rest = last + np.copysign(1.5 * after * rho / (1 - rho), changes[-1])
        grows = (ratios > 1).all(axis=0) & (logs.max(axis=0) <= _ALIKE * logs.min(axis=0))
        growth = np.where(grows, logs.min(axis=0), 0.0)
        count = np.exp(growth) * np.expm1(np.minimum(ahead * growth, 600.0)) / np.expm1(growth)
        gone = last + np.copysign(np.minimum(after * np.where(growth > 1e-9, count, ahead), _FARTHEST), changes[-1])
    constant = (sizes[-2:] <= rounding).all(axis=0)
    approaching = (ratios < _CONTRACTING).all(axis=0)
    drifting = (after > rounding) & (np.abs(changes.sum(axis=0)) >= _DIRECTED * sizes.sum(axis=0))
    limit = np.where(changes[-1] * changes[-2] > 0, rest, means[-2])
    toward, margin = np.where(approaching, limit, gone), wider * (high - low)
    moving = approaching | drifting
    return np.where(
        constant,
        [means[-3:].min(axis=0), means[-3:].max(axis=0)],
        np.where(moving, [np.minimum(last, toward), np.maximum(last, toward)], [low - margin, high + margin]),
    )


def _time_constant(ratios: np.ndarray) -> float:
    """In how many windows an approach falls by the factor e, of the ratios of its changes; inf where they are not alike."""
    with np.errstate(divide="ignore"):
        rates = -np.log(ratios[-_LAST_RATIOS:])
    return float(1 / rates.min()) if rates.max() <= _ALIKE * rates.min() else math.inf


def _growth(ratios: np.ndarray) -> float:
    """The rate of growth a window, of the ratios of successive changes: 0 where they do not grow alike."""
    if len(ratios) < 2 or not (ratios > 1).all():
        return 0.0
    logs = np.log(ratios)
    return float(logs.min()) if logs.max() <= _ALIKE * logs.min() else 0.0


def trend(means: np.ndarray) -> int:
    """+1 if means over successive windows mostly rise, -1 if they mostly fall, to and fro as they may go; else 0.

    Mostly: in four fifths of all pairs (H. B. Mann, Econometrica 13 (1945) 245-259).
    """
    later, earlier = np.tril_indices(len(means), -1)
    signs = np.sign(means[later] - means[earlier])
    return next((way for way in (+1, -1) if np.mean(signs == way) >= _MOSTLY), 0)


def falling(means: np.ndarray, ahead: float = AHEAD, rounding: float = 0.0, *, even_if_approaching: bool = False) -> Projection:
    """The projection of a positive number that, where it mostly falls, to and fro as it may go, goes on falling at that rate.

    even_if_approaching: also where it approaches a limit.
    """
    p = projected(means, ahead, rounding)
    taken = p.course is not Course.APPROACHING or even_if_approaching
    if not taken or trend(means) >= 0 or not 0 < means[-1] < (1 - _FALLS) * means[0]:
        return p
    fall = math.log(means[0] / means[-1]) / (len(means) - 1)
    return replace(p, low=min(p.low, p.last * math.exp(-fall * ahead)), course=Course.APPROACHING, windows=1 / fall)


def windows_of(signal: np.ndarray, count: int = WINDOWS, share: float = SHARE) -> np.ndarray:
    """The last windows (..., count, n) of a signal (..., N), each a share of it; n may be 0."""
    n = int(signal.shape[-1] * share)
    return np.asarray(signal[..., signal.shape[-1] - count * n :].reshape(*signal.shape[:-1], count, n))
