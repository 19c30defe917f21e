"""Outcomes of members in parts and selections, and the envelopes of those that are screened, by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht.dynamics.sampling.attractors import Attractor


def attractor(**more: Any) -> Attractor:
    points = np.array([[0.0, 0.0], [1.0, 0.0]])
    given = {"outcome": 3, "sizes": np.array([10.0, 2.0]), "reach": 0.1, "sense": 1, "low": 90.0, "high": 110.0}
    return Attractor(points=points, **(given | {"period": 7.0, "peak_distance_squared": 0.25} | more))


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(
    ("low", "high", "duration", "stays"),
    [
        (90.0, 110.0, 5.0, True), (95.0, 106.0, 5.0, True), (95.0, 104.0, 5.0, False), (95.0, 106.0, 8.0, False),
        (91.0, 110.0, 8.0, True), (88.5, 110.0, 8.0, True), (87.5, 110.0, 8.0, False), (90.0, 112.5, 8.0, False),
        (-110.0, -90.0, 8.0, False),
    ],
)  # fmt: skip
def test_who_goes_through_the_range_of_its_speed_stays_near_it(
    sense: int, low: float, high: float, duration: float, stays: bool
) -> None:
    """Half of the range in less than a period, nine tenths in more; and no more than a tenth of it outside."""
    samples = np.tile(np.array([[5.0, 10.5, 0.0], [0.0, 0.0, 0.5]]), (40, 1, 1))
    speeds = np.sort(sense * np.array([low, high]))[:, None] * np.ones(3)
    candidates = np.array([1, 2, 0])
    found = attractor(sense=sense).resident_members(lambda x: np.moveaxis(x, 1, 2), samples, speeds, duration, candidates)
    assert found.tolist() == ([1] if stays else []), "the second is 0.05 of its sizes away, the others half and a quarter"
