"""How near a motion must come to itself to be an attractor, and which members stay on one."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from wucht.dynamics.sampling.attractors import Attractor
from wucht.dynamics.sampling.member_quantities import MemberQuantities

PHI, SPEED = sp.symbols("phi speed", real=True)
SYSTEM: Any = SimpleNamespace(states=(PHI, SPEED), angles={PHI})
NONE: Any = None
QUANTITIES = MemberQuantities(SYSTEM, NONE, NONE, 0, (0, 1))


def circle(count: int, turns: float = 2.0, growth: float = 0.0) -> np.ndarray:
    """Points (P, 2) on a circle of the radii 3 and 0.5, run through twice."""
    at = np.arange(count) * 2 * math.pi * turns / count
    return np.stack([3 * np.cos(at), 0.5 * (1 + growth * at) * np.sin(at)], axis=1)


def test_an_angle_is_embedded_by_its_cosine_and_sine() -> None:
    samples = np.array([[[0.5, 2.0], [10.0, 20.0]]])  # K = 1, two states, two members
    points = QUANTITIES.points(samples)
    assert points.shape == (1, 2, 3)
    assert points[0, 1] == pytest.approx([math.cos(2.0), math.sin(2.0), 20.0])


def test_a_motion_that_comes_back_is_an_attractor() -> None:
    """Its points are shares of its sizes; the reach is twice the gap between neighbours of the two rounds."""
    made = Attractor.of(circle(401), 4, 1, (8.0, 12.0), 0.5, 0.25)
    assert made is not None
    assert (made.outcome, made.sense, made.low, made.high, made.period, made.peak_distance_squared) == (
        4,
        1,
        8.0,
        12.0,
        0.5,
        0.25,
    )
    assert made.sizes == pytest.approx([3.0, 0.5], rel=1e-3) and np.abs(made.points).max(axis=0).tolist() == [1.0, 1.0]
    apart = 2 * math.pi * 2 / 401
    assert made.reach == pytest.approx(2 * apart / 2, rel=0.02), "the rounds are shifted by half a step"
    dense = Attractor.of(circle(15_000), 4, 1, (8.0, 12.0), 0.5, 0.25)
    assert dense is not None and dense.reach == 1e-3, "the least one"
    assert made.member_points[5, 0] == pytest.approx(circle(401)[5])


def test_a_motion_that_does_not_come_back_is_none() -> None:
    """The second round is away by 7 %, or by 3 %, of the size."""
    numbers = (4, 1, (8.0, 12.0), 0.5, 0.25)
    assert Attractor.of(circle(401, growth=0.02), *numbers) is None
    assert Attractor.of(circle(401, growth=0.002), *numbers) is not None
    half = circle(401, turns=1.0)
    assert Attractor.of(half, *numbers) is None, "the halves of a round are not near each other"


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
