"""Rows of steady states over a parameter."""

from __future__ import annotations

import numpy as np

from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.state_rows import steady_row


def test_beyond_the_point_where_it_is_lost_a_state_is_not_stable() -> None:
    """A branch that is stable up to a Hopf point at p = 1, beside one that is stable everywhere."""
    u, everywhere = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 2.0]]), np.full((1, 3), -1.0 + 0j)
    lost = EquilibriumBranch(u, np.array([[-1.0, 0.0, 1.0]], complex), ("", "hopf", ""), ("range", "range"))
    row = steady_row(3.0, [lost, EquilibriumBranch(u, everywhere, ("", "", ""), ("range", "range"))], np.array([0.5, 1.5]))
    assert row.stable == (("2 stable states",), ("one stable state",))
