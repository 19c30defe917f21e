"""Branches that go wrong where steps are trusted: jumps, near misses, hidden events, starts on special points.

Every equation has its answer in closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
import sympy as sp
from equations_by_hand import P, Pair, Q, X, by_hand

from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import Branch, EquilibriumContinuation
from wucht.numerics.continuation.hopf_curves import HopfPoints

Y, Z, W = sp.symbols("y z w", real=True)


def branch(
    rates: Sequence[sp.Expr], states: Sequence[sp.Symbol], x: Sequence[float], p: float, low: float, high: float, **more: object
) -> Branch:
    problem = EquilibriumContinuation(by_hand(rates, states), (low, high), **more)  # type: ignore[arg-type]
    return problem.follow_branch(problem.start(x, p))


def kinds(found: Branch) -> list[tuple[str, float]]:
    return sorted((p.kind, p.parameter) for p in found.special)


@pytest.mark.parametrize(("steep", "coupling"), [(200, 0.1), (1000, 0.002)])
def test_a_bistable_switch_keeps_its_folds(steep: float, coupling: float) -> None:
    """x = tanh(k (p + c x)): folds where 1 - x^2 = 1/(k c). Newton's method jumps from one plateau to the other."""
    x = math.sqrt(1 - 1 / (steep * coupling))
    p = abs(math.atanh(x) / steep - coupling * x)
    found = branch([X - sp.tanh(steep * (P + coupling * X))], [X], [-1.0], -0.913, -1, 1)
    assert kinds(found) == [("fold", pytest.approx(-p, rel=1e-9)), ("fold", pytest.approx(p, rel=1e-9))]
    assert np.linalg.norm(np.diff(found.unknowns, axis=1), axis=0).max() < 0.21


@pytest.mark.parametrize("gap", [1e-4, 1e-6])
def test_an_imperfect_pitchfork_is_not_crossed(gap: float) -> None:
    """p x - x^3 + gap = 0: the stable branch bends away from the unstable one."""
    found = branch([P * X - X**3 + gap], [X], [gap], -1.0, -1, 1)
    assert found.special == () and not found.unstable.any()
    assert found.unknowns[0, -1] == pytest.approx(1 + gap / 2, rel=gap)


@pytest.mark.parametrize(("damped", "damping"), [(0, 1e-3), (4, 1e-3), (2, 1e-4)])
def test_hopf_points_of_weakly_damped_machines(damped: int, damping: float) -> None:
    """One oscillator is undamped at p = 0, others are hardly damped: of 45 sums of eigenvalues many are small."""
    states = sp.symbols(f"x0:{2 * damped + 2}", real=True)
    rates: list[sp.Expr] = []
    for i, (x, y) in enumerate(zip(states[::2], states[1::2], strict=True)):
        omega = 1 + 0.7 * i
        rates += [y, -(omega**2) * x - 2 * (damping * omega if i else -damping * P) * y]
    found = branch(rates, states, [0.0] * len(states), -0.913, -1, 1)
    assert kinds(found) == [("hopf", pytest.approx(0, abs=1e-11))] and found.unstable[[0, -1]].tolist() == [0, 2]


@pytest.mark.parametrize("width", [5e-3, 1e-3])
def test_a_hairpin_is_not_closed(width: float) -> None:
    """x^2 = width^2 (1 - p): both sides of the parabola are nearer to one another than a step is long."""
    found = branch([X**2 - width**2 * (1 - P)], [X], [1.4 * width], -1.0, -3, 2)
    assert found.ends == ("it leaves the range at p = -3",) * 2 and kinds(found) == [("fold", pytest.approx(1, abs=1e-9))]


def test_what_is_closed_is_known_and_what_nearly_is_is_not() -> None:
    """A thin ellipse is closed after a turn, a screw of small pitch is not, a figure of eight is after both its turns."""
    ellipse = branch([1e4 * X**2 + P**2 - 0.25], [X], [0.005], 0.01, -1, 1)
    assert ellipse.is_closed and kinds(ellipse) == [("fold", pytest.approx(s / 2, abs=1e-9)) for s in (-1, 1)]

    def screw(unknowns: np.ndarray) -> Pair:
        return np.array([math.sin(unknowns[0] - 300 * unknowns[1])]), math.cos(unknowns[0] - 300 * unknowns[1]) * np.array(
            [[1.0, -300.0]]
        )

    problem = EquilibriumContinuation(
        EquilibriumEquations.from_function(screw, ["theta"], ["p"], angles=["theta"]), (-0.1, 0.1)
    )
    turned = problem.follow_branch(problem.start([0.3], 0.001))
    assert not turned.is_closed and abs(turned.unknowns[0, -1] - turned.unknowns[0, 0]) == pytest.approx(60)
    x = math.sqrt(math.sqrt(1 + 4 * 0.02**2) - 1 - 0.02**2)  # (x^2 + p^2)^2 = 2 (p^2 - x^2)
    eight = branch([(X**2 + P**2) ** 2 - 2 * P**2 + 2 * X**2], [X], [x], 0.02, -3, 3)
    assert eight.is_closed and sorted(k for k, _ in kinds(eight)) == ["branch-point"] * 2 + ["fold"] * 2


def test_both_sides_of_other_branches_are_found_in_any_coordinates() -> None:
    """y (p - a y^2) = 0 of y, a linear function of the states, which are seen at an angle and in mixed sizes."""
    random = np.random.default_rng(5)
    for _ in range(12):
        n = int(random.integers(1, 7))
        seen = np.linalg.qr(random.normal(size=(n, n)))[0] @ np.diag(10 ** random.uniform(-1, 1, n))
        back, rates, a, moved = (
            np.linalg.inv(seen),
            -(10 ** random.uniform(-1, 2, n)),
            random.uniform(0.2, 2),
            random.normal(size=n),
        )
        equations = EquilibriumEquations.from_function(
            _pitchfork(seen, back, rates, a, moved), [f"x{i}" for i in range(n)], ["p"]
        )
        problem = EquilibriumContinuation(equations, (-1, 1))
        (at,) = problem.follow_branch(problem.start(moved * math.sin(-0.873), -0.873)).special
        assert (at.kind, at.parameter) == ("branch-point", pytest.approx(0, abs=1e-10))
        sides = []
        for first in problem.switch_branch(at):
            unknowns = np.array([p.unknowns for p in problem.walk(first)])
            y = (unknowns[:, :-1] - moved * np.sin(unknowns[:, -1:])) @ back[0]
            np.testing.assert_allclose(a * y**2, unknowns[:, -1], atol=1e-7)
            sides.append(np.sign(y[0]))
        assert sorted(sides) == [-1, 1]


def _pitchfork(
    seen: np.ndarray, back: np.ndarray, rates: np.ndarray, a: float, moved: np.ndarray
) -> Callable[[np.ndarray], Pair]:
    def values(unknowns: np.ndarray) -> Pair:
        p, y = unknowns[-1], back @ (unknowns[:-1] - moved * np.sin(unknowns[-1]))
        g, slope, by_p = rates * y, np.diag(rates), np.zeros(len(y))
        g[0], slope[0, 0], by_p[0] = y[0] * (p - a * y[0] ** 2), p - 3 * a * y[0] ** 2, y[0]
        return seen @ g, np.c_[seen @ slope @ back, seen @ (by_p - slope @ back @ moved * np.cos(p))]

    return values


def test_the_other_branch_is_met_within_the_bounds() -> None:
    """p = 1e4 x^2: 0.01 away from the branch point it has left the range."""
    problem = EquilibriumContinuation(by_hand([X * (P - 1e4 * X**2)], [X]), (-0.5, 0.5))
    (at,) = problem.follow_branch(problem.start([0.0], -0.4)).special
    for first in problem.switch_branch(at):
        assert 0 < first.unknowns[1] < 0.5 and list(problem.walk(first))[-1].parameter == 0.5


def test_events_that_hide_each_other_are_found_or_named() -> None:
    """Two folds in a step, two Hopf points in a narrow range, and two pairs that cross at once."""
    wiggle = 1 / 15  # p = x^3/3 - wiggle^2 x: folds at +-wiggle, 0.13 apart, and steps are 0.2 long
    found = branch([P - (X**3 / 3 - wiggle**2 * X)], [X], [-1.1], -(1.1**3) / 3 + 1.1 * wiggle**2, -1, 1)
    assert kinds(found) == [("fold", pytest.approx(s * 2 / 3 * wiggle**3, rel=1e-9)) for s in (-1, 1)]
    trace = 1e6 * (P - 3e-4) * (P - 6e-4)
    narrow = branch([trace * X - Y, X + trace * Y], [X, Y], [0, 0], 0.0, 0, 1e-3)
    assert kinds(narrow) == [("hopf", pytest.approx(3e-4, rel=1e-9)), ("hopf", pytest.approx(6e-4, rel=1e-9))]
    twice = branch([P * X - Y, X + P * Y, P * Z - W, Z + P * W], [X, Y, Z, W], [0, 0, 0, 0], -0.913, -1, 1)
    assert kinds(twice) == [("unresolved", pytest.approx(0, abs=1e-3))]


def test_special_points_at_the_start_are_told_once() -> None:
    """A fold, a Hopf point, a branch point, a function's zero; from the point that a branch has located, or by hand."""
    parabola = EquilibriumContinuation(
        by_hand([P - X**2], [X]), (-1, 1), functions={"half": lambda unknowns: unknowns[0] - 0.5}
    )
    first = parabola.follow_branch(parabola.start([0.5], 0.25))
    assert kinds(first) == [("fold", pytest.approx(0, abs=1e-12)), ("half", 0.25)]
    again = parabola.follow_branch(next(p for p in first.special if p.kind == "fold").point)
    assert [k for k, _ in kinds(again)] == ["fold", "half"]
    hopf = EquilibriumContinuation(by_hand([P * X - Y, X + P * Y], [X, Y]), (-1, 1))
    assert kinds(hopf.follow_branch(hopf.start([0, 0], 0.0))) == [("hopf", pytest.approx(0, abs=1e-12))]
    fork = EquilibriumContinuation(by_hand([P * X - X**3], [X]), (-1, 1))
    (at,) = fork.follow_branch(fork.start([0.0], -0.9)).special
    assert kinds(fork.follow_branch(at.point)) == [("branch-point", pytest.approx(0, abs=1e-12))]


def test_generalised_hopf_point_of_the_normal_form() -> None:
    """z' = (p + i + q |z|^2 - |z|^4) z: l1 is all there is, and passes zero at q = 0; its share jumps from -1 to 1."""
    r = X**2 + Y**2
    growth = P + Q * r - r**2
    problem = HopfPoints(by_hand([growth * X - Y, X + growth * Y], [X, Y], [P, Q]), ((-2, 2), (-2, 2)))
    (special,) = problem.follow_curve(problem.start([0, 0], [0, 1.1], 1.0)).special
    assert special.kind == "generalised-hopf" and np.abs(special.parameter_values).max() < 1e-10


def test_a_branch_that_leaves_the_range_for_less_than_a_step_ends_there() -> None:
    """p = 1 - x^2 up to 0.9999."""
    found = branch([1 - X**2 - P], [X], [1.0], 0.0, -1, 0.9999)
    assert found.ends == ("it leaves the range at p = -1", "it leaves the range at p = 0.9999")
    assert found.unknowns[-1, -1] == 0.9999 and found.special == ()


def test_a_constant_test_function_divides_by_nothing() -> None:
    """Where Newton's method fails between two points, several of the values that are left may be equal."""
    found = branch(
        [(X - P) / (X - sp.Rational(1, 2))],
        [X],
        [0.1],
        0.1,
        -1,
        1,
        functions={"d": lambda unknowns: np.sign(unknowns[0] - 0.5)},
    )
    assert found.ends == ("it leaves the range at p = -1", "it leaves the range at p = 1")
