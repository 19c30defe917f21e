"""The equilibria of equations in given ranges, and what their motions tend to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.dynamics.limit_sets.long_run import LongRun
from wucht.numerics.angles import TURN
from wucht.numerics.continuation.deflation import deflated_solutions, random_starts
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.system import System

SEARCHES = 200  # starts of Newton's method
_OUTSIDE = 0.05  # of a range: an equilibrium farther outside is left out
_NEUTRAL = 1e-9  # of the largest eigenvalue


def equilibria_in_ranges(
    system: System, values: Mapping[str, float], low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Return the equilibria (n, e) in the ranges to which Newton's method leads, with their eigenvalues."""
    n = len(low)
    if system.depends_on_time:
        return np.empty((n, 0)), ()
    scale = dict(zip(system.state_names, (high - low).tolist(), strict=True))
    equations = EquilibriumEquations.from_system(system, (), values, scale)
    points = deflated_solutions(equations, (), random_starts(low, high, SEARCHES))
    room = _OUTSIDE * (high - low)
    turning = np.array(system.is_angle)
    points = np.where(turning[:, None], np.remainder(points, TURN), points)
    inside = ((points >= (low - room)[:, None]) & (points <= (high + room)[:, None])) | turning[:, None]
    points = points[:, inside.all(axis=0)]
    return points, tuple(np.linalg.eigvals(equations.values(x)[1][:, :n]) for x in points.T)


def equilibrium_kind(eigenvalues: np.ndarray) -> str:
    """Return the kind of an equilibrium by its eigenvalues."""
    limit = _NEUTRAL * float(np.abs(eigenvalues).max(initial=0.0))
    growing, decaying = (eigenvalues.real > limit).sum(), (eigenvalues.real < -limit).sum()
    if growing + decaying < len(eigenvalues):
        return "degenerate"
    return "stable" if not growing else "unstable" if not decaying else "saddle"


def distinct_limit_sets(runs: Iterable[LongRun]) -> list[LimitSet]:
    """Return what motions tend to, each once."""
    distinct = list[LimitSet]()
    for run in runs:
        one = run.limit_set
        if one is not None and not any(k.is_same(one) for k in distinct):
            distinct.append(one)
    return distinct
