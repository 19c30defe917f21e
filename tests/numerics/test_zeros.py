"""Zeros on a grid: all of them, to the last bit, in few evaluations."""

import math

import numpy as np
import pytest

from wucht.numerics.zeros import at_passages, crossings, first_where


def test_crossings() -> None:
    grid = np.linspace(0.0, 10.0, 41)
    assert crossings(np.sin, grid) == pytest.approx([math.pi, 2 * math.pi, 3 * math.pi], rel=1e-15)
    assert crossings(np.sin, grid, -1) == pytest.approx([math.pi, 3 * math.pi], rel=1e-15)
    assert crossings(np.sin, grid, 1) == pytest.approx([2 * math.pi], rel=1e-15)
    assert crossings(lambda x: x - 2.5, grid) == pytest.approx([2.5])  # a point of the grid
    assert len(crossings(np.zeros_like, grid)) == len(crossings(np.ones_like, grid)) == 0
    assert len(crossings(lambda x: (x - 2.5) ** 2, grid)) == 0


@pytest.mark.parametrize(
    ("function", "zero"),
    [
        (lambda x: x**3 - 2, 2 ** (1 / 3)),
        (lambda x: np.exp(-x) - 1e-3, math.log(1e3)),
        (lambda x: 1e-300 * (x - 2.2), 2.2),
        (lambda x: (x - 3.3) ** 5, 3.3),
        (lambda x: 1 / (x - 3.3), 3.3),  # a pole
        (lambda x: np.sign(x - 1.2345), 1.2345),
        (lambda x: np.where(x < 2.1, -1e-20, 1e20), 2.1),
    ],
)
def test_to_the_last_bit(function, zero) -> None:
    assert crossings(function, np.linspace(0.05, 12.1, 37)) == pytest.approx([zero], rel=5e-16)


def test_few_evaluations_of_smooth_functions() -> None:
    count = 0

    def function(x: np.ndarray) -> np.ndarray:
        nonlocal count
        count += 1
        return np.cos(x) - x / 10

    assert len(crossings(function, np.linspace(0.0, 10.0, 41))) == 3
    assert count <= 12


def test_the_first_where_a_condition_holds() -> None:
    assert first_where(lambda x: x * x >= 2, 0.0, 2.0) == pytest.approx(math.sqrt(2), rel=3e-16)
    assert first_where(lambda x: x >= 1.5, 0.0, 2.0) == 1.5


def test_what_a_curve_is_where_samples_pass_a_value() -> None:
    """Between samples by straight lines; a stretch that stays on the value is its first sample."""
    samples, of = np.array([0.0, 2.0, 4.0, 4.0, 1.0]), np.array([[0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 10.0, 20.0, 30.0, 40.0]])
    before, there = at_passages(samples, 3.0, of)
    assert before.tolist() == [1, 3]
    np.testing.assert_allclose(there, [[1.5, 3 + 1 / 3], [15.0, 30 + 10 / 3]])
    before, there = at_passages(samples, 4.0, of[0])
    assert (before.tolist(), there.tolist()) == ([1, 2, 3], [2.0, 2.0, 3.0])
