"""The rule of all searches: the choice by a check, against optima in closed form, by several seeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from wucht.dynamics.sampling.choice import Contest, Scores, nearest_cliff

Place = tuple[float, ...]


def scores(*rows: Sequence[float], failing: Sequence[Sequence[int]] | None = None) -> Scores:
    costs = np.array(rows, float)
    return Scores(costs, np.zeros(costs.shape, bool) if failing is None else np.array(failing, bool))


def test_the_fewest_failing_samples_come_first_then_the_least_median() -> None:
    made = scores([1, 2, 9], [3, 3, 3], [1, 1, 1], failing=[[0, 0, 0], [0, 0, 0], [0, 1, 0]])
    assert made.medians.tolist() == [2, 3, 1] and made.order.tolist() == [0, 1, 2]
    assert scores([2.0], [1.0], [1.0]).order.tolist() == [1, 2, 0], "of equal ones the first"


def test_differences_are_paired() -> None:
    """Times that spread by 1 s from start to start, and two candidates that are 0.1 s apart at each of them."""
    common = np.random.default_rng(1).normal(5.0, 1.0, 64)
    made = scores(common, common + 0.1, np.random.default_rng(2).normal(5.1, 1.0, 64))
    difference, error = made.difference(0, 1)
    assert difference == pytest.approx(-0.1) and error < 1e-12 < made.standard_error(0)
    assert made.is_better(0, 1) and not made.is_better(1, 0)
    assert not made.is_better(0, 2) and made.difference(0, 2)[1] > 0.1, "chance explains it"


def test_the_standard_error_of_a_median_is_that_of_many_draws() -> None:
    """Of a normal sample: sqrt(pi / 2) sigma / sqrt(n)."""
    draws = np.random.default_rng(3).normal(0.0, 2.0, (200, 400))
    errors = [scores(draw).standard_error(0) for draw in draws[:20]]
    assert np.mean(errors) == pytest.approx(np.median(draws, axis=1).std(), rel=0.15)
    assert np.mean(errors) == pytest.approx(np.sqrt(np.pi / 2) * 2.0 / 20.0, rel=0.15)


def test_a_failing_sample_or_two_are_chance_more_are_not() -> None:
    none, one, ten = (np.arange(64) < k for k in (0, 1, 10))
    made = Scores(np.array([np.full(64, 2.0), np.full(64, 1.0), np.full(64, 1.0)]), np.array([none, one, ten]))
    assert made.is_better(1, 0), "it is faster, and fails as often but for chance"
    assert made.is_better(0, 2) and not made.is_better(2, 0)
    assert scores([1.0], [2.0]).is_better(0, 1) and not scores([1.0], [1.0]).is_better(0, 1), "nothing is chance"


@pytest.mark.parametrize(("cost", "is_lost"), [(4.0, False), (4.1, True), (np.inf, True)])
def test_what_is_half_as_good_is_not_lost_yet(cost: float, is_lost: bool) -> None:
    made = scores([2.0], [cost])
    assert made.is_lost(1, 0) is is_lost
    assert not made.is_lost(1, 0, ratio=None), "where costs do not count"
    assert not scores([0.0], [1.0]).is_lost(1, 0), "everything is a multiple of nothing"


@pytest.mark.parametrize(("failing", "is_lost"), [(1, False), (2, True)])
def test_a_tenth_more_failing_samples_are_a_loss(failing: int, is_lost: bool) -> None:
    made = scores([1.0] * 10, [1.0] * 10, failing=[[0] * 10, [1] * failing + [0] * (10 - failing)])
    assert made.is_lost(1, 0, ratio=None) is is_lost


def test_the_nearest_cliff_is_that_of_the_smallest_ratio() -> None:
    """A quarter of the value is farther than three times it, though 75 % are less than 200 %."""
    made = scores([1.0], [1.5], [9.0], [9.0], [1.0])
    values, sides = [[4.0, 5.0], [3.0, 5.0], [1.0, 5.0], [12.0, 5.0], [4.0, 7.0]], [(0, [1, 2]), (0, [3]), (1, [4])]
    cliff = nearest_cliff(made, 0, "ab", values, sides)
    assert cliff is not None and (cliff.parameter, cliff.inside, cliff.value, cliff.cost) == ("a", 4.0, 12.0, 9.0)
    assert cliff.distance == 2.0
    below = nearest_cliff(made, 0, "ab", values, sides[:1])
    assert below is not None and (below.inside, below.value, below.distance) == (3.0, 1.0, -0.75)
    assert nearest_cliff(made, 0, "ab", values, sides[2:]) is None


# --- known optima ---


@dataclass(frozen=True)
class Problem:
    """Cost (P,) of places (P, k) in the unit cube, without chance; ``best``: where it is least, in closed form, or what is
    kept. spread: of the lognormal factor of each sample. own: what the user has. failing: share (P,) of failing samples."""

    cost: Callable[[np.ndarray], np.ndarray]
    best: Place
    own: Place
    spread: float = 0.3
    failing: Callable[[np.ndarray], np.ndarray] | None = None

    def scores(self, places: Sequence[Place], stream: int, samples: int, seed: int) -> Scores:
        """Scores by samples that are common to all places, with a part of their luck that differs from place to place."""
        x = np.array(places)
        rng = np.random.default_rng([seed, stream])
        common, phase, level = rng.normal(size=samples), rng.uniform(0, 2 * np.pi, samples), rng.uniform(size=samples)
        own = np.sqrt(2) * np.sin(phase + 60.0 * x.sum(axis=1)[:, None])
        costs = self.cost(x)[:, None] * np.exp(self.spread * (0.8 * common + 0.6 * own))
        share = np.zeros(len(x)) if self.failing is None else self.failing(x)
        return Scores(costs, level < share[:, None])


def settling(x: np.ndarray) -> np.ndarray:
    """Of a linear oscillator: 1 over its slowest rate of decay, damping ratios 0.1 to 10; least at critical damping, 1/2."""
    zeta = 10.0 ** (2 * x[:, 0] - 1)
    return np.asarray(1 / np.where(zeta < 1, zeta, zeta - np.sqrt(np.maximum(zeta**2 - 1, 0.0))))


MASS = 0.1  # of an absorber, relative


def absorber(x: np.ndarray) -> np.ndarray:
    """Largest amplitude of an undamped mass with an absorber: frequency ratios 0.7 to 1.1, damping ratios 0.02 to 0.5.

    J. P. Den Hartog, Mechanical Vibrations, 3.3: equal peaks at the ratio 1/(1 + mu), damping sqrt(3 mu/(8 (1 + mu)^3)).
    """
    f, zeta, g = (0.7 + 0.4 * x[:, :1]), 0.02 * 25 ** x[:, 1:], np.linspace(0.5, 1.5, 2001)
    damper = (2 * zeta * g) ** 2
    top = damper + (g**2 - f**2) ** 2
    bottom = damper * (g**2 - 1 + MASS * g**2) ** 2 + (MASS * f**2 * g**2 - (g**2 - 1) * (g**2 - f**2)) ** 2
    return np.asarray(np.sqrt(top / bottom).max(axis=1))


ABSORBER = (1 / (1 + MASS) - 0.7) / 0.4, np.log(np.sqrt(3 * MASS / (8 * (1 + MASS) ** 3)) / 0.02) / np.log(25)


def bowl(*centre: float) -> Callable[[np.ndarray], np.ndarray]:
    """1 at a centre, 2 at a distance of a half."""
    return lambda x: np.asarray(1 + 4 * ((x - np.array(centre)) ** 2).sum(axis=1))


def valley(x: np.ndarray) -> np.ndarray:
    """Narrow, along a diagonal: least at (0.6, 0.4)."""
    along, across = x[:, 0] - x[:, 1] - 0.2, x[:, 0] + x[:, 1] - 1.0
    return np.asarray(1 + 2 * along**2 + 20 * across**2)


PROBLEMS = {
    "critical damping": Problem(settling, (0.5,), (0.1,)),
    "absorber": Problem(absorber, ABSORBER, (0.2, 0.2), spread=0.0),
    "bowl": Problem(bowl(0.3), (0.3,), (0.9,)),
    "bowl of two variables": Problem(bowl(0.7, 0.4), (0.7, 0.4), (0.1, 0.9)),
    "diagonal valley": Problem(valley, (0.6, 0.4), (0.1, 0.1)),
    "end of the range": Problem(lambda x: 1 + x[:, 0], (0.0,), (0.7,)),
    "much chance": Problem(bowl(0.6), (0.6,), (0.0,), spread=1.0),
    "what one has is best": Problem(bowl(0.4, 0.4), (0.4, 0.4), (0.4, 0.4)),
    "nothing matters": Problem(lambda x: np.ones(len(x)), (0.5,), (0.5,)),
    "beside a cliff": Problem(lambda x: 1 + x[:, 0], (0.45,), (0.9,), failing=lambda x: 1.0 * (x[:, 0] < 0.45)),
}
KEPT = ("what one has is best", "nothing matters")
STEP = 1 / 16


def neighbours(place: Place, step: float) -> list[Place]:
    moved = [(k, np.clip(place[k] + sign * step, 0.0, 1.0)) for k in range(len(place)) for sign in (-1, 1)]
    return [(*place[:k], round(float(x), 6), *place[k + 1 :]) for k, x in moved]


def searched(problem: Problem, seed: int) -> tuple[Contest[Place], Place]:
    """The luckiest of 96 candidates in 16 samples, the comparison by other samples, and the choice."""
    tried = [tuple(p) for p in np.random.default_rng([seed, 9]).uniform(size=(96, len(problem.own))).round(4).tolist()]
    lucky = [tried[k] for k in problem.scores(tried, 0, 16, seed).order[:3]]
    race = Contest.of([*lucky, problem.own], lambda p: problem.scores(p, 1, 32, seed))
    polished = race.climb(neighbours, (2 * STEP, STEP), lambda p: problem.scores(p, 1, 32, seed))
    finalists = [polished.best, *race.ranking[:2], problem.own]
    check = lambda p: problem.scores(p, 2, 64, seed)  # noqa: E731
    final = Contest.of(finalists, check).climb(neighbours, (STEP,), check)
    return final, final.choice(problem.own)


def is_never_worse_than_what_is_shown(problem: Problem, seed: int) -> None:
    """By the check, and without chance to three standard errors of the paired difference."""
    final, chosen = searched(problem, seed)
    k, true = final.candidates.index(chosen), problem.cost(np.array(final.candidates))
    share = np.zeros(len(true)) if problem.failing is None else problem.failing(np.array(final.candidates))
    assert not any(final.scores.is_better(i, k) for i in range(len(true)))
    assert chosen in (problem.own, final.best)
    for i in np.flatnonzero(share <= share[k]):
        difference, error = true[k] - true[i], final.scores.difference(k, i)[1]
        assert difference <= 3 * error + 1e-12, (final.candidates[i], chosen)
    assert share[k] == share.min()
    assert set(neighbours(final.best, STEP)) <= set(final.candidates), "all its neighbours are shown"


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_choice_survives_its_own_result(name: str) -> None:
    is_never_worse_than_what_is_shown(PROBLEMS[name], 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS)
def test_ten_seeds_each(name: str) -> None:
    """The optimum is met to a step of the neighbours where the cost tells it, and what is as good is kept."""
    problem = PROBLEMS[name]
    for seed in range(10):
        is_never_worse_than_what_is_shown(problem, seed)
    chosen = np.array([searched(problem, seed)[1] for seed in range(10)])
    if name in KEPT:
        assert (chosen == problem.own).all(axis=1).sum() >= 9
    assert (np.median(problem.cost(chosen)) / problem.cost(np.array([problem.best]))[0] - 1) < 0.05
