"""Attractors made by hand: how near a motion must come to itself, and which members stay on it."""

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


def attractor(sense: int = 1, period: float = 2.0) -> Attractor:
    points = np.array([[math.cos(a), math.sin(a), 10.0 + math.sin(a)] for a in np.linspace(0, 2 * math.pi, 500)])
    sizes = np.array([1.0, 1.0, 11.0])
    return Attractor(1, points / sizes, sizes, 0.02, sense, 9.0, 11.0, period, 1.0)


@pytest.mark.parametrize("sense", [1, -1])
def test_members_that_stay_near_it_and_move_along_it(sense: int) -> None:
    """Near its points, within its speeds and a tenth of their range, through nine tenths of it, half in less than a period."""
    phase = np.linspace(0.0, 2 * math.pi, 61)
    on, off = np.stack([phase, 10.0 + np.sin(phase)]), np.stack([phase, 10.5 + np.sin(phase)])
    samples = np.stack([on, on, on, on, off, on, on], axis=-1).transpose(1, 0, 2)
    speeds = sense * np.array([[9.0, 8.85, 9.0, 9.2, 9.0, 8.81, 9.9], [11.0, 11.0, 11.15, 11.01, 11.0, 11.19, 10.0]])
    everyone = np.arange(7)
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 2.0, everyone).tolist() == [0, 1, 2, 3, 5]
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 2.0, np.array([5, 4, 2])).tolist() == [
        5,
        2,
    ]
    speeds[:, 1], speeds[:, 2] = sense * np.array([8.79, 11.0]), sense * np.array([9.0, 11.21])
    speeds[:, 3] = sense * np.array([9.3, 11.0])
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 2.0, everyone).tolist() == [0, 5]
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 1.9, everyone).tolist() == [0, 3, 5]
