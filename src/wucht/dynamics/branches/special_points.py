"""Special points of branches of steady states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wucht.dynamics.branches.bifurcation_diagram import BranchCase
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch

_ONE_POINT = 1e-6  # in units of scale: a special point that lies on two branches


def special_points(case: BranchCase, branches: Sequence[EquilibriumBranch]) -> list[tuple[int, int]]:
    """Return the numbers of the branch and the point of all special points; one on two branches counts once."""
    points = list[tuple[int, int]]()
    for k, branch in enumerate(branches):
        steady_states = case.states_by_second_value[branch.second]
        width = steady_states.equilibria.equations.scale[-1]
        for i in np.flatnonzero([bool(kind) for kind in branch.kinds]).tolist():
            unknowns, here = branch.unknowns[:, i], (branch.kinds[i], branch.second)
            alike = [branches[j].unknowns[:, m] for j, m in points if (branches[j].kinds[m], branches[j].second) == here]
            beside = [u for u in alike if abs(u[-1] - unknowns[-1]) < _ONE_POINT * width]
            if not any(steady_states.is_same(unknowns, np.append(u[:-1], unknowns[-1])) for u in beside):
                points.append((k, i))
    return points
