from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from tests.refusals import failed, rejected

from auto_demos import AB, LORENZ, PP2
from wucht.numerics.continuation.curve import Curve, Steps
from wucht.numerics.continuation.equations import EquilibriumEquations, FunctionProblem
from wucht.numerics.continuation.equilibria import Equilibrium, EquilibriumContinuation
from wucht.system import System

X, Y, P = sp.symbols("x y p", real=True)


def equilibria(
    system: System, varied: str, fixed: Mapping[str, float], low: float, high: float, **more: object
) -> EquilibriumContinuation:
    return EquilibriumContinuation(EquilibriumEquations.from_system(system, [varied], fixed), (low, high), **more)  # type: ignore[arg-type]


def kinds(points: tuple[Equilibrium, ...] | list[Equilibrium]) -> list[tuple[str, float]]:
    return [(p.kind, p.parameter) for p in points if p.kind]


def test_ab_hopf_and_folds() -> None:
    """AUTO-07p, demo ab, at p2 = 15 and 18."""
    for p2, expected in {
        15.0: [("hopf", 0.14688248), ("hopf", 0.2945108)],
        18.0: [("hopf", 0.11115348), ("fold", 0.11156508), ("fold", 0.09957414), ("hopf", 0.18383461)],
    }.items():
        problem = equilibria(AB, "p1", {"p2": p2}, 0, 0.5)
        branch = problem.follow_branch(problem.start([0, 0], 0.0))
        assert [k for k, _ in kinds(list(branch.special))] == [k for k, _ in expected]
        np.testing.assert_allclose([v for _, v in kinds(list(branch.special))], [v for _, v in expected], rtol=5e-8)
        assert branch.ends == ("it leaves the range at p1 = 0", "it leaves the range at p1 = 0.5")


def test_lorenz_pitchfork_and_hopf_on_both_sides() -> None:
    """rho = 1; Hopf at 470/19 (sigma = 10, beta = 8/3)."""
    problem = equilibria(LORENZ, "rho", {}, -1, 30, steps=Steps(most=1.0))
    trivial = problem.follow_branch(problem.start([0, 0, 0], 0.3))
    (pitchfork,) = trivial.special
    assert pitchfork.kind == "branch-point" and pitchfork.parameter == pytest.approx(1.0, abs=1e-10)
    for first in problem.switch_branch(pitchfork):
        points = list(problem.walk(first))
        assert [k for k, _ in kinds(points)] == ["hopf"]
        assert kinds(points)[0][1] == pytest.approx(470 / 19, rel=1e-12)
        assert np.sign(points[-1].x[0]) == np.sign(first.unknowns[0])


def test_pp2_branch_points_fold_and_hopf() -> None:
    """AUTO-07p, demo pp2."""
    problem = equilibria(PP2, "q", {}, 0, 1.5, limits={0: (-0.1, 2), 1: (-0.1, 5)})
    trivial = problem.follow_branch(problem.start([0, 0], 0.0))
    assert kinds(list(trivial.special)) == [("branch-point", pytest.approx(0.6, abs=1e-10))]
    prey = problem.follow_branch(problem.start([1, 0], 0.0))
    named = dict(kinds(list(prey.special)))
    assert named["fold"] == pytest.approx(0.83292932223, rel=1e-10)
    second = next(p for p in prey.special if p.kind == "branch-point" and p.parameter > 0.7)
    assert second.parameter == pytest.approx(0.82190434537, rel=2e-8)
    found = [kinds(list(problem.walk(first))) for first in problem.switch_branch(second)]
    assert ("hopf", pytest.approx(0.67159384754, rel=1e-7)) in itertools.chain(*found)


def test_a_branch_around_a_circle_of_an_angle_is_closed() -> None:
    """p = sin(theta): the angle goes on by a whole turn, p returns."""
    theta = sp.Symbol("theta", real=True)
    system = System((theta,), (P - sp.sin(theta),), (P,), angles=frozenset({theta}))
    problem = equilibria(system, "p", {}, -2, 2)
    branch = problem.follow_branch(problem.start([0.3], math.sin(0.3)))
    assert branch.is_closed
    assert branch.unknowns[:, -1] == pytest.approx(
        branch.unknowns[:, 0] + [2 * math.pi * np.sign(branch.unknowns[0, 5] - 0.3), 0]
    )
    assert sorted(v for _, v in kinds(list(branch.special))) == pytest.approx([-1, 1], abs=1e-12)
    assert len(branch.special) == 2


def test_two_hopf_points_within_a_step_do_not_hide_each_other() -> None:
    """Two oscillators, undamped at p = 0 and 0.01: the product of the sums of eigenvalues changes its sign twice."""
    z, w = sp.symbols("z w", real=True)
    rates = (P * X - Y, X + P * Y, (P - 0.01) * z - 2 * w, 2 * z + (P - 0.01) * w)
    problem = equilibria(System((X, Y, z, w), rates, (P,)), "p", {}, -1, 1, steps=Steps(first=0.13, most=0.2))
    found = problem.follow_branch(problem.start([0, 0, 0, 0], -0.9)).special
    assert kinds(found) == [("hopf", pytest.approx(0, abs=1e-9)), ("hopf", pytest.approx(0.01, abs=1e-9))]


def test_a_neutral_saddle_is_no_hopf_point() -> None:
    """Eigenvalues 1 and p: their sum is zero at p = -1, where nothing happens."""
    problem = equilibria(System((X, Y), (X, P * Y), (P,)), "p", {}, -2, -0.5)
    assert problem.follow_branch(problem.start([0, 0], -1.5)).special == ()


def test_rounding_of_the_tangent_is_no_fold() -> None:
    """exp(-x) = p: the parameter ceases to change as x grows."""
    problem = equilibria(System((X,), (P - sp.exp(-X),), (P,)), "p", {}, -1, 1, limits={0: (-1, 60)}, steps=Steps(most=1))
    branch = problem.follow_branch(problem.start([0.0], 1.0))
    assert branch.special == () and 60 in (branch.points[0].x[0], branch.points[-1].x[0])


def test_a_user_gives_residual_and_jacobian() -> None:
    """The circle, from functions alone."""
    problem = FunctionProblem(lambda unknowns: (np.array([unknowns @ unknowns - 1]), 2 * unknowns[None, :]), np.ones(2))
    curve = Curve(problem)
    walk = curve.follow(curve.start(np.array([1.0, 0.1]), np.array([0.0, 1.0])))
    points = [p for _, p in walk]
    assert walk.end == "it is closed"
    assert max(abs(p.unknowns @ p.unknowns - 1) for p in points) < 1e-12
    by_hand = EquilibriumEquations.from_function(
        lambda unknowns: (np.array([unknowns @ unknowns - 1]), 2 * unknowns[None, :]), ["x"], ["p"]
    )
    branch = EquilibriumContinuation(by_hand, (-2, 2))
    assert len(branch.follow_branch(branch.start([1.0], 0.1)).special) == 2


def test_bad_input_is_told() -> None:
    with rejected("no-parameter"):
        EquilibriumEquations.from_system(AB, ["p3"], {"p1": 1.0, "p2": 1.0})
    with rejected("no-value"):
        EquilibriumEquations.from_system(AB, ["p1"], {})
    with rejected("unknown-name", "q", "p1"):
        EquilibriumEquations.from_function(lambda u: (u[:1], np.eye(1, 2)), ["x"], ["p1"], {"q": 1.0})
    with rejected("time-dependent"):
        EquilibriumEquations.from_system(System((X,), (sp.Symbol("t", real=True) - P,), (P,)), ["p"], {})
    nothing = equilibria(System((X,), (X**2 + 1 + P**2,), (P,)), "p", {}, -1, 1)
    with failed("not-evaluated"):
        nothing.start([0.3], 0.0)


def test_scale_does_not_change_what_is_found() -> None:
    """The same equations in units a million times smaller."""
    scaled = {"u1": 1.0, "u2": 1.0, "p1": 1e-6}
    p1 = AB.parameters[0]
    system = System(AB.states, tuple(d.xreplace({p1: 1e6 * p1}) for d in AB.derivatives), AB.parameters)
    problem = EquilibriumContinuation(EquilibriumEquations.from_system(system, ["p1"], {"p2": 15.0}, scaled), (0, 0.3e-6))
    special = problem.follow_branch(problem.start([0, 0], 0.0)).special
    assert [p.parameter for p in special] == pytest.approx([0.14688248e-6, 0.2945108e-6], rel=1e-6)


def test_a_bound_on_which_the_equations_are_singular_is_approached() -> None:
    """x' = p (1 - x): at p = 0 every x stays. The branch x = 1 ends there, and does not turn into the line p = 0."""
    problem = equilibria(System((X,), (P * (1 - X),), (P,)), "p", {}, 0.0, 1.0)
    branch = problem.follow_branch(problem.start([1.0], 0.5))
    assert sorted(branch.ends) == [
        "it leaves the range at p = 0, where the equations are singular",
        "it leaves the range at p = 1",
    ]
    assert 0 < branch.unknowns[-1].min() < 1e-2 and branch.unknowns[0] == pytest.approx(1.0, abs=1e-9)


def test_of_two_bounds_that_a_step_passes_the_first_on_the_way_counts() -> None:
    """x = p: the parameter's bound 1 comes before the state's limit 1.05, though one step passes both."""
    limited = equilibria(
        System((X,), (P - X,), (P,)), "p", {}, 0.0, 1.0, limits={0: (-1, 1.05)}, steps=Steps(first=0.5, most=0.5)
    )
    branch = limited.follow_branch(limited.start([0.8], 0.8))
    assert max(branch.unknowns[-1]) == 1.0 and max(branch.unknowns[0]) == pytest.approx(1.0, abs=1e-12)


def test_a_point_is_taken_when_its_convergence_foretells_what_is_left() -> None:
    """Fewer evaluations, and what is left of the equations is below the tolerance all the same."""
    calls = [0]

    def ellipse(unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        calls[0] += 1
        return np.array([unknowns[0] ** 2 + 4 * unknowns[1] ** 2 - 1]), np.array([[2 * unknowns[0], 8 * unknowns[1]]])

    counts = []
    for foretold in (False, True):
        curve = Curve(
            FunctionProblem(ellipse, np.ones(2)), steps=Steps(most=0.05, tolerance=1e-8, predicts_correction=foretold)
        )
        exact = replace(curve, steps=replace(curve.steps, predicts_correction=False))
        start = exact.start(np.array([1.0, 0.1]), np.array([0.0, 1.0]))
        calls[0] = 0
        walk = curve.follow(start)
        points = [p for _, p in walk]
        counts.append(calls[0] / len(points))
        assert walk.end == "it is closed"
        assert max(abs(ellipse(p.unknowns)[0][0]) for p in points) < 1e-8
    assert counts[1] < 0.9 * counts[0]


LINE = FunctionProblem(lambda u: (np.array([u[0] - u[1]]), np.array([[1.0, -1.0]])), np.array([2.0, 4.0]))


def test_a_straight_curve_ends_on_its_bound() -> None:
    """At the last point exactly, at its length from the first one in units of the scale: sqrt(1/16 + 1/64) for 1/2."""
    curve = Curve(LINE, {0: (-1.0, 1.0)}, Steps(first=0.1, most=0.1), names=("x", "p"))
    start = curve.start(np.array([0.5, 0.5]), np.array([1.0, 1.0]))
    walk = curve.follow(start)
    points = [p for _, p in walk]
    assert (
        walk.end == "it leaves the range at x = 1"
        and points[-1].unknowns[0] == 1.0
        and points[-1].unknowns[1] == pytest.approx(1.0)
    )
    assert points[-1].length == pytest.approx(math.sqrt(1 / 16 + 1 / 64)) and points[0].length == pytest.approx(0.1)
    assert points[-1].tangent == pytest.approx(np.array([1.0, 1.0]) / math.sqrt(1 / 4 + 1 / 16))
    back = curve.follow(curve.backwards(start))
    assert [p.unknowns[0] for _, p in back][-1] == -1.0 and back.end == "it leaves the range at x = -1"
