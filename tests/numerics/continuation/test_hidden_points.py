"""Two special points within one step, whose effects on the eigenvalues at its ends cancel, and starts on branch points.

Every equation has its answer in closed form. Steps are 0.2 long; the points are a share of that apart, at several places in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp
from equations_by_hand import by_hand
from tests.refusals import failed

from wucht.errors import RunError
from wucht.numerics.continuation.equilibria import Branch, EquilibriumContinuation
from wucht.numerics.continuation.special_points import (
    BranchPoint,
    branch_point_near,
)

X, Y, Z, W, P = sp.symbols("x y z w p", real=True)
Rates = list[sp.Expr]
STEP, RANGE = 0.2, (-1.0, 1.0)


def problem(rates: Rates, bounds: tuple[float, float] = RANGE) -> EquilibriumContinuation:
    return EquilibriumContinuation(by_hand(rates, [X, Y, Z, W][: len(rates)]), bounds)


def kinds(branch: Branch) -> list[tuple[str, float]]:
    return sorted((p.kind, p.parameter) for p in branch.special)


def pair(growth: sp.Expr, frequency: float, x: sp.Symbol, y: sp.Symbol) -> Rates:
    return [growth * x - frequency * y, frequency * x + growth * y]


def one_pair(a: float) -> Rates:
    return pair(5 * (P**2 - a**2), 1, X, Y)


def one_pair_beside_a_damped_one(a: float) -> Rates:
    return [*pair(a**2 - P**2, 1, X, Y), *pair(sp.Float(-0.03), 2, Z, W)]


def one_pair_by_no_parabola(a: float) -> Rates:
    return pair(sp.cosh(6 * P) - math.cosh(6 * a), 1, X, Y)


def two_pairs_of_opposite_sense(a: float) -> Rates:
    return [*pair(P + a, 1, X, Y), *pair(a - P, 2, Z, W)]


def one_eigenvalue(a: float) -> Rates:
    return [X * (P**2 - a**2 - X**2)]


def one_eigenvalue_of_three(a: float) -> Rates:
    return [X * (sp.cosh(6 * P) - math.cosh(6 * a) - X**2), -Y + X * Z, -Z - X]


def two_eigenvalues_of_opposite_sense(a: float) -> Rates:
    return [X * (P + a - X**2), -Y * (P - a + Y**2), W - Z, -W - Z]


@pytest.mark.parametrize("share", [0.3, 0.01])
@pytest.mark.parametrize(
    ("kind", "rates"),
    [
        ("hopf", one_pair),
        ("hopf", one_pair_beside_a_damped_one),
        ("hopf", one_pair_by_no_parabola),
        ("hopf", two_pairs_of_opposite_sense),
        ("branch-point", one_eigenvalue),
        ("branch-point", one_eigenvalue_of_three),
        ("branch-point", two_eigenvalues_of_opposite_sense),
    ],
)
def test_two_points_within_a_step_that_cancel_are_found(kind: str, rates: Callable[[float], Rates], share: float) -> None:
    a = share * STEP / 2
    of = problem(rates(a))
    for begin in (-0.97, -0.83):
        found = of.follow_branch(of.start([0.0] * of.equations.n, begin))
        assert kinds(found) == [(kind, pytest.approx(-a, abs=1e-9)), (kind, pytest.approx(a, abs=1e-9))]


@pytest.mark.parametrize("share", [0.3, 0.01])
def test_two_folds_within_a_step_are_found(share: float) -> None:
    """p = x^3/3 - a^2 x: folds at x = -a and a."""
    a = share * STEP / 2
    of = problem([P - (X**3 / 3 - a**2 * X)])
    for x in (-1.1, -1.04):
        found = of.follow_branch(of.start([x], x**3 / 3 - a**2 * x))
        assert [p.kind for p in found.special] == ["fold", "fold"]
        assert [p.x[0] for p in found.special] == pytest.approx([-a, a], abs=1e-9)


@pytest.mark.parametrize("share", [0.3, 0.05])
def test_two_points_beside_a_third_are_found(share: float) -> None:
    """A fold p = z^2 - 0.5 with a pair that crosses on one side of it and comes back."""
    a = share * STEP / 3
    beside = problem([*pair(5 * (Z - a) * (Z - 2 * a), 1, X, Y), P - Z**2 + 0.5])
    for begin in (-0.97, -0.83):
        branch = beside.follow_branch(beside.start([0, 0, begin], begin**2 - 0.5))
        assert sorted(p.kind for p in branch.special) == ["fold", "hopf", "hopf"]
        assert sorted(p.x[2] for p in branch.special) == pytest.approx([0, a, 2 * a], abs=1e-9)


def test_what_comes_near_and_does_not_cross_is_nothing() -> None:
    """A real part that touches zero, one that nearly does, and p = x^3, which rises all the way."""
    for off in (0.0, 1e-9, 1e-4, 1e-2):
        of = problem(pair(-(P**2) - off, 1, X, Y))
        found = of.follow_branch(of.start([0, 0], -0.93))
        assert found.special == ()
    of = problem([P - X**3])
    assert of.follow_branch(of.start([-0.9], -0.729)).special == ()


def test_the_limits_of_what_is_found() -> None:
    """Points nearer to one another than 1/256 of a step lie beside its middles; peaks are seen that are half a step wide."""
    of = problem(one_pair(STEP / 2 * 1e-4))
    assert of.follow_branch(of.start([0, 0], -0.933)).special == ()
    a = 0.25 * STEP
    peak = problem(pair(1.5 * sp.exp(-((P / a) ** 2) * math.log(1.5)) - 1, 1, X, Y))
    for begin in (-0.97, -0.91, -0.83):
        assert kinds(peak.follow_branch(peak.start([0, 0], begin))) == [
            ("hopf", pytest.approx(s * a, abs=1e-9)) for s in (-1, 1)
        ]


def test_a_start_on_a_branch_point_is_on_both_branches() -> None:
    """x (p - r - x^2) = 0, y = sin(p), at p = r = 1/sqrt(2), a number that rounding cuts off; from states beside it too."""
    r = math.sqrt(0.5)
    of = problem([X * (P - r - X**2), -Y + sp.sin(P)])
    for x in (0.0, 0.05):
        start = of.start([x, math.sin(r)], r)
        np.testing.assert_allclose(start.unknowns, [0, math.sin(r), r], atol=1e-10)
        np.testing.assert_allclose(start.tangent, np.array([0, math.cos(r), 1]) / math.hypot(math.cos(r), 1), atol=1e-7)
        found = of.follow_branch(start)
        assert kinds(found) == [("branch-point", pytest.approx(r, abs=1e-10))] and np.abs(found.unknowns[0]).max() < 1e-10
        assert found.ends == ("it leaves the range at p = -1", "it leaves the range at p = 1")
        for first in of.switch_branch(of.evaluate(start)):
            others = np.array([p.unknowns for p in of.walk(first)])
            np.testing.assert_allclose(others[:, 0] ** 2, others[:, 2] - r, atol=1e-9)
            assert others[-1, 2] == 1


@pytest.mark.parametrize("rates", [P - X**2, X**2 + P**2, X * (X - P) * (X + P)])
def test_a_start_where_the_equations_are_singular_otherwise_says_what_to_do(rates: sp.Expr) -> None:
    """A fold, a point that is alone, and three branches."""
    with failed("not-evaluated", "p = 0"):
        problem([rates]).start([0.0], 0.0)


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


@pytest.mark.parametrize("slowness", [1.0, 1e-30])
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
