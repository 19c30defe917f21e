"""What a search by generations learns of candidates that are not allowed, or have no objective."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.sampling.searches import generations, is_pareto_optimal, spread_selection


def test_a_search_leaves_what_is_not_feasible() -> None:
    """The smallest of x^2 + y^2 and (x - 1)^2 + y^2 with x above 0.5: below there is none, or it is not a number."""
    pytest.importorskip("pymoo")
    rng, last = np.random.default_rng(1), list[np.ndarray]()

    def value(number: int, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        assert ((shares >= 0) & (shares <= 1)).all() and number == len(last)
        last.append(shares)
        x, y = shares.T
        objectives = np.column_stack([x**2 + y**2, (x - 1) ** 2 + y**2])
        objectives[(x < 0.5) & (y < 0.5)] = np.nan
        return objectives, (x >= 0.5) | (y < 0.5)

    assert list(generations(12, rng.random((20, 2)), 2, 3, value)) == list(range(12))
    assert np.mean(last[-1][:, 0] >= 0.5) > 0.85 > np.mean(last[0][:, 0] >= 0.5)
    assert last[-1][:, 1].mean() < 0.2


def test_a_selection_of_more_points_than_there_are_has_all_that_differ() -> None:
    points = np.array([[0.0, 1.0], [1.0, 0.0], [0.6, 0.5], [0.6, 0.5]])
    assert spread_selection(points, 9).tolist() == [0, 1, 2]
    assert spread_selection(points[:3], 9).tolist() == [0, 1, 2] and spread_selection(points, 2).tolist() == [0, 1]
    assert spread_selection(points, 1).tolist() == [0]
    assert is_pareto_optimal(np.array([[0.0, 1.0], [0.0, 2.0], [1.0, 0.0], [1.0, 0.0]])).tolist() == [True, False, True, True]


def test_the_farthest_from_the_best_is_taken_next_in_shares_of_the_ranges() -> None:
    """The second objective is a thousand times as large."""
    points = np.array([[0.0, 1000.0], [1.0, 0.0], [0.9, 600.0], [0.45, 550.0]])
    assert spread_selection(points, 3).tolist() == [0, 1, 3]
