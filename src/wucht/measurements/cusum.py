"""The cumulative sum chart: a lasting change of a noisy reading is seen, and how soon; how often it alarms without one.

E. S. Page, Biometrika 41 (1954) 100-115; D. C. Montgomery, Introduction to Statistical Quality Control, (9.2)-(9.3):

    C+ = max(0, C+ + y - mean - k),   C- = max(0, C- - y + mean - k),   an alarm where one exceeds h.

How the sums are distributed is not drawn but computed: their density between 0 and h, and the share of charts that stand at 0,
are carried from reading to reading (Page's integral equation; D. Brook, D. A. Evans, Biometrika 59 (1972) 539-549, with Gauss'
nodes for their classes). What is expected of the reading may differ from one to the next.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from wucht.errors import RunError

_NODES, _A_DEVIATION = 16, 2.0  # Gauss' nodes: at least, and as many for each standard deviation below the threshold
_MOST_NODES = 160
_CONVERGED = 1e-9  # relative: the chance of an alarm in a cycle
_MOST_CYCLES, _NONE_LEFT, _UNDERFLOW, _NEVER = 10_000, 1e-15, 1e-200, 1e300
_ROOT_2, _ROOT_2_PI = math.sqrt(2.0), math.sqrt(2 * math.pi)


@dataclass(frozen=True, eq=False)
class Sums:
    """How one of the two sums is distributed over all charts that have not alarmed.

    zero: the share of those that stand at 0. density (N,): of the others at the nodes. Together they are that share of all
    charts which has not alarmed.
    """

    zero: float
    density: np.ndarray


@dataclass(frozen=True)
class Cusum:
    """A two-sided chart. reference: k, half the change that is to be seen soonest. threshold: h. noise: the standard deviation
    of a reading, the readings being independent and normal; all in the unit of the reading."""

    reference: float
    threshold: float
    noise: float

    def first_alarms(self, deviations: np.ndarray) -> np.ndarray:
        """At which reading (M,) each of M charts alarms, of readings less their mean (M, n); n where none does."""
        upper, lower = np.zeros(len(deviations)), np.zeros(len(deviations))
        first = np.full(len(deviations), deviations.shape[1])
        for i, reading in enumerate(deviations.T):
            upper = np.maximum(0.0, upper + reading - self.reference)
            lower = np.maximum(0.0, lower - reading - self.reference)
            alarmed = np.maximum(upper, lower) > self.threshold
            first[alarmed & (first > i)] = i
        return first

    @property
    def zero(self) -> Sums:
        """Charts that begin."""
        return Sums(1.0, np.zeros(len(self._nodes)))

    @cached_property
    def _spread(self) -> float:
        """The standard deviation with which the density is computed: the nodes must resolve it."""
        return max(self.noise, _A_DEVIATION * self.threshold / (_MOST_NODES - _NODES))

    @cached_property
    def _rule(self) -> tuple[np.ndarray, np.ndarray]:
        points, weights = _gauss(_NODES + math.ceil(_A_DEVIATION * self.threshold / self._spread))
        return self.threshold * (points + 1) / 2, self.threshold * weights / 2

    @property
    def _nodes(self) -> np.ndarray:
        return self._rule[0]

    def _matrix(self, drift: float) -> np.ndarray:
        """(N + 2, N + 1): from zero and the nodes to zero, to the nodes, and beyond the threshold, in one reading."""
        (nodes, weights), s = self._rule, self._spread
        begin, share = np.append(0.0, nodes), np.append(1.0, weights)
        z = (nodes[:, None] - begin - drift) / s
        to_zero = _normal((-begin - drift) / s)
        beyond = _normal((begin + drift - self.threshold) / s)
        return np.asarray(share * np.vstack([to_zero, np.exp(-z * z / 2) / (s * _ROOT_2_PI), beyond]))

    def _drifts(self, expected: np.ndarray, rising: bool) -> np.ndarray:
        return (expected if rising else -expected) - self.reference

    def _carried(self, sums: Sums, expected: np.ndarray, rising: bool) -> Iterator[float]:
        """The share of charts that alarm at each of some readings, which are expected to deviate so (n,).

        rising: by the upper sum, else by the lower one.
        """
        now, matrices = np.append(sums.zero, sums.density), dict[float, np.ndarray]()  # readings may come again and again
        for drift in self._drifts(expected, rising).tolist():
            matrix = matrices.get(drift)
            if matrix is None:
                matrix = matrices[drift] = self._matrix(drift)
            after = matrix @ now
            now = after[:-1]
            yield float(after[-1])

    def steady(self, expected: np.ndarray, rising: bool) -> tuple[Sums, float]:
        """After many cycles of readings that are expected to deviate so (n,): the sums of the charts that have not alarmed (all
        together 1), and the mean number of readings from the begin of a chart to its alarm.

        Raises ``RunError`` where that cannot be found.
        """
        matrices = [self._matrix(drift) for drift in self._drifts(expected, rising).tolist()]
        now, weights = np.append(1.0, self.zero.density), np.append(1.0, self._rule[1])
        left, passed, before = 1.0, 0.0, math.nan
        for _ in range(_MOST_CYCLES):
            logs = np.empty(len(matrices))  # of the share that stays, reading by reading: right where that is 1 to rounding
            for i, matrix in enumerate(matrices):
                after = matrix @ now
                stays, alarms = float(weights @ after[:-1]), float(after[-1])
                if stays < _UNDERFLOW * alarms:  # every chart alarms at the latest here
                    return Sums(0.0, 0 * now[1:]), passed + left * float(np.exp(np.append(0.0, np.cumsum(logs[:i]))).sum())
                logs[i] = -math.log1p(alarms / stays)
                now = after[:-1] / stays
            readings = float(np.exp(np.cumsum(logs) - logs).sum())
            chance = -math.expm1(float(logs.sum()))
            if abs(chance - before) <= _CONVERGED * chance or left < _NONE_LEFT:
                return Sums(float(now[0]), now[1:]), passed + left * readings / max(chance, 1 / _NEVER)
            passed, left, before = passed + left * readings, left * (1 - chance), chance
        raise RunError("the chart does not come to a steady state: the change that is to be seen is too small")

    def between_alarms(self, expected: np.ndarray) -> float:
        """The mean number of readings between two alarms without a change; expected (n,): deviations that come again and again.

        Each alarm begins the chart anew. That of both sums: 1/N = 1/N+ + 1/N- (K. W. Kemp, Appl. Statist. 11 (1962) 16-31).
        """
        return 1 / sum(1 / self.steady(expected, rising)[1] for rising in (True, False))

    def detection(self, normal: np.ndarray | None, changed: np.ndarray, enough: float = 1.0) -> np.ndarray:
        """The probability (m,) that an alarm has come by each reading after a change.

        normal (n,): what deviations were expected again and again before it, without an alarm; None: the chart begins. changed:
        what is expected then, at least m readings: at the first one with a probability of ``enough`` it ends.
        """
        begin = [self.zero if normal is None else self.steady(normal, rising)[0] for rising in (True, False)]
        each = zip(self._carried(begin[0], changed, True), self._carried(begin[1], changed, False), strict=True)
        found, missed = list[float](), [1.0, 1.0]
        for alarmed in each:
            missed = [m - a for m, a in zip(missed, alarmed, strict=True)]
            found.append(1 - missed[0] * missed[1])
            if found[-1] >= enough:
                break
        return np.array(found)


def chart(reference: float, noise: float, readings: float, expected: np.ndarray) -> Cusum:
    """The chart that alarms once in so many readings without a change. expected (n,): deviations, again and again.

    Raises ``RunError`` where there is none.
    """
    from scipy.optimize import brentq

    low = 0.1 * max(noise, reference)
    made = Cusum(reference, low, noise)

    def missing(logarithm: float) -> float:
        return math.log(replace(made, threshold=math.exp(logarithm)).between_alarms(expected) / readings)

    if missing(math.log(low)) > 0:
        raise RunError("without a failure there are fewer false alarms than wanted: ask for rarer ones")
    high = low
    while missing(math.log(high)) < 0:
        high *= 2
        if high > 1e6 * low:
            raise RunError("no threshold makes false alarms so rare: without a failure the readings change too much")
    return replace(made, threshold=math.exp(brentq(missing, math.log(high / 2), math.log(high), xtol=1e-6)))


@lru_cache(maxsize=256)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    points, weights = np.polynomial.legendre.leggauss(count)
    return points, weights


def _normal(z: np.ndarray) -> np.ndarray:
    """The normal distribution's cumulative function."""
    from scipy.special import ndtr

    return np.asarray(ndtr(z))
