"""Two special points within one step, whose effects on the eigenvalues at its ends cancel, and starts on branch points.

Every equation has its answer in closed form. Steps are 0.2 long; the points are a share of that apart, at several places in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
import sympy as sp
from tests.refusals import failed

from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.equilibria import Branch, Equilibria
from wucht.numerics.continuation.special_points import may_cross

X, Y, Z, W, P = sp.symbols("x y z w p", real=True)
Rates = list[sp.Expr]
STEP, RANGE = 0.2, (-1.0, 1.0)


def problem(rates: Rates, bounds: tuple[float, float] = RANGE) -> Equilibria:
    states = [X, Y, Z, W][: len(rates)]
    f = sp.lambdify([*states, P], rates, "numpy")
    derivatives = sp.lambdify([*states, P], sp.Matrix(rates).jacobian([*states, P]).tolist(), "numpy")

    def values(unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array(f(*unknowns), float), np.array(derivatives(*unknowns), float)

    return Equilibria(Equations.from_function(values, [s.name for s in states], ["p"]), bounds)


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


@pytest.mark.parametrize("share", [0.3, 0.05, 0.01])
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
    for begin in (-0.97, -0.91, -0.83):
        found = of.branch(of.start([0.0] * of.equations.n, begin))
        assert kinds(found) == [(kind, pytest.approx(-a, abs=1e-9)), (kind, pytest.approx(a, abs=1e-9))]


@pytest.mark.parametrize("share", [0.3, 0.05, 0.01])
def test_two_folds_within_a_step_are_found(share: float) -> None:
    """p = x^3/3 - a^2 x: folds at x = -a and a."""
    a = share * STEP / 2
    of = problem([P - (X**3 / 3 - a**2 * X)])
    for x in (-1.1, -1.04):
        found = of.branch(of.start([x], x**3 / 3 - a**2 * x))
        assert [p.kind for p in found.special] == ["fold", "fold"]
        assert [p.x[0] for p in found.special] == pytest.approx([-a, a], abs=1e-9)


@pytest.mark.parametrize("share", [0.3, 0.05])
def test_two_points_beside_a_third_are_found(share: float) -> None:
    """A fold p = z^2 - 0.5 with a pair that crosses on one side of it and comes back."""
    a = share * STEP / 3
    beside = problem([*pair(5 * (Z - a) * (Z - 2 * a), 1, X, Y), P - Z**2 + 0.5])
    for begin in (-0.97, -0.91, -0.83):
        branch = beside.branch(beside.start([0, 0, begin], begin**2 - 0.5))
        assert sorted(p.kind for p in branch.special) == ["fold", "hopf", "hopf"]
        assert sorted(p.x[2] for p in branch.special) == pytest.approx([0, a, 2 * a], abs=1e-9)


def test_what_comes_near_and_does_not_cross_is_nothing() -> None:
    """A real part that touches zero, one that nearly does, and p = x^3, which rises all the way."""
    for off in (0.0, 1e-9, 1e-4, 1e-2):
        of = problem(pair(-(P**2) - off, 1, X, Y))
        found = of.branch(of.start([0, 0], -0.93))
        assert found.special == ()
    of = problem([P - X**3])
    assert of.branch(of.start([-0.9], -0.729)).special == ()


def test_the_limits_of_what_is_found() -> None:
    """Points nearer to one another than 1/256 of a step lie beside its middles; peaks are seen that are half a step wide."""
    of = problem(one_pair(STEP / 2 * 1e-4))
    assert of.branch(of.start([0, 0], -0.933)).special == ()
    a = 0.25 * STEP
    peak = problem(pair(1.5 * sp.exp(-((P / a) ** 2) * math.log(1.5)) - 1, 1, X, Y))
    for begin in (-0.97, -0.91, -0.83):
        assert kinds(peak.branch(peak.start([0, 0], begin))) == [("hopf", pytest.approx(s * a, abs=1e-9)) for s in (-1, 1)]


def test_eigenvalues_that_may_cross() -> None:
    """Parabolas of the real part of a pair, through three points, and what is rounding."""

    def asked(real: Sequence[float], rounding: float = 1e-8) -> list[bool]:
        a, m, b = real
        two, three = ([np.array([r + 1j, r - 1j, -1.0][:k]) for r in (a, b)] for k in (2, 3))
        matrix = np.array([[m, -1, 0], [1, m, 0], [0, 0, -1.0]])
        return [may_cross(v[0], matrix[: len(v[0]), : len(v[0])], v[1], rounding) for v in (two, three)]

    for s in (-1, 1):
        assert asked([s * 0.1, -s * 0.01, s * 0.1]) == [True, True]  # the middle is on the other side
        assert asked([s * 0.05, s * 0.075, s * 0.6]) == [True, True]  # (t - 0.2) (t - 0.25)
        assert asked([s * 0.3, s * 0.2, s * 0.3]) == [False, False]  # far from zero
        assert asked([s * 0.1, s * 0.2, s * 0.3]) == [False, False]
    assert asked([1e-10, -1e-10, 1e-10]) == [False, False]


def test_a_start_on_a_branch_point_is_on_both_branches() -> None:
    """x (p - r - x^2) = 0, y = sin(p), at p = r = 1/sqrt(2), a number that rounding cuts off; from states beside it too."""
    r = math.sqrt(0.5)
    of = problem([X * (P - r - X**2), -Y + sp.sin(P)])
    for x in (0.0, 0.05):
        start = of.start([x, math.sin(r)], r)
        np.testing.assert_allclose(start.unknowns, [0, math.sin(r), r], atol=1e-10)
        np.testing.assert_allclose(start.tangent, np.array([0, math.cos(r), 1]) / math.hypot(math.cos(r), 1), atol=1e-7)
        found = of.branch(start)
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


def test_the_unknown_that_leaves_its_range_is_named() -> None:
    """p = x^2 + x - 2: the state leaves its limits at one end, the parameter its range at the other."""
    of = problem([P - X**2 - X + 2], (-3, 3))
    limited = Equilibria(of.equations, of.bounds, limits={0: (-1.0, 5.0)})
    assert set(limited.branch(limited.start([0.0], -2.0)).ends) == {
        "it leaves the range at x = -1",
        "it leaves the range at p = 3",
    }
    with failed("out-of-range", "x = -2", "-1", "5"):
        limited.branch(limited.start([-2.0], 0.0))
