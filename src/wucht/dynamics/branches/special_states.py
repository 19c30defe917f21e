"""Special points of branches of steady states, with the frequency of the oscillation that begins there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.branches.bifurcation_diagram import BranchCase
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch

_ONE_POINT = 1e-6  # in units of scale: a special point that lies on two branches


@dataclass(frozen=True)
class SpecialState:
    """Special point of a numbered branch: unknowns (n+1,). frequency: of a Hopf point. second: the second parameter's value."""

    kind: str
    unknowns: np.ndarray
    speed: float
    amplitude: float
    branch: int
    frequency: float | None
    second: float | None


def special_states(case: BranchCase, branches: Sequence[EquilibriumBranch]) -> list[SpecialState]:
    """Collect all special points; one on two branches counts once."""
    special_points: list[SpecialState] = []
    for k, branch in enumerate(branches):
        steady_states = case.states_by_second_value[branch.second]
        width = steady_states.equilibria.equations.scale[-1]
        speeds, amplitudes = steady_states.ordinate(branch.unknowns), steady_states.amplitude(branch.unknowns)
        for i in np.flatnonzero([bool(kind) for kind in branch.kinds]).tolist():
            unknowns, kind = branch.unknowns[:, i], branch.kinds[i]
            neighbours = [
                s
                for s in special_points
                if (s.kind, s.second) == (kind, branch.second) and abs(s.unknowns[-1] - unknowns[-1]) < _ONE_POINT * width
            ]
            if not any(steady_states.is_same(unknowns, np.append(s.unknowns[:-1], unknowns[-1])) for s in neighbours):
                point = SpecialState(
                    kind, unknowns, float(speeds[i]), float(amplitudes[i]), k, branch.frequency(i), branch.second
                )
                special_points.append(point)
    return special_points
