"""The choice of the best candidate: one rule for all searches.

The best candidate of a search is the luckiest one of its samples. So the choice is made by a check: all that competes, what the
user has among it, is evaluated on samples that the search has not used, the same ones for all (common random numbers), and the
best moves to a neighbour as long as one is better on these samples (compass search: T. G. Kolda, R. M. Lewis, V. Torczon, SIAM
Review 45 (2003) 385-482). It is then the best of all values that it is shown with. What the user has is kept where nothing is
better beyond chance. How far the result may be off is stated by the nearest cliff: the nearest value at which it is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

C = TypeVar("C", bound=Hashable)

_RESAMPLES = 400  # of the bootstrap
_CHANCE = 2.0  # standard errors: a larger difference is not due to chance, in 19 of 20 cases
_MOST_MOVES = 16  # of a compass search, with each of its steps
LOSS_RATIO = 2.0  # times the cost of the best one: half as good
_LOSS_SHARE = 0.1  # more of the samples fail


@dataclass(frozen=True, eq=False)
class Scores:
    """Costs (P, M) of P candidates in M samples, which are the same for all; inf where a sample has none. The cost of a
    candidate is their median. failing (P, M): the samples in which it fails, which count more than costs. Without chance M is
    1."""

    costs: np.ndarray
    failing: np.ndarray

    @cached_property
    def medians(self) -> np.ndarray:
        """Median cost (P,) of each candidate."""
        return np.asarray(np.median(self.costs, axis=1))

    @cached_property
    def failing_shares(self) -> np.ndarray:
        """Share (P,) of the samples in which each candidate fails."""
        return np.asarray(self.failing.mean(axis=1))

    @property
    def order(self) -> np.ndarray:
        """Indices (P,) of the candidates, the best first: the fewest failing samples, then the least cost; of equal ones the
        first."""
        return np.lexsort((self.medians, self.failing_shares))

    def standard_error(self, k: int) -> float:
        """Return the standard error of the cost of a candidate, inf where it is not known."""
        return self._deviation(np.median(self.costs[k][self._resamples], axis=1))

    def difference(self, k: int, rival: int) -> tuple[float, float]:
        """Return how much more a candidate costs than another one, and the standard error of that; paired by samples."""
        if not np.isfinite(self.medians[[k, rival]]).all():
            return float("nan"), float("inf")
        resample_medians = np.median(self.costs[[k, rival]][:, self._resamples], axis=2)
        with np.errstate(invalid="ignore"):
            return float(self.medians[k] - self.medians[rival]), self._deviation(resample_medians[0] - resample_medians[1])

    def is_better(self, k: int, rival: int) -> bool:
        """True if a candidate is better than another one beyond chance: it fails less often or, if it does not fail more
        often, it costs less."""
        failing = self.failing[k].astype(float) - self.failing[rival]
        more, error = float(failing.mean()), self._deviation(failing[self._resamples].mean(axis=1))
        if abs(more) > _CHANCE * error:
            return more < 0
        if not np.isfinite(self.medians[k]):
            return False
        difference, error = self.difference(k, rival)
        return np.isinf(self.medians[rival]) or difference < -_CHANCE * error

    def is_lost(self, k: int, best: int, ratio: float | None = LOSS_RATIO) -> bool:
        """True if a candidate has lost what the best one has: a tenth more of its samples fail, or it costs a multiple.

        ratio: that multiple, None where costs do not count.
        """
        if self.failing_shares[k] > self.failing_shares[best] + _LOSS_SHARE:
            return True
        return ratio is not None and bool(self.medians[best] > 0 and not self.medians[k] <= ratio * self.medians[best])

    @cached_property
    def _resamples(self) -> np.ndarray:
        count = self.costs.shape[1]
        return np.random.default_rng(count).integers(count, size=(_RESAMPLES, count))

    @staticmethod
    def _deviation(values: np.ndarray) -> float:
        return float(values.std()) if np.isfinite(values).all() else float("inf")


Evaluate = Callable[[Sequence[C]], Scores]  # scores of candidates, on the same samples in each call


@dataclass(frozen=True, eq=False)
class Contest(Generic[C]):
    """Candidates, and their scores on the same samples."""

    candidates: tuple[C, ...]
    scores: Scores

    @classmethod
    def of(cls, candidates: Sequence[C], evaluate: Evaluate[C]) -> Contest[C]:
        """Compare candidates; equal ones count once."""
        different = tuple(dict.fromkeys(candidates))
        return cls(different, evaluate(different))

    def with_candidates(self, candidates: Sequence[C], evaluate: Evaluate[C]) -> Contest[C]:
        """Compare with further candidates; those that are known are not evaluated again."""
        new = tuple(c for c in dict.fromkeys(candidates) if c not in self.candidates)
        if not new:
            return self
        ours, theirs = self.scores, evaluate(new)
        scores = Scores(np.concatenate([ours.costs, theirs.costs]), np.concatenate([ours.failing, theirs.failing]))
        return Contest((*self.candidates, *new), scores)

    @property
    def ranking(self) -> list[C]:
        """Candidates, the best first."""
        return [self.candidates[k] for k in self.scores.order]

    @property
    def best(self) -> C:
        """Best candidate."""
        return self.ranking[0]

    def choice(self, present: C | None = None) -> C:
        """Return the best candidate; what the user has, if it is among them, unless the best one is better beyond chance."""
        best = self.best
        if present is None or present not in self.candidates:
            return best
        places = self.candidates.index(best), self.candidates.index(present)
        return best if self.scores.is_better(*places) else present

    def climb(self, neighbours: Callable[[C, float], Sequence[C]], steps: Sequence[float], evaluate: Evaluate[C]) -> Contest[C]:
        """Compare the best one with its neighbours, and these with theirs, until none is better; with one step after another.

        neighbours: of a candidate, a step away from it.
        """
        comparison = self
        for step in steps:
            for _ in range(_MOST_MOVES):
                best = comparison.best
                comparison = comparison.with_candidates(neighbours(best, step), evaluate)
                if comparison.best == best:
                    break
        return comparison


@dataclass(frozen=True)
class Cliff:
    """The nearest value of a parameter at which the best result is lost, the others unchanged. value: there. inside: the last
    value before, at which it is not. best: value of the best candidate. cost, failing_share: at ``value``."""

    parameter: str
    best: float
    inside: float
    value: float
    cost: float
    failing_share: float

    @property
    def distance(self) -> float:
        """Distance relative to the best value; negative below it, inf from 0."""
        return (self.value - self.best) / abs(self.best) if self.best else float("inf")

    @property
    def remoteness(self) -> float:
        """Distance by which cliffs are compared: half the value is as far as twice the value."""
        if self.best * self.value > 0:
            return abs(float(np.log(self.value / self.best)))
        return abs(self.distance)

    @property
    def text(self) -> str:
        """Distance in words: ``0.6 % below``."""
        side = "below" if self.value < self.best else "above"
        return f"{100 * abs(self.distance):.2g} % {side}"


Sides = Sequence[tuple[int, Sequence[int]]]  # of a candidate: axes, and the indices of those beside it there, the nearest first


def nearest_cliff(
    scores: Scores,
    best: int,
    names: Sequence[str],
    values: np.ndarray | Sequence[Sequence[float]],
    sides: Sides,
    ratio: float | None = LOSS_RATIO,
) -> Cliff | None:
    """Return the nearest cliff, by the ratio of its value to the best one; None where there is none on these sides.

    Parameters
    ----------
    scores : Scores
    best : int
        Index of the best candidate.
    names : sequence of str
        Of the parameters.
    values : (P, axes)
        Of the candidates.
    sides : sequence of (int, sequence of int)
        Of the best candidate: see ``sides_on_grid``.
    ratio : float, optional
        Multiple of the best one's cost from which on it is lost, None where costs do not count.
    """
    cliffs = list[Cliff]()
    for axis, indices in sides:
        at_best = inside = float(values[best][axis])
        for k in indices:
            value = float(values[k][axis])
            if scores.is_lost(k, best, ratio):
                cost, failing = float(scores.medians[k]), float(scores.failing_shares[k])
                cliffs.append(Cliff(names[axis], at_best, inside, value, cost, failing))
                break
            inside = value
    return min(cliffs, key=lambda c: c.remoteness, default=None)


def sides_on_grid(values: np.ndarray, k: int) -> Sides:
    """Return the sides of a candidate on a grid. values: of all of them (P, axes)."""
    sides = list[tuple[int, Sequence[int]]]()
    for axis in range(values.shape[1]):
        is_beside = np.delete(values == values[k], axis, axis=1).all(axis=1)
        order = [i for i in np.argsort(values[:, axis], kind="stable").tolist() if is_beside[i]]
        at = order.index(k)
        sides += [(axis, order[:at][::-1]), (axis, order[at + 1 :])]
    return sides
