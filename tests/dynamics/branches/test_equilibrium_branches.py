"""Stretches of stability of branches of steady states, and what is stable at a value."""

from __future__ import annotations

import numpy as np

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


def test_steady_states_at_a_point_of_a_branch_and_beside_it() -> None:
    """Between two points both must be stable; a value at a point lies in both pieces beside it."""
    exponents = np.array([[-1.0, -1.0, 1.0, 1.0, -1.0, -1.0]], complex)
    branch = EquilibriumBranch(np.array([np.zeros(6), np.arange(6.0)]), exponents, ("",) * 6, ("", ""))
    found = steady_row(7.0, [branch], np.array([0.0, 0.5, 1.0, 1.5, 2.5, 3.5, 4.5, 5.0, 5.5]))
    counts = [len(place.names) for place in found]
    assert counts == [1, 1, 1, 0, 0, 0, 1, 1, 0] and {place.y for place in found} == {7.0}
