"""Search for a design: where it begins, which candidates it continues from, and which run is the design."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from wucht.dynamics.exciters.design_search import (
    best_apart,
    candidate_batches,
    local_optimum,
    nearest_that_beats,
    search_generations,
    sobol_points,
)
from wucht.dynamics.exciters.design_trials import Candidates, CheckedCandidate, DesignTrials
from wucht.dynamics.exciters.slow_beats import Beat
from wucht.dynamics.sampling.searches import Variable
from wucht.dynamics.work import Work
from wucht.fatigue.counted_cycles import LoadCycles

UNIT, WIDE = (Variable(n, None, (n,), low, high, "", "") for n, low, high in (("a", 0.0, 1.0), ("b", 0.1, 10.0)))
TARGET = LoadCycles(np.ones(1), np.zeros(1), np.ones(1))


class Valley(DesignTrials):
    """The distance is that of b from 1, by its logarithm."""

    def evaluate(self, numbers: np.ndarray, target: LoadCycles, report: Callable[[float], None]) -> Candidates:
        report(0.5)
        return candidates(numbers, np.abs(np.log(numbers[:, 1])))


def candidates(numbers: np.ndarray, far: np.ndarray) -> Candidates:
    n = len(numbers)
    return Candidates(numbers, np.array([far] * 3).T, np.zeros(n, int), np.ones(n), np.ones(n), np.ones(n))


TRIALS = Valley(None, (UNIT, WIDE), "displacement", "y", {}, True, 1e-8, 0, 4.0)  # type: ignore[arg-type]


def test_random_points_lie_in_the_ranges_and_differ_by_their_seed() -> None:
    first, again, other = (sobol_points(TRIALS, 12, seed) for seed in ([1, 0], [1, 0], [1, 1]))
    assert first.shape == (12, 2) and ((first >= 0) & (first < 1)).all()
    assert np.array_equal(first, again) and not np.array_equal(first, other)


def test_candidates_are_apart_in_one_variable_at_least() -> None:
    shares = np.array([[0.5, 0.5], [0.45, 0.55], [0.5, 0.7], [0.9, 0.5], [0.1, 0.1]])
    batch = candidates(TRIALS.values(shares), np.array([0.1, 0.2, 0.3, 0.4, np.nan]))
    for count, chosen in ((9, [0, 2, 3]), (2, [0, 2])):
        assert np.array_equal(best_apart(TRIALS, [batch], count), batch.numbers[chosen])


@pytest.mark.parametrize(("nominal", "is_inside"), [(0.5, True), (0.05, False), (20.0, False)])
def test_the_search_begins_at_the_best_points_and_the_nominal_exciter_if_it_is_in_the_ranges(
    nominal: float, is_inside: bool
) -> None:
    shares, work = list[float](), Work(reporter=lambda share, _: shares.append(share))
    points = TRIALS.values(sobol_points(TRIALS, 8, [1, 0]))
    reach = [*candidate_batches(TRIALS, points, TARGET, 4, "reach", work.part("", 0.0, 0.5))]
    assert [len(batch.motion) for batch in reach] == [4, 4] and np.array_equal(reach[1].numbers, points[4:])
    numbers = np.array([0.5, nominal])
    search = [*search_generations(TRIALS, numbers, TARGET, reach, 4, 3, 1, work.part("", 0.5, 1.0))]
    best = points[np.argsort(np.abs(np.log(points[:, 1])))][:4]
    assert search[0].numbers == pytest.approx(np.vstack([best[:3], numbers]) if is_inside else best)
    assert len(search) == 3 and shares == sorted(shares) and shares[-1] < 1.0
    assert search[-1].distances.min() <= search[0].distances.min()


def test_without_a_local_search_a_candidate_is_taken_itself() -> None:
    numbers, distance = local_optimum(TRIALS, np.array([0.5, 2.0]), TARGET, 0, "", Work())
    assert numbers.tolist() == [0.5, 2.0] and distance == pytest.approx(np.log(2.0))


def test_the_design_is_the_nearest_that_beats() -> None:
    """By the metric that is chosen; of equal ones the first."""
    far = [(0.1, 0.1, 0.1), (0.25, 0.75, 0.5), (0.375, 0.5, 0.625), (0.75, 0.625, 0.25), (np.nan,) * 3, (0.25, 0.5, 0.25)]
    none = np.empty(0)
    runs = [
        CheckedCandidate(none, Beat("modulated"), LoadCycles(none, none, none), np.array(distances), 1.0, "", k != 0, "")
        for k, distances in enumerate(far)
    ]
    assert [nearest_that_beats(runs, metric) for metric in range(3)] == [runs[1], runs[2], runs[3]]
    assert nearest_that_beats(runs[:1], 0) is None and nearest_that_beats([], 0) is None
