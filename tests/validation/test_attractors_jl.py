"""Attractors and shares of their basins against those of Attractors.jl (JuliaDynamics, MIT licence).

Source: its test suite, test/mapping/attractor_mapping.jl at commit 0d5b60a9 and test/mapping/attractor_mapping_tests.jl at
commit 71f24de7, ``expected_fs_raw``: fractions of 1000 starts drawn at random, to three digits. So each has a standard error of
sqrt(p (1 - p) / 1000) itself, beside that of the starts here.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from wucht.dynamics.limit_sets.basins import StartOutcomes, start_outcomes
from wucht.dynamics.limit_sets.limit_set import MotionKind
from wucht.files.user_system import UserSystem, equations_from

PUBLISHED_STARTS = 1000
LORENZ_84 = {"x": "-y^2 - z^2 - a*x + a*F", "y": "x*y - y - b*x*z + G", "z": "b*x*y + x*z - z"}
MAGNETS = {
    "x": "vx", "y": "vy",
    "vx": "-w^2*x - a*vx - (x + 0.5)/d1^3 - (x + 0.5)/d2^3 - (x - 1)/d3^3",
    "vy": "-w^2*y - a*vy - (y - h)/d1^3 - (y + h)/d2^3 - y/d3^3",
}  # fmt: skip
DISTANCES = {
    "h": "sqrt(3)/2", "d1": "sqrt((x + 0.5)^2 + (y - h)^2 + d^2)", "d2": "sqrt((x + 0.5)^2 + (y + h)^2 + d^2)",
    "d3": "sqrt((x - 1)^2 + y^2 + d^2)",
}  # fmt: skip


def lorenz_84() -> UserSystem:
    return equations_from({"states": LORENZ_84, "parameters": {"F": 6.886, "G": 1.347, "a": 0.255, "b": 4.0}})


def magnets() -> UserSystem:
    return equations_from({"states": MAGNETS, "parameters": {"w": 0.8, "a": 0.2, "d": 0.2}, "definitions": DISTANCES})


@cache
def shares_of_lorenz_84(count: int) -> dict[MotionKind, float]:
    starts = np.random.default_rng(0).uniform(-3, 3, (3, count))
    outcomes = start_outcomes(lorenz_84(), starts, tolerance=1e-9)
    assert (outcomes.outcome >= 0).all()
    return {one.kind: float((outcomes.outcome == k).mean()) for k, one in enumerate(outcomes.attractors)}


def agrees(share: float, count: int, published: float) -> bool:
    variance = share * (1 - share) / count + published * (1 - published) / PUBLISHED_STARTS
    return bool(abs(share - published) < 3 * np.sqrt(variance))


@pytest.mark.parametrize("count", [200, 3000])
@pytest.mark.parametrize(
    "published",
    [
        {MotionKind.EQUILIBRIUM: 0.642, MotionKind.PERIODIC: 0.193, MotionKind.CHAOTIC: 0.165},
        {MotionKind.EQUILIBRIUM: 0.645, MotionKind.PERIODIC: 0.175, MotionKind.CHAOTIC: 0.18},
    ],
)
def test_lorenz_84_has_three_attractors(published: dict[MotionKind, float], count: int) -> None:
    """F = 6.886, G = 1.347, a = 0.255, b = 4; starts in the box -3 to 3 of all states."""
    shares = shares_of_lorenz_84(count)
    assert shares.keys() == published.keys()
    for kind, share in shares.items():
        assert agrees(share, count, published[kind]), kind


def shares_of_magnets(outcomes: StartOutcomes) -> dict[str, float]:
    """By the place of the magnet: upper left, lower left, right."""
    assert (outcomes.outcome >= 0).all()
    assert all(one.kind is MotionKind.EQUILIBRIUM for one in outcomes.attractors)
    names = ["right" if one.mean[0] > 0 else "upper" if one.mean[1] > 0 else "lower" for one in outcomes.attractors]
    return {name: float((outcomes.outcome == k).mean()) for k, name in enumerate(names)}


@pytest.mark.parametrize(
    "published", [{"upper": 0.335, "lower": 0.318, "right": 0.347}, {"upper": 0.377, "lower": 0.314, "right": 0.309}]
)
def test_a_pendulum_over_three_magnets(published: dict[str, float]) -> None:
    """Starts at rest in the square -2 to 2; the second set of fractions is that of the later file."""
    starts = np.zeros((4, 3000))
    starts[:2] = np.random.default_rng(0).uniform(-2, 2, (2, 3000))
    shares = shares_of_magnets(start_outcomes(magnets(), starts, tolerance=1e-9))
    assert shares.keys() == published.keys()
    for name, share in shares.items():
        assert agrees(share, 3000, published[name]), name
