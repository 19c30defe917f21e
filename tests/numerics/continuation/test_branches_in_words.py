"""What users get wrong, and why a branch ends, in sentences; starts at bounds; branches kept in files."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
import sympy as sp
from equations_by_hand import P, Pair, Q, X, by_hand
from tests.refusals import failed, rejected

from auto_demos import AB
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.continuation.fold_curves import Folds
from wucht.numerics.continuation.hopf_curves import HopfPoints
from wucht.system import System


def test_starts_at_bounds_and_beyond() -> None:
    problem = EquilibriumContinuation(by_hand([P - X], [X]), (-1, 1))
    found = problem.follow_branch(problem.start([1.0], 1.0))
    assert found.unknowns[-1].tolist() == sorted(set(found.unknowns[-1].tolist())) and found.unknowns[-1, [0, -1]].tolist() == [
        -1,
        1,
    ]
    with failed("out-of-range", "p = 3", "-1", "1"):
        problem.follow_branch(problem.start([3.0], 3.0))
    wrong = EquilibriumContinuation(problem.equations, (1, -1))
    with failed("empty-range", "1", "-1"):
        wrong.follow_branch(wrong.start([0.0], 0.0))


def test_what_a_user_gets_wrong_is_told_in_a_sentence() -> None:
    one, two = by_hand([P - X**2], [X]), by_hand([P - sp.sqrt(X) + Q], [X], [P, Q])
    with rejected("one-parameter", "p", "q"):
        EquilibriumContinuation(two, (-1, 1))
    for x in ([0.5, 0.3], 0.5):
        with rejected("shape", "1"):
            EquilibriumContinuation(one, (-1, 1)).start(x, 0.25)  # type: ignore[arg-type]
    with rejected("not-finite", "0.5"):
        EquilibriumContinuation(one, (-1, 1)).start([0.5], math.nan)
    with rejected("no-state", "5"):
        EquilibriumContinuation(one, (-1, 1), limits={5: (0, 1)})
    with rejected("name-taken"):
        EquilibriumContinuation(one, (-1, 1), functions={"fold": lambda unknowns: unknowns[0]})
    with failed("not-evaluated", "x = -1", "p = 0", "q = 0"):
        Folds(two, [(-1, 1), (-1, 1)]).start([-1.0], (0, 0))
    with failed("not-evaluated", "x = -1"):
        HopfPoints(two, [(-1, 1), (-1, 1)]).start([-1.0], (0, 0))
    with rejected("scale", "x", "0"):
        one.with_scale(np.array([0.0, 1.0]))
    with rejected("no-states"):
        EquilibriumEquations.from_system(System((), (), (P,)), ["p"], {})
    with rejected("given-twice"):
        EquilibriumEquations.from_system(AB, ["p1", "p1"], {"p2": 1.0})


def test_a_function_that_raises_beyond_its_region_ends_the_branch_there() -> None:
    def values(unknowns: np.ndarray) -> Pair:
        if unknowns[0] < -0.5:
            raise ValueError("outside")
        return np.array([unknowns[1] - unknowns[0]]), np.array([[-1.0, 1.0]])

    problem = EquilibriumContinuation(EquilibriumEquations.from_function(values, ["x"], ["p"]), (-1, 1))
    found = problem.follow_branch(problem.start([0.0], 0.0))
    assert found.ends[0].startswith("no further point could be computed") and found.unknowns[-1, 0] == pytest.approx(
        -0.5, abs=1e-6
    )
    with failed("not-evaluated"):
        problem.start([-0.7], -0.7)


def test_why_it_ends_names_an_interruption_and_what_ran_away() -> None:
    def interrupted(unknowns: np.ndarray) -> Pair:
        if unknowns[0] > 0.5:
            raise KeyboardInterrupt
        return np.array([unknowns[1] - unknowns[0]]), np.array([[-1.0, 1.0]])

    problem = EquilibriumContinuation(EquilibriumEquations.from_function(interrupted, ["x"], ["p"]), (-1, 1))
    walk = problem.walk(problem.start([0.0], 0.0))
    with pytest.raises(KeyboardInterrupt):
        list(walk)
    assert walk.end == "it was interrupted: KeyboardInterrupt"
    pole = EquilibriumContinuation(by_hand([P * X - 1], [X]), (0, 1), steps=Steps(points=300, most=1))
    ends = pole.follow_branch(pole.start([1.0], 1.0)).ends
    assert ends[0].startswith("it has reached the maximum number of points, 300; x changed from 1 to 2")


def test_a_branch_can_be_kept_in_a_file() -> None:
    problem = EquilibriumContinuation(EquilibriumEquations.from_system(AB, ["p1"], {"p2": 15.0}), (0, 0.3))
    whole = problem.follow_branch(problem.start([0, 0], 0.0))
    again = pickle.loads(pickle.dumps(whole))
    np.testing.assert_array_equal(again.unknowns, whole.unknowns)
    for kept, own in zip(
        again.equations.values(whole.unknowns[:, 3]), whole.equations.values(whole.unknowns[:, 3]), strict=True
    ):
        np.testing.assert_array_equal(kept, own)
