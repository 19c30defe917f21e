"""Test functions of special points, and the branches through a branch point, by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import sympy as sp
from equations_by_hand import by_hand

from wucht.errors import RunError
from wucht.numerics.continuation.equations import bordered_solution
from wucht.numerics.continuation.special_points import (
    BranchPoint,
    _derivative_along,
    _dips,
    _match_eigenvalues,
    _second_derivatives,
    branch_point_near,
    critical_pairs,
    least_real,
    may_cross,
)

X, Y, P = sp.symbols("x y p", real=True)


def pairs(*eigenvalues: complex) -> tuple[float, bool]:
    return critical_pairs(np.array(eigenvalues, complex))


def test_the_least_sum_of_two_eigenvalues() -> None:
    """In terms of their sizes, with the sign of the product of all sums; of a complex pair or a neutral saddle."""
    assert pairs(2.0, -1.0) == (pytest.approx(1 / 3), False) and pairs(1.0, -2.0) == (pytest.approx(-1 / 3), False)
    assert pairs(0.5 + 1j, 0.5 - 1j) == (pytest.approx(0.5 / math.hypot(0.5, 1.0)), True)
    assert pairs(3.0) == (1.0, False) and pairs(0.0, 0.0) == (0.0, False)
    # Sums 1 - 3 = -2 of 4, 1 + 10 of 11, -3 + 10 of 13: the first, and one of them is negative.
    assert pairs(1.0, -3.0, 10.0) == (pytest.approx(-0.5), False)
    # Sums -2 of 4, -9 of 11, -13 of 13: three are negative.
    assert pairs(1.0, -3.0, -10.0) == (pytest.approx(-0.5), False)
    assert pairs(-1.0, 0.1 + 2j, 0.1 - 2j) == (pytest.approx(0.2 / (2 * math.hypot(0.1, 2.0))), True)
    assert pairs(-1.0, -0.1 + 2j, -0.1 - 2j) == (pytest.approx(-0.2 / (2 * math.hypot(0.1, 2.0))), True)
    # The pair whose sum is least is none of the complex one: 1 - 1.2.
    assert pairs(1.0, -1.2, 3 + 1j, 3 - 1j)[0] == pytest.approx(-0.2 / 2.2)


def test_the_least_eigenvalue_with_the_sign_of_the_product() -> None:
    assert least_real(np.array([-1.0, 2.0, 4.0], complex), 8.0) == pytest.approx(-1 / 8)
    assert least_real(np.array([-1.0, -2.0, 4.0], complex), 8.0) == pytest.approx(1 / 8)
    assert least_real(np.array([-1.0 + 1j, -1.0 - 1j, -0.5], complex), 2.0) == pytest.approx(-1 / 4)
    assert least_real(np.zeros(2, complex), 0.0) == 0.0


@pytest.mark.parametrize(
    ("a", "m", "b", "passes"),
    [
        (1.0, -0.1, 1.0, True), (-1.0, 0.1, -1.0, True),  # below zero half way, mirrored
        (1.0, 0.5, 1.0, False), (-1.0, -0.5, -1.0, False), (1.0, 0.6, 0.2, False), (1.0, 0.1, 0.05, True),
        (1.0, -0.1, -1.0, False),  # a change of sign is no secret
        (1.0, 0.09, 1.0, True), (1.0, 0.16, 1.0, True), (1.0, 0.18, 1.0, False),  # 0.05 of the bend, 4 (1 - m)
        (0.0, 1e-12, 0.0, False), (0.0, -1e-3, 0.0, True), (1e-12, -1e-3, 1e-12, True),
        (0.0, 0.5, 1.0, False), (0.0, -0.1, 1.0, True), (1e-12, 0.5, -1.0, True), (1e-12, -0.5, -1.0, False),  # from zero
    ],
)  # fmt: skip
def test_a_parabola_that_passes_zero_within_a_step(a: float, m: float, b: float, passes: bool) -> None:
    for sign in (1.0, -1.0) if max(abs(a), abs(b)) > 1e-9 else (1.0,):
        assert _dips(sign * a, sign * m, sign * b, 1e-9) is passes and _dips(sign * b, sign * m, sign * a, 1e-9) is passes


def test_eigenvalues_are_matched_to_the_closest_and_its_extrapolation() -> None:
    """Those that pass each other go on; None where two have the same or their number changes."""
    assert _match_eigenvalues([0j, 10 + 0j], [4 + 0j, 6 + 0j], [2 + 0j, 8 + 0j]) == [(0, 4, 8), (10, 6, 2)]
    assert _match_eigenvalues([0j, 1 + 0j], [5 + 0j, 90 + 0j], [9 + 0j, 8 + 0j]) is None
    assert _match_eigenvalues([0j], [0j, 1j], [0j]) is None


def test_two_eigenvalues_that_pass_zero_and_come_back_between_two_points() -> None:
    """Of a plane by determinant and trace half way, of three states by their eigenvalues there."""
    stable = np.array([-1.0, -2.0], complex)
    assert may_cross(stable, np.diag([0.1, -2.0]), stable, 1e-9) and not may_cross(stable, np.diag([-1.0, -2.0]), stable, 1e-9)
    focus = np.array([-1 + 1j, -1 - 1j])
    assert may_cross(focus, np.array([[0.1, 1.0], [-1.0, 0.1]]), focus, 1e-9)
    assert not may_cross(focus, np.array([[-1.0, 1.0], [-1.0, -1.0]]), focus, 1e-9)
    three = np.append(focus, -3.0)
    there = np.array([[0.1, 1.0, 0.0], [-1.0, 0.1, 0.0], [0.0, 0.0, -3.0]])
    assert may_cross(three, there, three, 1e-9) and not may_cross(three, there - 1.1 * np.eye(3), three, 1e-9)
    assert may_cross(np.array([-1.0 + 0j]), np.array([[0.2]]), np.array([-1.0 + 0j]), 1e-9)


def test_the_sign_of_a_determinant_of_bordered_equations() -> None:
    """Whatever rows are exchanged."""
    draw = np.random.default_rng(5)
    for _ in range(30):
        matrix, side = draw.normal(size=(4, 4)), draw.normal(size=(4, 2))
        solution, sign = bordered_solution(matrix[:-1], matrix[-1], side)
        assert matrix @ solution == pytest.approx(side) and sign == np.sign(np.linalg.det(matrix))
    with pytest.raises(RunError):
        bordered_solution(np.zeros((1, 2)), np.array([1.0, 0.0]), np.eye(2))


def test_derivatives_along_a_direction_and_in_units_of_scale() -> None:
    """Of x^2 p and y^3 at (1, 2, 3), with sizes 2, 1, 4."""
    equations = by_hand([X**2 * P, Y**3], [X, Y]).with_scale(np.array([2.0, 1.0, 4.0]))
    u, v = np.array([1.0, 2.0, 3.0]), np.array([1.0, -1.0, 0.5])
    along = np.array([[2 * 3.0 * 1.0 + 2 * 1.0 * 0.5, 0.0, 2 * 1.0 * 1.0], [0.0, 6 * 2.0 * -1.0, 0.0]])
    assert _derivative_along(equations, u, v) == pytest.approx(along, abs=1e-6)
    second = _second_derivatives(equations, u)
    expected = np.zeros((2, 3, 3))
    expected[0, 0, 0], expected[1, 1, 1] = 6.0, 12.0
    expected[0, 0, 2] = expected[0, 2, 0] = 2.0
    # The derivative of a row of the Jacobian by u_k times s_j s_k.
    sizes = np.array([2.0, 1.0, 4.0])
    assert second == pytest.approx(expected * sizes * sizes[:, None], abs=1e-5)


@pytest.mark.parametrize("along", [None, np.array([1.0, 2.0]), np.array([-1.0, 0.3])])
def test_both_branches_through_a_branch_point(along: Any) -> None:
    """(x - 2 p)(x + p/2) = 0: along (2, 1) and (-1/2, 1); the first is nearest to the direction, each has its sense."""
    equations = by_hand([(X - 2 * P) * (X + P / 2)], [X])
    computed = BranchPoint.from_point(equations, np.zeros(2), along)
    ways = np.array([[2.0, 1.0], [-0.5, 1.0]])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    to = np.array([0.0, 1.0]) if along is None else along
    order = np.argsort(-np.abs(ways @ to))
    expected = ways[order] * np.sign(ways[order] @ to)[:, None]
    assert computed.tangents == pytest.approx(expected, abs=1e-7)
    near = branch_point_near(equations, np.array([0.02, -0.03]))
    assert near.unknowns == pytest.approx([0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("slowness", [1.0, 1e-12, 1e-18, 1e-30])
def test_an_equation_counts_however_slow_it_is(slowness: float) -> None:
    """(x - 2 p)(x + p/2) = 0 as above, and y = x by a much slower equation than y + z = 0; next to the branch point, whose
    place is known but to some digits."""
    Z = sp.Symbol("z", real=True)
    equations = by_hand([(X - 2 * P) * (X + P / 2), sp.Float(slowness) * (Y - X), Y + Z], [X, Y, Z])
    computed = BranchPoint.from_point(equations, 1e-9 * np.array([1.0, 1.0, -1.0, 0.3]))
    ways = np.array([[2.0, 2.0, -2.0, 1.0], [-0.5, -0.5, 0.5, 1.0]])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    assert computed.tangents == pytest.approx(ways[np.argsort(-ways[:, -1])], abs=1e-7)


def test_where_branches_do_not_cross() -> None:
    """x^2 + p^2 is an isolated point, x^2 - p a fold."""
    for rates in ([X**2 + P**2], [X**2]):
        with pytest.raises(RunError):
            BranchPoint.from_point(by_hand(rates, [X]), np.zeros(2))
