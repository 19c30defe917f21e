"""All zeros in a box: counted against known ones, on the torus, with families and double zeros reported, not missed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.numerics.subdivision import all_zeros


def sine_spread(x: np.ndarray, r: np.ndarray) -> np.ndarray:
    return np.minimum(2.0, r)[None]


def test_zeros_of_the_cosine() -> None:
    found = all_zeros(np.cos, lambda x: -np.sin(x)[None], sine_spread, [0.0], [10.0])
    assert found.complete
    assert found.points[0] == pytest.approx(np.pi * np.array([0.5, 1.5, 2.5]), rel=1e-14)


def test_a_zero_on_the_seam_of_a_circle() -> None:
    found = all_zeros(np.sin, lambda x: np.cos(x)[None], sine_spread, [0.0], [2 * math.pi], periodic=[True])
    assert found.complete
    assert found.points.shape == (1, 2)
    assert np.cos(found.points[0]) == pytest.approx([-1, 1]) or np.cos(found.points[0]) == pytest.approx([1, -1])


def circles(x: np.ndarray) -> np.ndarray:
    """Two circles that cross in two points: x^2 + y^2 = 1, (x - 1)^2 + y^2 = 1."""
    return np.array([x[0] ** 2 + x[1] ** 2 - 1, (x[0] - 1) ** 2 + x[1] ** 2 - 1])


def circles_jacobian(x: np.ndarray) -> np.ndarray:
    return np.array([[2 * x[0], 2 * x[1]], [2 * (x[0] - 1), 2 * x[1]]])


def circles_spread(x: np.ndarray, r: np.ndarray) -> np.ndarray:
    return np.array([[2 * r[0], 2 * r[1]], [2 * r[0], 2 * r[1]]])


def test_two_circles() -> None:
    found = all_zeros(circles, circles_jacobian, circles_spread, [-3, -3], [3, 3])
    assert found.complete
    assert pytest.approx(np.array([[0.5, -math.sqrt(0.75)], [0.5, math.sqrt(0.75)]]), rel=1e-14) == found.points.T


def test_none() -> None:
    found = all_zeros(lambda x: x**2 + 0.01, lambda x: 2 * x[None], lambda x, r: 2 * r[None], [-1.0], [1.0])
    assert found.complete
    assert found.points.shape == (1, 0)


def test_a_double_zero_is_left_undecided() -> None:
    found = all_zeros(lambda x: x**2, lambda x: 2 * x[None], lambda x, r: 2 * r[None], [-1.0], [1.2])
    assert not found.complete
    centre, radius = found.undecided
    assert (np.abs(centre) <= radius + 1e-3).all()


def test_a_curve_of_zeros_is_left_undecided() -> None:
    """Both equations are the same circle: the boxes that stay lie along it, and surround it."""

    def twice(x: np.ndarray) -> np.ndarray:
        return np.array([x[0] ** 2 + x[1] ** 2 - 1] * 2)

    found = all_zeros(twice, lambda x: np.array([[2 * x[0], 2 * x[1]]] * 2), circles_spread, [-2, -2], [2, 2], smallest=0.01)
    assert not found.complete
    centre, radius = found.undecided
    assert np.abs(np.hypot(*centre) - 1).max() < 0.1
    angles = np.sort(np.arctan2(centre[1], centre[0]))
    assert np.diff(angles).max() < 0.1
    assert radius.max() <= 0.02 + 1e-12


def test_a_limit_on_boxes_is_kept() -> None:
    found = all_zeros(circles, circles_jacobian, circles_spread, [-3, -3], [3, 3], most_boxes=5)
    assert not found.complete
    assert found.boxes <= 8


@pytest.mark.parametrize("seed", range(5))
def test_trigonometric_polynomials_against_a_fine_grid(seed: int) -> None:
    draw = np.random.default_rng(seed)
    k = np.arange(1, 5)
    a, b, c = draw.normal(size=4), draw.normal(size=4), draw.normal()

    def f(x: np.ndarray) -> np.ndarray:
        return np.array([c + (a[:, None] * np.cos(k[:, None] * x[0]) + b[:, None] * np.sin(k[:, None] * x[0])).sum(axis=0)])

    def slope(x: np.ndarray) -> np.ndarray:
        s, z = np.sin(k[:, None] * x[0]), np.cos(k[:, None] * x[0])
        return (k[:, None] * (b[:, None] * z - a[:, None] * s)).sum(axis=0)[None, None]

    curved = float((k**2 * np.hypot(a, b)).sum())
    found = all_zeros(f, slope, lambda x, r: curved * r[None], [0.0], [2 * math.pi], periodic=[True])
    assert found.complete
    grid = np.linspace(0, 2 * math.pi, 200_001)[None]
    assert found.points.shape[1] == (np.diff(np.sign(f(grid)[0])) != 0).sum()
