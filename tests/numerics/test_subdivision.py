"""All zeros in a box: counted against known ones, on the torus, with families and double zeros reported, not missed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.numerics.subdivision import all_zeros


def circles(x: np.ndarray) -> np.ndarray:
    """Two circles that cross in two points: x^2 + y^2 = 1, (x - 1)^2 + y^2 = 1."""
    return np.array([x[0] ** 2 + x[1] ** 2 - 1, (x[0] - 1) ** 2 + x[1] ** 2 - 1])


def circles_jacobian(x: np.ndarray) -> np.ndarray:
    return np.array([[2 * x[0], 2 * x[1]], [2 * (x[0] - 1), 2 * x[1]]])


def circles_spread(x: np.ndarray, r: np.ndarray) -> np.ndarray:
    return np.array([[2 * r[0], 2 * r[1]], [2 * r[0], 2 * r[1]]])


def test_two_circles() -> None:
    zeros = all_zeros(circles, circles_jacobian, circles_spread, [-3, -3], [3, 3])
    assert zeros.complete
    assert pytest.approx(np.array([[0.5, -math.sqrt(0.75)], [0.5, math.sqrt(0.75)]]), rel=1e-14) == zeros.points.T


@pytest.mark.parametrize("apart", [5e-8, 1e-10])
def test_two_zeros_that_nearly_coincide_are_two(apart: float) -> None:
    """Only what lies in both of two boxes with one zero each is one zero, whatever the distance."""

    def f(x: np.ndarray) -> np.ndarray:
        return (x - 0.3) * (x - 0.3 - apart)

    zeros = all_zeros(f, lambda x: (2 * (x - 0.3) - apart)[None], lambda x, r: 2 * r[None], [0.0], [1.0], smallest=1e-14)
    assert zeros.complete
    assert zeros.points[0] == pytest.approx([0.3, 0.3 + apart], abs=apart / 1e3)


def test_a_linear_equation_does_not_shrink_boxes_to_nothing() -> None:
    """The first equation alone fixes y: a box of no width would be excluded by the rounding of its last bit."""

    def f(x: np.ndarray) -> np.ndarray:
        return np.array([20.0 - 0.2 * x[1] + 20.2 - 0.2 * x[1] - 0.004 * x[1], np.cos(x[0]) + 0.01 * (x[1] - 99.0)])

    def jacobian(x: np.ndarray) -> np.ndarray:
        return np.array([[0 * x[0], -0.404 + 0 * x[0]], [-np.sin(x[0]), 0.01 + 0 * x[0]]])

    def spread(x: np.ndarray, r: np.ndarray) -> np.ndarray:
        return np.array([[0 * r[0], 0 * r[0]], [np.minimum(2.0, r[0]), 0 * r[0]]])

    zeros = all_zeros(f, jacobian, spread, [0.0, 24.0], [2 * math.pi, 101.0], periodic=[True, False])
    assert zeros.complete
    assert zeros.points.shape == (2, 2)


def test_a_double_zero_is_left_undecided() -> None:
    zeros = all_zeros(lambda x: x**2, lambda x: 2 * x[None], lambda x, r: 2 * r[None], [-1.0], [1.2])
    assert not zeros.complete
    centre, radius = zeros.undecided_boxes
    assert (np.abs(centre) <= radius + 1e-3).all()


def test_a_curve_of_zeros_is_left_undecided() -> None:
    """Both equations are the same circle: the boxes that stay lie along it, and surround it."""

    def twice(x: np.ndarray) -> np.ndarray:
        return np.array([x[0] ** 2 + x[1] ** 2 - 1] * 2)

    zeros = all_zeros(twice, lambda x: np.array([[2 * x[0], 2 * x[1]]] * 2), circles_spread, [-2, -2], [2, 2], smallest=0.01)
    assert not zeros.complete
    centre, radius = zeros.undecided_boxes
    assert np.abs(np.hypot(*centre) - 1).max() < 0.1
    angles = np.sort(np.arctan2(centre[1], centre[0]))
    assert np.diff(angles).max() < 0.1
    assert radius.max() <= 0.02 + 1e-12


@pytest.mark.parametrize("seed", range(2))
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
    zeros = all_zeros(f, slope, lambda x, r: curved * r[None], [0.0], [2 * math.pi], periodic=[True])
    assert zeros.complete
    grid = np.linspace(0, 2 * math.pi, 200_001)[None]
    assert zeros.points.shape[1] == (np.diff(np.sign(f(grid)[0])) != 0).sum()


def test_work_that_is_left_is_undecided() -> None:
    """After so many boxes; together they hold all zeros that are missing."""
    calls = list[int]()
    found = all_zeros(
        circles, circles_jacobian, circles_spread, [-3, -2], [3, 3], most_boxes=4, check=lambda: calls.append(1)
    )  # fmt: skip
    assert not found.complete and 4 <= found.boxes < 12 and len(calls) >= 2
    centres, radii = found.undecided_boxes
    for zero in ([0.5, -math.sqrt(0.75)], [0.5, math.sqrt(0.75)]):
        away = np.abs(centres - np.array(zero)[:, None]) <= radii + 1e-12
        assert away.all(axis=0).any() or np.abs(found.points - np.array(zero)[:, None]).max(axis=0).min(initial=1.0) < 1e-9


def test_a_zero_on_the_seam_of_a_circle() -> None:
    zeros = all_zeros(
        np.sin, lambda x: np.cos(x)[None], lambda x, r: np.minimum(2.0, r)[None], [0.0], [2 * math.pi], periodic=[True]
    )
    assert zeros.complete
    assert zeros.points.shape == (1, 2)
    assert np.cos(zeros.points[0]) == pytest.approx([-1, 1]) or np.cos(zeros.points[0]) == pytest.approx([1, -1])
