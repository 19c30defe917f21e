from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from tests.refusals import refused

from wucht.numerics.continuation.deflation import (
    Deflation,
    deflated_solutions,
    disconnected_branches,
    equilibria_at,
    random_starts,
)
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.system import System

X, Y, P, T = sp.symbols("x y p theta", real=True)
UNFOLDED = System((X,), (P * X - X**3 + sp.Rational(1, 100),), (P,))


def equations(system: System) -> EquilibriumEquations:
    return EquilibriumEquations.from_system(system, ["p"], {})


def test_one_start_leads_to_all_four() -> None:
    """x^2 + y^2 = 4, x y = 1: x = +-sqrt(2 +- sqrt(3))."""
    found = deflated_solutions(equations(System((X, Y), (X**2 + Y**2 - P, X * Y - 1), (P,))), [4.0], np.array([[0.3], [0.9]]))
    a, b = math.sqrt(2 - math.sqrt(3)), math.sqrt(2 + math.sqrt(3))
    np.testing.assert_allclose(sorted(found.T.tolist()), [[-b, -a], [-a, -b], [a, b], [b, a]], rtol=1e-14)


def test_angles_are_the_same_after_a_whole_turn() -> None:
    """sin 2 theta = p has four solutions on the circle."""
    found = deflated_solutions(
        equations(System((T,), (sp.sin(2 * T) - P,), (P,), angles=frozenset({T}))), [0.1], np.array([[0.3]])
    )
    small = math.asin(0.1) / 2
    expected = [small, math.pi / 2 - small, math.pi + small, 3 * math.pi / 2 - small]
    np.testing.assert_allclose(sorted(found[0] % (2 * math.pi)), expected, rtol=1e-13)


def test_the_branch_that_does_not_touch() -> None:
    """x^3 = p x + 0.01: the pitchfork's other half has a fold at p = 3 (0.01 / 2)^(2/3), x = -(0.01 / 2)^(1/3)."""
    problem = EquilibriumContinuation(equations(UNFOLDED), (-1, 1))
    first = problem.follow_branch(problem.start([-0.01], -1.0))
    assert first.special == () and first.unknowns[0, -1] > 0.9
    both = disconnected_branches(problem, [-0.5, 0.0, 0.5], np.array([[-0.3]]))
    assert len(both) == 2
    (other,) = disconnected_branches(problem, [0.5], random_starts([-1], [1], 4), known_branches=[first])
    for branch in (both[1], other):
        (fold,) = branch.special
        assert fold.kind == "fold" and fold.parameter == pytest.approx(3 * 0.005 ** (2 / 3), rel=1e-10)
        assert fold.x[0] == pytest.approx(-(0.005 ** (1 / 3)), rel=1e-9)
        np.testing.assert_allclose(sorted(equilibria_at(branch, 0.5)[0]), np.sort(np.roots([-1, 0, 0.5, 0.01]))[:2], rtol=1e-12)


def test_work_is_bounded() -> None:
    """Without solutions too, and where the Jacobian is singular or the equations cannot be evaluated."""
    nothing = equations(System((X,), (X**2 + 1 + P,), (P,)))
    found = deflated_solutions(nothing, [0.0], np.array([[0.0, 0.3, 2.0]]), settings=Deflation(steps=30))
    assert found.shape == (1, 0)
    few = deflated_solutions(nothing, [0.0], np.array([[0.3, 2.0]]), settings=Deflation(evaluations=10))
    assert few.shape == (1, 0)
    root = equations(System((X,), (sp.sqrt(X) - P,), (P,)))
    assert deflated_solutions(root, [1.0], np.array([[-1.0, 0.5]])) == pytest.approx(np.array([[1.0]]))


def test_the_shift_keeps_a_start_from_running_away() -> None:
    """x^2 = 1, 1 being known: (x + 1) / (x - 1) falls forever beyond 1, with the shift the way leads back, to -1."""
    square, start, known = equations(System((X,), (X**2 - 1 + P,), (P,))), np.array([[5.0]]), np.array([[1.0]])
    assert deflated_solutions(square, [0.0], start, known) == pytest.approx(np.array([[-1.0]]))
    assert deflated_solutions(square, [0.0], start, known, Deflation(shift=0.0)).shape == (1, 0)


def test_starts_are_checked_and_reproducible() -> None:
    with refused("starts", given="an array of shape (2, 3)"):
        deflated_solutions(equations(UNFOLDED), [0.0], np.zeros((2, 3)))
    np.testing.assert_array_equal(random_starts([0, 1], [1, 3], 4, seed=3), random_starts([0, 1], [1, 3], 4, seed=3))
    assert (random_starts([0, 1], [1, 3], 50)[1] >= 1).all()
