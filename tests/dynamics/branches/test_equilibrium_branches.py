"""Stretches of stability of branches of steady states."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.branches.bifurcation_diagram import _searched_values
from wucht.dynamics.branches.equilibrium_branches import (
    EquilibriumBranch,
    StabilityLevel,
)
from wucht.dynamics.branches.state_rows import steady_row


def branch(growth: list[float], kinds: list[str], share: tuple[float, ...] = ()) -> EquilibriumBranch:
    """Points at 0, 1, 2, ... with one exponent each, beside a fast one that decays."""
    n = len(growth)
    exponents = np.array([growth, [-1.0] * n], complex)
    return EquilibriumBranch(np.array([[0.0] * n, np.arange(n)]), exponents, tuple(kinds), ("", ""), stable_share=share)


def test_where_stability_changes_without_a_point_is_told() -> None:
    located = branch([-0.1, 0.0, 0.1], ["", "fold", ""])
    assert located.intervals(StabilityLevel.STABLE) == [(0, 1)] and located.unlocated_changes == []
    missed = branch([-0.1, -0.1, 0.1, 0.1], [""] * 4)
    assert missed.intervals(StabilityLevel.STABLE) == [(0, 1)] and missed.unlocated_changes == [(1, 2)]
    unresolved = branch([-0.1, 0.0, 0.1], ["", "unresolved", ""])
    assert unresolved.intervals(StabilityLevel.STABLE) == [(0, 1)] and unresolved.unlocated_changes == [(0, 2)]
    neutral = branch([0.1, 0.0, 1e-12, -1e-12, -0.1], ["", "branch-point", "", "", ""])
    assert neutral.intervals(StabilityLevel.STABLE) == [(1, 4)] and neutral.unlocated_changes == []
    assert branch([-0.1, 1e-12, -0.1], [""] * 3).intervals(StabilityLevel.STABLE) == [(0, 2)]
    assert branch([0.0, 0.0], [""] * 2).intervals(StabilityLevel.STABLE) == []


def test_a_family_is_stable_where_all_of_its_members_are() -> None:
    """Whatever the exponents of the one that stands for all."""
    kinds = ["", "some-stable", "", "all-stable", ""]
    family = branch([0.1, 0.1, -0.1, 0.1, -0.1], kinds, (0.0, 0.1, 0.5, 1.0, 1.0))
    assert family.intervals(StabilityLevel.STABLE) == [(3, 4)] and family.intervals(StabilityLevel.PARTLY_STABLE) == [(1, 3)]
    assert family.unlocated_changes == []


def test_the_length_of_a_branch_and_the_points_at_a_value() -> None:
    """Pieces (3, 4) and (0, 2) in units of (2, 4): sqrt(1.5^2 + 1) and 0.5."""
    zigzag = EquilibriumBranch(np.array([[0.0, 3.0, 3.0], [0.0, 4.0, 2.0]]), np.zeros((1, 3)), ("",) * 3, ("", ""))
    assert zigzag.length(np.array([2.0, 4.0])) == pytest.approx(3.25**0.5 + 0.5)
    assert [u.tolist() for u in zigzag.crossings(3.0)] == [[2.25, 3.0], [3.0, 3.0]]
    assert list(zigzag.crossings(4.5)) == []


def test_searched_values_are_the_middles_of_parts_and_one_near_each_end() -> None:
    """Evenly; over more than a decade of positive values in a constant ratio."""
    assert _searched_values((0.0, 4.0), 2) == pytest.approx((0.004, 1.0, 3.0, 3.996))
    assert _searched_values((1.0, 100.0), 2) == pytest.approx((1.099, 100**0.25, 100**0.75, 99.901))
    assert _searched_values((1.0, 10.0), 1) == pytest.approx((1.009, 5.5, 9.991))
    assert _searched_values((-1.0, 100.0), 1)[1] == pytest.approx(49.5)


def test_beyond_the_point_where_it_is_lost_a_state_is_not_stable() -> None:
    """A branch that is stable up to a Hopf point at p = 1, beside one that is stable everywhere."""
    unknowns, everywhere = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 2.0]]), np.full((1, 3), -1.0 + 0j)
    lost = EquilibriumBranch(unknowns, np.array([[-1.0, 0.0, 1.0]], complex), ("", "hopf", ""), ("range", "range"))
    row = steady_row(
        3.0, [lost, EquilibriumBranch(unknowns, everywhere, ("", "", ""), ("range", "range"))], np.array([0.5, 1.5])
    )
    assert [(place.x, place.y, place.names) for place in row] == [
        (0.5, 3.0, ("2 stable states",)), (1.5, 3.0, ("one stable state",))
    ]  # fmt: skip


def test_steady_states_at_a_point_of_a_branch_and_beside_it() -> None:
    """Between two points both must be stable; a value at a point lies in both pieces beside it."""
    exponents = np.array([[-1.0, -1.0, 1.0, 1.0, -1.0, -1.0]], complex)
    branch = EquilibriumBranch(np.array([np.zeros(6), np.arange(6.0)]), exponents, ("",) * 6, ("", ""))
    found = steady_row(7.0, [branch], np.array([0.0, 0.5, 1.0, 1.5, 2.5, 3.5, 4.5, 5.0, 5.5]))
    counts = [len(place.names) for place in found]
    assert counts == [1, 1, 1, 0, 0, 0, 1, 1, 0] and {place.y for place in found} == {7.0}
