"""What of many points no other one is better than."""

import numpy as np

from wucht.dynamics.sampling.pareto_search import not_dominated, spread_out


def test_not_dominated_is_what_pairs_say() -> None:
    points = np.round(np.random.default_rng(3).random((60, 3)), 1)
    better = [[bool((q <= p).all() and (q < p).any()) for q in points] for p in points]
    assert np.array_equal(not_dominated(points), ~np.any(better, axis=1))
    assert not_dominated(np.array([[1.0, 1.0], [1.0, 1.0]])).all(), "equal points do not dominate each other"


def test_spread_out_has_the_best_of_each_and_gaps_filled() -> None:
    t = np.linspace(0, 1, 101)
    chosen = spread_out(np.stack([t, 1 - t], axis=1), 5)
    assert np.allclose(t[chosen], [0, 0.25, 0.5, 0.75, 1], atol=0.01)
    assert len(spread_out(np.ones((7, 2)), 5)) == 1
