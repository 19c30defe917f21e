"""Boxes in which rates may jump, against where they do."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.phase_plane.fixed_points import fixed_points
from wucht.numerics.phase_plane.plane import Plane
from wucht.numerics.phase_plane.rate_jumps import may_jump
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


def test_bounds_that_exclude_nothing_are_given_up_early(monkeypatch: pytest.MonkeyPatch) -> None:
    from wucht.numerics.phase_plane import fixed_points as module

    def wide(program: object, constants: object, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        far = np.full((2 + len(plane.lowered.places), low.shape[1]), 1e6)
        return -far, far

    plane = Plane(System((X, Y), (X - X**3, -Y)), {}, np.array([-2.0, -1.0]), np.array([2.1, 1.1]))
    monkeypatch.setattr(module, "bounds", wide)
    calls: list[None] = []
    found = module.fixed_points(plane, lambda: calls.append(None))
    assert [p.state[0] for p in found.points] == pytest.approx([-1.0, 0.0, 1.0], abs=1e-9)
    assert not found.complete and "bounds on the Jacobian are wide" in found.shown
    assert int(found.shown.split(" of ")[1].split()[0]) < 40_000
    assert len(calls) > 60  # Newton's method can be stopped too
