"""The future range of a slow signal, estimated from its means over equal windows at its end."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

LOOKAHEAD = 15.0  # times the length of the record: how far a drift or a growth is extrapolated
WINDOWS = 5
SHARE = 0.1  # of the record, each window
AHEAD = LOOKAHEAD / SHARE
_CONTRACTING = 0.98  # ratio of successive changes: above, it is taken for a drift
_DRIFT_SHARE = 0.95  # of the sum of all changes: the whole change of a drift, which does not oscillate
_ALIKE = 2.0  # times: rates of a growth differ by no more
_LAST_RATIOS = 3  # that must be alike where a decay is observed
_LONGEST_DECAY = 20 / 3  # windows, of which five exist: a slower fall by the factor e is no observed decay
_MOSTLY = 0.8  # of all pairs of windows
_FARTHEST = 1e300
_FALLS = 1e-3  # of a number, from the first to the last window: less is no fall
_BLOCKS, _RANDOM = (10, 20, 40, 80), 0.7  # in the last windows; von Neumann's ratio, on average 2 of random numbers


class Course(Enum):
    """Course of a signal."""

    APPROACHING = "approaching"  # a limit, ever more slowly
    STATIONARY = "stationary"  # oscillating, or constant
    DRIFTING = "drifting"  # one way, or growing


@dataclass(frozen=True)
class Projection:
    """A signal's last mean, and the bounds between which it will probably stay.

    course: see ``Course``. windows: in how many windows its distance from the limit falls (or grows) by the factor e; inf where
    it does not. scatters: it fluctuates irregularly within the bounds, which a longer record does not narrow.
    """

    last: float
    low: float
    high: float
    course: Course
    windows: float = math.inf
    scatters: bool = False

    @property
    def bounds(self) -> tuple[float, float]:
        """Bounds between which it will stay."""
        return self.low, self.high

    @property
    def width(self) -> float:
        """Distance of the bounds."""
        return self.high - self.low

    def windows_until(self, width: float) -> float:
        """Return the number of windows until an approach is so near to its limit; inf where no decay is observed."""
        if self.width <= width:
            return 0.0
        is_decaying = self.course is Course.APPROACHING and self.windows <= _LONGEST_DECAY
        return self.windows * math.log(self.width / width) if is_decaying else math.inf


@dataclass(frozen=True)
class Projections:
    """The projections of M signals, each array (M,): see ``Projection``. constant: they change by rounding alone."""

    last: np.ndarray
    low: np.ndarray
    high: np.ndarray
    constant: np.ndarray
    approaching: np.ndarray
    drifting: np.ndarray
    windows: np.ndarray

    @property
    def bounds(self) -> np.ndarray:
        """Bounds between which they will stay (2, M)."""
        return np.array([self.low, self.high])

    @property
    def width(self) -> np.ndarray:
        """Distances of the bounds (M,)."""
        return np.asarray(self.high - self.low)

    @property
    def converging(self) -> np.ndarray:
        """True for signals that approach a limit, or have reached it (M,)."""
        return np.asarray(self.constant | self.approaching)

    def one(self, i: int = 0) -> Projection:
        """Return the projection of one signal."""
        course = Course.APPROACHING if self.approaching[i] else Course.DRIFTING if self.drifting[i] else Course.STATIONARY
        return Projection(float(self.last[i]), float(self.low[i]), float(self.high[i]), course, float(self.windows[i]))


def project(means: np.ndarray, ahead: float = AHEAD, rounding: float = 0.0, wider: float = 0.25) -> Projection:
    """Project the means (w,), w >= 2, of one signal: see ``project_signals``."""
    return project_signals(means[:, None], ahead, rounding, wider).one()


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def project_signals(
    means: np.ndarray, ahead: float = AHEAD, rounding: np.ndarray | float = 0.0, wider: float = 0.25
) -> Projections:
    """Project the means (w, M), w >= 2, of M signals over successive windows.

    An approach contracts from change to change: with a ratio rho it adds the last change times rho/(1 - rho), with a margin of
    half of that. A drift or a growth is extrapolated over ``ahead`` windows. Oscillations stay within their range, widened on
    both sides by a share ``wider`` of it. Changes below ``rounding``, of all signals or of each (M,), count as zero.
    """
    changes, last, recent = means[1:] - means[:-1], means[-1], means[-3:]
    sizes, low, high = abs(changes), means.min(axis=0), means.max(axis=0)
    # Two changes are too few to decide whether they contract.
    ratios = sizes[1:] / sizes[:-1] if len(means) > 3 else np.full((1, means.shape[1]), np.nan)
    constant = np.asarray((sizes[-2:] <= rounding).all(axis=0))
    approaching = np.asarray((ratios < _CONTRACTING).all(axis=0) & ~constant)
    one_way = (sizes[-1] > rounding) & (abs(changes.sum(axis=0)) >= _DRIFT_SHARE * sizes.sum(axis=0))
    drifting, margin = one_way & ~approaching & ~constant, wider * (high - low)
    least, greatest, windows = low - margin, high + margin, np.full(len(last), math.inf)
    if constant.any():
        least, greatest = (np.where(constant, x, y) for x, y in ((recent.min(axis=0), least), (recent.max(axis=0), greatest)))
    if approaching.any():
        rates, rho = -np.log(ratios[-_LAST_RATIOS:]), ratios[-2:].max(axis=0)
        windows = np.where(approaching & _alike(rates), 1 / rates.min(axis=0), windows)
        # Alternating changes have their limit between the last two.
        limit = np.where(changes[-1] * changes[-2] > 0, last + 1.5 * changes[-1] * rho / (1 - rho), means[-2])
        least, greatest = _bounds_towards(last, limit, approaching, least, greatest)
    if drifting.any():
        logs = np.log(ratios)
        growth = np.where((ratios > 1).all(axis=0) & _alike(logs), logs.min(axis=0), 0.0)
        count = np.exp(growth) * np.expm1(np.minimum(ahead * growth, 600.0)) / np.expm1(growth)
        distance = np.minimum(sizes[-1] * np.where(growth > 1e-9, count, ahead), _FARTHEST)
        windows = np.where(drifting & (growth > 0), 1 / growth, windows)
        least, greatest = _bounds_towards(last, last + np.copysign(distance, changes[-1]), drifting, least, greatest)
    return Projections(last, least, greatest, constant, approaching, drifting, windows)


def _bounds_towards(last: np.ndarray, end: np.ndarray, mask: np.ndarray, least: np.ndarray, greatest: np.ndarray) -> Any:
    """Set the bounds of those signals that go from their last value to an end; the others keep theirs."""
    return np.where(mask, np.minimum(last, end), least), np.where(mask, np.maximum(last, end), greatest)


def _alike(rates: np.ndarray) -> np.ndarray:
    """True where the rates (r, M) of a signal differ by no more than a factor of two (M,)."""
    return np.asarray(rates.max(axis=0) <= _ALIKE * rates.min(axis=0))


def trend(means: np.ndarray) -> int:
    """Return +1 if means over successive windows mostly rise, -1 if they mostly fall, with oscillations allowed; else 0.

    Mostly: in four fifths of all pairs (H. B. Mann, Econometrica 13 (1945) 245-259).
    """
    later, earlier = np.tril_indices(len(means), -1)
    signs = np.sign(means[later] - means[earlier])
    return next((way for way in (+1, -1) if np.mean(signs == way) >= _MOSTLY), 0)


def falling_projection(
    means: np.ndarray, ahead: float = AHEAD, rounding: float = 0.0, *, even_if_approaching: bool = False
) -> Projection:
    """Project a positive number; where it mostly falls, with oscillations allowed, the fall is extrapolated at its mean rate.

    even_if_approaching: also where it approaches a limit.
    """
    p = project(means, ahead, rounding)
    applies = p.course is not Course.APPROACHING or even_if_approaching
    if not applies or trend(means) >= 0 or not 0 < means[-1] < (1 - _FALLS) * means[0]:
        return p
    fall = math.log(means[0] / means[-1]) / (len(means) - 1)
    return replace(p, low=min(p.low, p.last * math.exp(-fall * ahead)), course=Course.APPROACHING, windows=1 / fall)


def scatters(signal: np.ndarray) -> bool:
    """True if a signal (N,) fluctuates irregularly in its last windows, and changes no more than its scatter explains.

    The largest values of successive blocks differ about as much as any two of them (J. von Neumann, Annals of Mathematical
    Statistics 12 (1941) 367-395). Blocks of several lengths: an oscillation is smooth over those that are short beside its
    period, its growth or decay over longer ones. False where there are too few samples to tell.
    """
    last = windows_of(signal).reshape(-1)
    return len(last) >= _BLOCKS[-1] and all(
        (np.diff(x) ** 2).sum() >= _RANDOM * ((x - x.mean()) ** 2).sum()
        for x in (last[len(last) % count :].reshape(count, -1).max(axis=1) for count in _BLOCKS)
    )


def scattering_projection(means: np.ndarray, wider: float = 0.25) -> Projection:
    """Return the projection of a number that fluctuates irregularly within its range."""
    low, high = float(means.min()), float(means.max())
    margin = wider * (high - low)
    return Projection(float(means[-1]), low - margin, high + margin, Course.STATIONARY, scatters=True)


def windows_of(signal: np.ndarray, count: int = WINDOWS, share: float = SHARE) -> np.ndarray:
    """Return the last windows (..., count, n) of a signal (..., N), each a share of it; n may be 0."""
    n = int(signal.shape[-1] * share)
    return np.asarray(signal[..., signal.shape[-1] - count * n :].reshape(*signal.shape[:-1], count, n))
