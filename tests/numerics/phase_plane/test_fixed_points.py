"""Fixed points: all of them, proved; and bounds that hold."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.phase_plane.fixed_points import fixed_points, kind_of, may_jump, window_around
from wucht.numerics.phase_plane.plane import TURN, Plane
from wucht.piecewise import Pieces, PiecewiseCubic, step
from wucht.system import System

X, Y, A, D = sp.symbols("x y a d", real=True)
SIGN = step("sign", 0.0, -1.0, 1.0)
ABSOLUTE = Pieces("abs", (0.0,), ((0, -1, 0, 0), (0, 1, 0, 0)))


def test_only_the_rates_that_depend_on_the_jump_and_only_beside_it() -> None:
    """sign(x + y - a), through a definition, in the first rate; |x| in the second jumps nowhere."""
    system = System((X, Y), (D - X, PiecewiseCubic(X, ABSOLUTE)), (A,), ((D, PiecewiseCubic(X + Y - A, SIGN)),))
    centre = np.array([[0.0, 1.0, 0.4, 3.0], [0.0, 0.0, 0.5, 0.0]])
    found = may_jump(system, (1.0,), centre - 0.1, centre + 0.1)
    assert found.tolist() == [[False, True, True, False], [False] * 4]


def test_boxes_without_a_jump_are_proved() -> None:
    """x' = sign(x) - x has two zeros beside the jump: on each side alone there is one, and that is shown."""
    system = System((X, Y), (PiecewiseCubic(X, SIGN) - X, -Y))
    whole = fixed_points(Plane(system, {}, np.array([-2.0, -1.0]), np.array([2.0, 1.1])))
    assert [p.state[0] for p in whole.points] == pytest.approx([-1.0, 1.0])
    assert not whole.complete
    side = fixed_points(Plane(system, {}, np.array([0.1, -1.0]), np.array([2.0, 1.1])))
    assert side.complete and [p.state[0] for p in side.points] == pytest.approx([1.0])


def test_a_lattice_is_found_whole() -> None:
    """sin x = sin y = 0 in (-7, 7)^2: 25 points, by Poincare and Hopf half of those on a torus saddles."""
    system = System((X, Y), (sp.sin(X), sp.sin(Y)))
    found = fixed_points(Plane(system, {}, np.array([-7.0, -7.0]), np.array([7.0, 7.0])))
    assert found.complete and len(found.points) == 25
    assert np.array([p.state for p in found.points]) / math.pi == pytest.approx(
        np.array([(i, j) for i in range(-2, 3) for j in range(-2, 3)]), abs=1e-14
    )
    torus = System((X, Y), system.derivatives, angles=frozenset({X, Y}))
    kinds = sorted(p.kind for p in fixed_points(Plane(torus, {}, np.zeros(2), np.full(2, TURN))).points)
    assert kinds == ["saddle", "saddle", "stable node", "unstable node"]


def test_what_is_not_proved_is_said() -> None:
    low, high = np.array([-2.0, -2.0]), np.array([2.0, 2.0])
    fold = fixed_points(Plane(System((X, Y), (X**2, -Y)), {}, low, high))
    assert not fold.complete and "were not decided, as at a bifurcation" in fold.evidence
    assert [p.kind for p in fold.points] == ["degenerate"]
    unbounded = fixed_points(
        Plane(
            System((X, Y), (sp.atan2(Y, X + 5), X - 1)),
            {},
            low,
            high,
        )
    )
    assert not unbounded.complete and "no bounds are known for" in unbounded.evidence
    assert unbounded.points[0].state == pytest.approx([1.0, 0.0], abs=1e-12)


def test_a_window_is_chosen_around_all_fixed_points() -> None:
    nan = np.full(2, np.nan)
    system = System(
        (X, Y),
        (A * X - X**3, -Y),
        (A,),
    )
    for a in (1.0, 400.0):
        window = window_around(system, {"a": a}, nan, nan)
        assert window is not None
        assert window[0][0] < -math.sqrt(a) and window[1][0] > math.sqrt(a) and (window[0] < window[1]).all()
    assert window_around(System((X, Y), (X**2 + 1, -Y)), {}, nan, nan) is None


def test_a_side_that_is_given_does_not_widen_the_other() -> None:
    """All fixed points are at y = 0, so that nothing says how high the window is: it is that of a point alone."""
    system = System((X, Y), (100 * X - X**3, -Y))
    window = window_around(system, {}, np.array([-20.0, math.nan]), np.array([20.0, math.nan]))
    alone = window_around(
        System((X, Y), (-X, -Y)),
        {},
        np.full(2, math.nan),
        np.full(2, math.nan),
    )
    assert window is not None and alone is not None
    assert (window[0].tolist(), window[1].tolist()) == ([-20.0, alone[0][1]], [20.0, alone[1][1]])


@pytest.mark.parametrize(
    ("eigenvalues", "kind"),
    [
        ([1.0, -2.0], "saddle"), ([-1.0, -2.0], "stable node"), ([1.0, 2.0], "unstable node"), ([2j, -2j], "centre"),
        ([-1 + 2j, -1 - 2j], "stable focus"), ([1 + 2j, 1 - 2j], "unstable focus"), ([0.0, -1.0], "degenerate"),
        ([1.0, 0.0], "degenerate"),
        ([0.0, 0.0], "degenerate"), ([1e-10 + 1j, 1e-10 - 1j], "centre"), ([1e-8 + 1j, 1e-8 - 1j], "unstable focus"),
        ([-1.0, 0.9e-9], "degenerate"), ([-1.0, 1.1e-9], "saddle"),
    ],
)  # fmt: skip
def test_kinds_of_fixed_points(eigenvalues: list[complex], kind: str) -> None:
    assert kind_of(np.array(eigenvalues, complex)) == kind


def test_a_larger_box_with_very_many_fixed_points_is_not_shown() -> None:
    """sin x vanishes 7 times within 10, and 63 times within 100: 0.6 of the extent of the 7 is left on either side."""
    window = window_around(System((X, Y), (sp.sin(X), -Y)), {}, np.full(2, math.nan), np.full(2, math.nan))
    assert window is not None
    assert (window[0][0], window[1][0]) == pytest.approx((-6.6 * math.pi, 6.6 * math.pi), rel=1e-9)
