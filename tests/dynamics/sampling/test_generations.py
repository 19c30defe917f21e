"""What a search by generations learns of candidates that are not allowed, or have no objective."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.sampling.searches import generations


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
