"""The engines of branches, called with a machine and plain numbers: the numbers of tests/test_catalogue_runs.py."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, follow_branches
from wucht.dynamics.branches.state_map import StateMapCase, map_states
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.files.user_system import UserSystem
from wucht.numerics.continuation.equilibria import BRANCH_POINT, FOLD
from wucht.system import System


def test_folds_of_the_speed_of_a_rotor_on_a_carrier() -> None:
    case = BranchCase.of(load_machine("drozdetskaya-2020/table-3.1-carrier"), "u", (0.0, 5.0))
    *_, findings = follow_branches(case, Work())
    (branch,) = findings.branches
    folds = [branch.parameter_values[i] for i, kind in enumerate(branch.kinds) if kind == FOLD]
    assert sorted(folds) == pytest.approx([0.8937191, 2.6053860], rel=1e-6)
    assert findings.complete
    assert any(float(case.steady_states.ordinate(s.unknowns[:, None])[0]) == pytest.approx(0.9686444) for s in findings.nominal)


def test_a_branch_that_crosses_only_one_that_was_not_searched_either() -> None:
    """x' = x (r - x^2), y' = y (x - 0.3 - y^2), r = 0.25 - (p - 3)^2: at the searched 0, 2 and 4 there is the origin alone.

    From it a circle x^2 = r branches off, on which y = 0, at p = 2.5 and 3.5; from that y^2 = x - 0.3, at (p - 3)^2 = 0.16.
    """
    x, y, p = sp.symbols("x y p", real=True)
    system = System((x, y), (x * (0.25 - (p - 3) ** 2 - x**2), y * (x - 0.3 - y**2)), (p,))
    ranges = {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}
    case = BranchCase.of(UserSystem(system, {"p": 1.0}), "p", (0.0, 4.0), points=1, ranges=ranges)
    *_, findings = follow_branches(case, Work())
    assert [len(s.points) for s in findings.searches] == [1, 1, 1] and not findings.omissions
    largest = [np.abs(b.unknowns[:2]).max(axis=1) for b in findings.branches]
    assert np.array(largest) == pytest.approx(np.array([(0.0, 0.0), (0.5, 0.0), (0.5, 0.2**0.5)]), abs=1e-3)
    crossings = [
        sorted(v for v, kind in zip(b.parameter_values, b.kinds, strict=True) if kind == BRANCH_POINT)
        for b in findings.branches
    ]
    assert crossings[0] == pytest.approx([2.5, 3.5]) and {2.6, 3.4} <= {round(v, 6) for v in crossings[1]}


def test_curves_of_folds_that_cross() -> None:
    """x' = -((x + 2)^2 - p - r) ((x - 2)^2 - p + r): folds at p = -r, x = -2, and at p = r, x = 2; both at once at (0, 0)."""
    x, p, r = sp.symbols("x p r", real=True)
    pairs = UserSystem(System((x,), (-((x + 2) ** 2 - p - r) * ((x - 2) ** 2 - p + r),), (p, r)), {"p": 0.5, "r": 0.1})
    plane = (-0.6, 1.0), (-0.5, 0.7)
    case = StateMapCase.of(pairs, ("p", "r"), plane, 2, points=2, ranges={"x": (-4.0, 4.0)}, orbits=False)
    *_, findings = map_states(case, Work())
    (crossing,) = findings.crossings
    assert (crossing.x, crossing.y) == pytest.approx((0.0, 0.0), abs=1e-8)
    for curve in findings.curves:
        state, first, second = curve.unknowns
        assert first == pytest.approx(np.where(state > 0, second, -second), abs=1e-8)
        assert curve.bifurcation == FOLD and np.abs(state) == pytest.approx(np.full(len(state), 2.0), abs=1e-6)
    assert len(findings.curves) == 2 and not findings.omissions
