"""The cumulative sum chart: its delay in detecting a lasting change of a noisy reading, and its rate of false alarms.

E. S. Page, Biometrika 41 (1954) 100-115; D. C. Montgomery, Introduction to Statistical Quality Control, (9.2)-(9.3):

    C+ = max(0, C+ + y - mean - k),   C- = max(0, C- - y + mean - k),   an alarm where one exceeds h.

The distribution of the sums is not sampled but computed: their density between 0 and h, and the share of charts at 0,
are propagated from reading to reading (Page's integral equation; D. Brook, D. A. Evans, Biometrika 59 (1972) 539-549, with
Gauss' nodes for their classes). The expected reading may differ from one to the next.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import chain, cycle

import numpy as np

from wucht.errors import RunError

_NODES, _A_DEVIATION = 16, 2.0  # Gauss' nodes: at least, and as many for each standard deviation below the threshold
_MOST_NODES = 160
_CONVERGENCE = 1e-9  # relative: the chance of an alarm in a cycle
_MOST_CYCLES, _NONE_LEFT, _UNDERFLOW, _NEVER = 10_000, 1e-15, 1e-200, 1e300
_FIRST_READINGS, _MOST_READINGS = 5000, 100_000  # after a change: before the tail is used, and in all
_ROOT_2, _ROOT_2_PI = math.sqrt(2.0), math.sqrt(2 * math.pi)


@dataclass(frozen=True, eq=False)
class AlarmDistribution:
    """Distribution of the reading of the alarm after a change; readings count from 0.

    Attributes
    ----------
    first : numpy.ndarray, (m,)
        The probability that it has come by each of the first readings.
    tail : numpy.ndarray, (n,)
        Of the charts that have not alarmed by then, minus the logarithm of the share that has not by each reading of a cycle of
        n, which from then on repeats with the same shares; empty if such a cycle was not reached, and the readings after the
        m-th are not known.
    """

    first: np.ndarray
    tail: np.ndarray

    @property
    def is_certain(self) -> bool:
        """True if an alarm comes at last, and its distribution is known."""
        return bool(len(self.tail) and self.tail[-1] > 1 / _NEVER)

    def mean(self) -> float:
        """Return the mean number of readings before that of the alarm; without a tail of alarms at the first readings alone."""
        if not self.is_certain:
            shares = np.diff(self.first, prepend=0.0)
            return float((shares * np.arange(len(shares))).sum() / self.first[-1])
        in_a_cycle = float(np.exp(-self.tail).sum())
        return float((1 - self.first).sum()) + self._share_left * in_a_cycle / -math.expm1(-self.tail[-1])

    def quantile(self, probability: float) -> float | None:
        """Return the number of readings before that by which an alarm has come with a probability; None if not known."""
        alarm_readings = np.flatnonzero(self.first >= probability)
        if len(alarm_readings):
            return float(alarm_readings[0])
        if not self.is_certain:
            return None
        target = math.log(self._share_left / (1 - probability))
        cycles = max(math.ceil(target / self.tail[-1]) - 1, 0)
        within = min(int(np.searchsorted(self.tail, target - cycles * self.tail[-1])), len(self.tail) - 1)
        return float(len(self.first)) + float(cycles) * len(self.tail) + within

    def curve(self, probability: float, points: int) -> tuple[np.ndarray, np.ndarray]:
        """Return numbers of readings (from 0), and the probability of an alarm by each: of the first ones, and of so many at
        the ends of cycles until a probability is reached."""
        at = np.arange(len(self.first), dtype=float)
        last = self.quantile(probability)
        if last is None or last < len(self.first):
            return at, self.first
        cycles = np.unique(np.ceil(np.linspace(0, (last + 1 - len(self.first)) / len(self.tail), points + 1)[1:]))
        ends = len(self.first) + cycles * len(self.tail) - 1
        return np.append(at, ends), np.append(self.first, 1 - self._share_left * np.exp(-cycles * self.tail[-1]))

    @property
    def _share_left(self) -> float:
        """The share of charts that have not alarmed at the first readings."""
        return 1 - float(self.first[-1])


@dataclass(frozen=True)
class Cusum:
    """A two-sided cumulative sum chart of independent, normal readings; all numbers are in the unit of the reading.

    Parameters
    ----------
    reference : float
        k, half the change that is detected soonest.
    threshold : float
        h, beyond which a sum is an alarm.
    noise : float
        The standard deviation of a reading.

    Examples
    --------
    >>> import numpy as np
    >>> from wucht.measurements import Cusum
    >>> chart = Cusum(reference=0.5, threshold=5.0, noise=1.0)
    >>> print(f"an alarm in {chart.mean_alarm_interval(np.zeros(1)):.0f} readings without a change")
    an alarm in 465 readings without a change
    """

    reference: float
    threshold: float
    noise: float

    def first_alarms(self, deviations: np.ndarray) -> np.ndarray:
        """Return the reading (M,) at which each of M charts alarms, of readings less their mean (M, n); n without alarm."""
        upper, lower = np.zeros(len(deviations)), np.zeros(len(deviations))
        first = np.full(len(deviations), deviations.shape[1])
        for i, reading in enumerate(deviations.T):
            upper = np.maximum(0.0, upper + reading - self.reference)
            lower = np.maximum(0.0, lower - reading - self.reference)
            has_alarmed = np.maximum(upper, lower) > self.threshold
            first[has_alarmed & (first > i)] = i
        return first

    @property
    def _first_sums(self) -> np.ndarray:
        """The share of charts that begin (N + 1,), at zero and at the nodes."""
        return np.append(1.0, np.zeros(len(self._nodes)))

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
        """Return the transition matrix (N + 2, N + 1): from zero and nodes to zero, nodes, and beyond the threshold."""
        (nodes, weights), s = self._rule, self._spread
        begin, share = np.append(0.0, nodes), np.append(1.0, weights)
        z = (nodes[:, None] - begin - drift) / s
        to_zero = _normal((-begin - drift) / s)
        beyond = _normal((begin + drift - self.threshold) / s)
        return np.asarray(share * np.vstack([to_zero, np.exp(-z * z / 2) / (s * _ROOT_2_PI), beyond]))

    def _drifts(self, expected_deviations: np.ndarray, rising: bool) -> np.ndarray:
        return (expected_deviations if rising else -expected_deviations) - self.reference

    def _propagate(
        self, sums: np.ndarray, expected_deviations: Iterable[float], rising: bool
    ) -> Iterator[tuple[float, np.ndarray]]:
        """Yield for each reading the share of charts that alarm, and that of the other ones (N + 1,), at zero and at the nodes
        with their weights.

        sums (N + 1,): see ``steady_state``. expected_deviations: of the readings. rising: by the upper sum, else by the lower
        one.
        """
        state, matrices = sums, dict[float, np.ndarray]()  # deviations may repeat
        weights = np.append(1.0, self._rule[1])
        for deviation in expected_deviations:
            matrix = matrices.get(deviation)
            if matrix is None:
                matrix = matrices[deviation] = self._matrix((deviation if rising else -deviation) - self.reference)
            next_state = matrix @ state
            state = next_state[:-1]
            yield float(next_state[-1]), weights * state

    def steady_state(self, expected_deviations: np.ndarray, rising: bool) -> tuple[np.ndarray, float]:
        """Return one of the two sums of all charts that have not alarmed after many cycles of readings with expected deviations
        (n,), and the mean number of readings from the begin of a chart to its alarm.

        Of a sum (N + 1,): the share of these charts where it is 0, and its density at the nodes; together 1.
        Raises ``RunError`` if there is no steady state.
        """
        matrices = [self._matrix(drift) for drift in self._drifts(expected_deviations, rising).tolist()]
        state, weights = self._first_sums, np.append(1.0, self._rule[1])
        remaining, earlier_readings, before = 1.0, 0.0, math.nan
        for _ in range(_MOST_CYCLES):
            logs = np.empty(len(matrices))  # of the share that stays, reading by reading: right where that is 1 to rounding
            for i, matrix in enumerate(matrices):
                next_state = matrix @ state
                stays, alarms = float(weights @ next_state[:-1]), float(next_state[-1])
                if stays < _UNDERFLOW * alarms:  # every chart alarms at the latest here
                    return 0 * state, earlier_readings + remaining * float(np.exp(np.append(0.0, np.cumsum(logs[:i]))).sum())
                logs[i] = -math.log1p(alarms / stays)
                state = next_state[:-1] / stays
            readings = float(np.exp(np.cumsum(logs) - logs).sum())
            chance = -math.expm1(float(logs.sum()))
            if abs(chance - before) <= _CONVERGENCE * chance or remaining < _NONE_LEFT:
                return state, earlier_readings + remaining * readings / max(chance, 1 / _NEVER)
            earlier_readings, remaining, before = earlier_readings + remaining * readings, remaining * (1 - chance), chance
        raise RunError("the chart does not reach a steady state: the change to be detected is too small")

    def mean_alarm_interval(self, expected_deviations: np.ndarray) -> float:
        """Return the mean number of readings between two alarms without a change; expected_deviations (n,): these repeat.

        Each alarm begins the chart anew. That of both sums: 1/N = 1/N+ + 1/N- (K. W. Kemp, Appl. Statist. 11 (1962) 16-31).
        """
        return 1 / sum(1 / self.steady_state(expected_deviations, rising)[1] for rising in (True, False))

    def detection(
        self, normal_deviations: np.ndarray | None, changed_deviations: np.ndarray, sufficient_probability: float = 1.0
    ) -> np.ndarray:
        """Return the probability (m,) that an alarm has come by each reading after a change.

        normal_deviations (n,): expected before it, repeating, without an alarm; None: the chart begins. changed_deviations:
        expected after it, at least m readings: it ends at the first one with ``sufficient_probability``.
        """
        return self.alarms(
            normal_deviations, changed_deviations, np.empty(0), sufficient_probability, len(changed_deviations)
        ).first

    def alarms(
        self,
        normal_deviations: np.ndarray | None,
        changed_deviations: np.ndarray,
        repeating_deviations: np.ndarray,
        sufficient_probability: float,
        most: int = _MOST_READINGS,
    ) -> AlarmDistribution:
        """Return the distribution of the alarm after a change: see ``detection``. repeating_deviations (n,): expected after the
        changed ones; without any, the readings after these are not known.

        Readings are computed one by one until an alarm has come with ``sufficient_probability``, or until the sums have the
        same distribution after each cycle (over the charts that have not alarmed): from then on the share of these charts falls
        by the same factor in each cycle, for ever. If neither happens within ``most`` readings, no more is known; nor is
        that factor known where the nodes do not resolve the noise, on which it depends exponentially.
        """
        begin = [
            self._first_sums if normal_deviations is None else self.steady_state(normal_deviations, rising)[0]
            for rising in (True, False)
        ]
        upper, lower = (
            self._propagate(sums, chain(changed_deviations.tolist(), cycle(repeating_deviations.tolist())), rising)
            for sums, rising in zip(begin, (True, False), strict=True)
        )
        probabilities, no_alarm_shares, tail, before = (
            list[float](),
            [1.0, 1.0],
            np.zeros(len(repeating_deviations)),
            np.full((2, 1), np.nan),
        )
        is_resolved = self._spread == self.noise
        for count, sides in enumerate(zip(upper, lower, strict=True), 1 - len(changed_deviations)):
            no_alarm_shares = [m - alarms for m, (alarms, _) in zip(no_alarm_shares, sides, strict=True)]
            probabilities.append(1 - no_alarm_shares[0] * no_alarm_shares[1])
            if probabilities[-1] >= sufficient_probability or len(probabilities) == most:
                break
            if count > 0:
                # By the charts that stay, not by the difference to 1: accurate even where hardly any alarms.
                tail[(count - 1) % len(repeating_deviations)] = sum(
                    math.log1p(alarms / remaining.sum()) for alarms, remaining in sides
                )
            if is_resolved and count > 0 and count % len(repeating_deviations) == 0 and len(probabilities) >= _FIRST_READINGS:
                distribution = np.array([remaining / remaining.sum() for _, remaining in sides])
                if np.abs(distribution - before).sum() <= _CONVERGENCE:
                    return AlarmDistribution(np.array(probabilities), np.cumsum(tail))
                before = distribution
        return AlarmDistribution(np.array(probabilities), np.empty(0))


def design_chart(reference: float, noise: float, readings: float, expected_deviations: np.ndarray) -> Cusum:
    """Design the chart that alarms once in so many readings without a change.

    Parameters
    ----------
    reference : float
        k, half the change that is to be detected soonest.
    noise : float
        The standard deviation of a reading.
    readings : float
        The mean number between two false alarms.
    expected_deviations : numpy.ndarray, (n,)
        Of the readings from their mean without a change; these repeat.

    Returns
    -------
    Cusum

    Raises
    ------
    RunError
        Where there is no such chart.
    """
    from scipy.optimize import brentq

    low = 0.1 * max(noise, reference)
    cusum = Cusum(reference, low, noise)

    def missing(logarithm: float) -> float:
        return math.log(replace(cusum, threshold=math.exp(logarithm)).mean_alarm_interval(expected_deviations) / readings)

    if missing(math.log(low)) > 0:
        raise RunError(
            "even the lowest threshold gives fewer false alarms than requested: request rarer ones", code="too-few-alarms"
        )
    high = low
    while missing(math.log(high)) < 0:
        high *= 2
        if high > 1e6 * low:
            raise RunError("no threshold makes false alarms so rare: without a failure the readings vary too much")
    return replace(cusum, threshold=math.exp(brentq(missing, math.log(high / 2), math.log(high), xtol=1e-6)))


@lru_cache(maxsize=256)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    points, weights = np.polynomial.legendre.leggauss(count)
    return points, weights


def _normal(z: np.ndarray) -> np.ndarray:
    """The normal distribution's cumulative function."""
    from scipy.special import ndtr

    return np.asarray(ndtr(z))
