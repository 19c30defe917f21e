from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed

from wucht.numerics.continuation.curve import Curve, Steps, _passes_start, _whole_turns
from wucht.numerics.continuation.equations import CurvePoint, FunctionProblem
from wucht.numerics.continuation.equilibria import _crossings_agree, _unstable_counts, _without_turns


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


@pytest.mark.parametrize(("share", "is_used"), [(1.0, True), (0.91, True), (1.09, True), (0.89, False), (1.11, False)])
def test_a_prediction_that_leads_along_the_tangent_is_used(share: float, is_used: bool) -> None:
    """It is moved into the plane that is a step away; one that is too short or too long counts for nothing."""
    here = CurvePoint(np.array([1.0, 0.0]), np.array([0.0, 1.0]), None, 0.0, 1, np.array([-1.0, 0.0]))
    problem = FunctionProblem(lambda x: (np.array([x @ x - 1]), 2 * x[None]), np.ones(2))
    curve = Curve(problem, predict=lambda _, point, step: point.unknowns + np.array([0.007, share * step]))
    expected = [1.007, 0.1] if is_used else [1 - 0.1**2 / 2, 0.1]
    assert curve._guess(here, 0.1).tolist() == pytest.approx(expected, abs=1e-15)
    assert curve._guess(replace(here, bend=None), 0.1).tolist() == [1.0, 0.1]  # after a step that was too long


def test_the_bend_of_the_curve_is_known_at_the_second_point() -> None:
    """On a circle of radius 1 it points to the centre."""
    bends = []

    class Kept(FunctionProblem):
        def reformulate(self, point):  # type: ignore[no-untyped-def]
            bends.append((point.unknowns, point.bend))
            return super().reformulate(point)

    curve = Curve(
        Kept(lambda unknowns: (np.array([unknowns @ unknowns - 1]), 2 * unknowns[None, :]), np.ones(2)),
        steps=Steps(first=0.01, most=0.01, points=5),
    )
    list(curve.follow(curve.start(np.array([1.0, 0.0]), np.array([0.0, 1.0]))))
    for u, bend in bends:
        np.testing.assert_allclose(bend, -u, atol=0.01)


CIRCLE = FunctionProblem(lambda u: (np.array([u @ u - 1]), 2 * u[None, :]), np.ones(2))
LINE = FunctionProblem(lambda u: (np.array([u[0] - u[1]]), np.array([[1.0, -1.0]])), np.array([2.0, 4.0]))


def test_the_bound_that_is_passed_first() -> None:
    """Of those that are passed, the one next on the way; either side of each."""
    curve = Curve(CIRCLE, {0: (0.0, 2.0), 1: (-1.0, 1.0)})
    here = np.array([1.0, 0.5])
    assert curve.crossed_bound(here, np.array([2.0, 1.0])) is None and curve.crossed_bound(here, np.array([0.0, -1.0])) is None
    assert curve.crossed_bound(here, np.array([3.0, 0.6])) == (0, 2.0) and curve.crossed_bound(here, np.array([-1.0, 0.6])) == (
        0,
        0.0,
    )
    assert curve.crossed_bound(here, np.array([3.0, 1.6])) == (1, 1.0)  # after 5/11 of the way, 1/2 of it
    assert curve.crossed_bound(here, np.array([3.0, 1.4])) == (0, 2.0)  # after 1/2 of it, 5/9
    assert curve.crossed_bound(here, np.array([3.0, -3.5])) == (1, -1.0)  # after 3/8


def test_unknowns_on_a_bound_and_beyond_it() -> None:
    """Within a millionth of their scale, 2 and 4."""
    curve = Curve(LINE, {0: (0.0, 1.0), -1: (0.0, 1.0)})
    for u, within, on in (
        ([0.5, 0.5], True, False), ([1 + 1.9e-6, 0.5], True, True), ([1 + 2.1e-6, 0.5], False, False),
        ([-1.9e-6, 0.5], True, True), ([-2.1e-6, 0.5], False, False), ([0.5, 1 + 3.9e-6], True, True),
        ([0.5, 1 - 3.9e-6], True, True), ([0.5, 1 - 4.1e-6], True, False), ([0.5, -4.1e-6], False, False),
    ):  # fmt: skip
        assert (curve.is_within_bounds(np.array(u)), curve.is_on_bound(np.array(u))) == (within, on)


def test_a_first_point_out_of_its_range_is_refused() -> None:
    def start(bounds: dict[int, tuple[float, float]]) -> Any:
        curve = Curve(LINE, bounds, names=("x", "p"))
        return curve.follow(curve.start(np.array([0.5, 0.5]), np.array([1.0, 1.0])))

    with failed("out-of-range", "x = 0.5"):
        start({0: (1.0, 2.0)})
    with failed("out-of-range", "p = 0.5"):
        start({-1: (-2.0, -1.0)})
    with failed("empty-range", "1"):
        start({0: (1.0, 1.0)})


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


def test_a_point_between_two_lies_on_the_curve_at_its_share() -> None:
    """On the circle, between 0 and 0.3 rad: as far along, and with the tangent there."""
    curve = Curve(CIRCLE)

    def at(angle: float) -> CurvePoint:
        return replace(
            curve.start(np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])), length=5 + angle
        )

    for share in (0.1, 0.5, 0.9):
        middle = curve.point_between(at(0.0), at(0.3), share)
        assert middle.length == pytest.approx(5 + 0.3 * share)
        assert np.arctan2(middle.unknowns[1], middle.unknowns[0]) == pytest.approx(0.3 * share, abs=3e-4)
        assert middle.unknowns @ middle.unknowns == pytest.approx(1.0) and middle.tangent @ middle.unknowns == pytest.approx(
            0.0, abs=1e-9
        )


def test_the_next_step() -> None:
    """At most 1.6 times, at least half as long; by the turn and by the number of corrections; never longer than the longest."""
    curve = Curve(CIRCLE, steps=Steps(most=0.5, turn=0.15, corrections=3))
    for step, turned, corrections, expected in (
        (0.1, 0.1, 3, 0.15), (0.1, 0.05, 3, 0.16), (0.1, 0.05, 1, 0.16), (0.1, 0.0, 1, 0.16), (0.1, 0.05, 4, 0.1),
        (0.1, 0.05, 5, 0.05), (0.1, 0.05, 8, 0.05), (0.1, 0.2, 3, 0.075), (0.1, 9.0, 3, 0.05), (0.45, 0.0, 1, 0.5),
    ):  # fmt: skip
        assert curve._next_step(step, turned, corrections) == pytest.approx(expected)


def test_whole_turns_and_the_way_past_the_start() -> None:
    """Of angles the nearest ones; a point lies between two, within 0.3 of the way beside it."""
    turns = np.array([2.0, 0.0])
    assert _whole_turns(np.array([3.2, 3.2]), turns).tolist() == [4.0, 0.0]
    assert _whole_turns(np.array([-2.9, 9.0]), turns).tolist() == [-2.0, 0.0]
    a, b, none = np.zeros(2), np.array([2.0, 0.0]), np.zeros(2)
    for first, passed in (
        ([1.0, 0.59], True), ([1.0, 0.61], False), ([1.0, -0.59], True), ([-0.01, 0.0], False), ([0.0, 0.0], True),
        ([2.0, 0.0], True), ([2.01, 0.0], False),
    ):  # fmt: skip
        assert _passes_start(a, b, np.array(first), none) is passed
    assert _passes_start(a, b, np.array([11.0, 0.1]), np.array([5.0, 0.0])) and not _passes_start(
        a, b, np.array([11.0, 0.1]), none
    )


def test_an_unknown_that_runs_away_is_named() -> None:
    curve = Curve(LINE, names=("x", "p"))
    far = curve._runaway_note(np.array([1.0, 0.0]), np.array([202.0, 390.0]))
    assert "x changed from 1 to 202" in far and curve._runaway_note(np.array([1.0, 0.0]), np.array([200.0, 390.0])) == ""
    assert "p changed from 0 to -410" in curve._runaway_note(np.array([1.0, 0.0]), np.array([1.0, -410.0]))


def equilibrium(*eigenvalues: complex, kind: str = "", length: float = 0.0) -> Any:
    values = np.array(eigenvalues, complex)
    unstable = int((values.real > 0).sum())
    return SimpleNamespace(eigenvalues=values, unstable=unstable, kind=kind, point=SimpleNamespace(length=length))


def test_eigenvalues_on_the_axis_may_be_on_either_side() -> None:
    assert _unstable_counts(np.array([1.0, 1e-9, -1e-9, 0.0, -1.0], complex), 1e-8) == (1, 4)
    assert _unstable_counts(np.array([1.0, 1e-8, -1e-8], complex), 1e-8) == (1, 3)


@pytest.mark.parametrize(
    ("before", "after", "kinds", "agree"),
    [
        ([-1, -2], [-1, -2], [], True), ([-1, -2], [1, -2], [], False), ([-1, -2], [1, -2], ["fold"], True),
        ([1, -2], [-1, -2], ["fold"], True), ([-1, -2], [-1, -2], ["fold"], False),
        ([-1, -2], [-1, -2], ["fold", "fold"], True), ([-1, -2], [1, 2], ["fold", "fold"], True),
        ([-1, -2], [1, 2], ["hopf"], True), ([-1, -2], [1, 2], ["fold"], False), ([-1, -2], [1, -2], ["hopf"], False),
        ([-1, -2], [1, -2], ["branch-point"], True), ([-1, -2], [-1, -2], ["branch-point"], True),
        ([-1, -2], [1e-9, -2], [], True), ([-1, -200], [1e-7, -200], ["fold"], True),
    ],
)  # fmt: skip
def test_whether_special_points_explain_a_change_of_stability(
    before: list[float], after: list[float], kinds: list[str], agree: bool
) -> None:
    """A fold takes one eigenvalue over the imaginary axis, a Hopf point two, a branch point one or none."""
    points = [equilibrium(kind=kind) for kind in kinds]
    here, there = equilibrium(*before), equilibrium(*after)
    assert _crossings_agree(here, there, points) is agree


def test_a_turn_at_a_branch_point_is_no_fold() -> None:
    """Within 1e-5 of its length."""
    fold, near, far = (equilibrium(kind="fold", length=at) for at in (0.0, 1 + 0.9e-5, 1 - 1.1e-5))
    crossing, hopf = equilibrium(kind="branch-point", length=1.0), equilibrium(kind="hopf", length=1.0)
    assert _without_turns([fold, near, crossing, hopf, far]) == [fold, crossing, hopf, far]
    assert _without_turns([fold, near]) == [fold, near]
