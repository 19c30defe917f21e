"""Where folds and Hopf points go as a second parameter changes: their curves in the plane of both parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.equilibria import FOLD, HOPF
from wucht.numerics.continuation.fold_curves import Folds
from wucht.numerics.continuation.hopf_curves import HopfPoints
from wucht.studies.speed_curve.following import ON, RANGE_ENDS, FollowedBranch, end_in_words
from wucht.studies.speed_curve.steady_states import Kind, SteadyStates

_SAME = 1e-5  # in units of scale: a special point that lies on a curve


@dataclass(frozen=True)
class FollowedCurve:
    """A curve of special points in two parameters.

    of: "fold" or "hopf". u (n+2, N): states and both parameters. kinds (N): "" or the kind of a point where a second condition
    holds. coefficients (N): of the normal form at these, empty at others. ends: why it ends, at first and last.
    """

    of: str
    kind: Kind
    u: np.ndarray
    kinds: tuple[str, ...]
    coefficients: tuple[Mapping[str, float], ...]
    ends: tuple[str, str]


@dataclass(frozen=True)
class SecondParameter:
    """path, bounds: of the second parameter. value: of the subject as it is, at which branches are followed."""

    path: str
    bounds: tuple[float, float]
    value: float


def starts(branches: Sequence[FollowedBranch]) -> list[tuple[str, Kind, np.ndarray]]:
    """The folds and Hopf points of branches of isolated states: kind, what the states are called, u (n+1,)."""
    return [
        (special, b.kind, b.u[:, i])
        for b in branches
        if not b.dimension
        for i, special in enumerate(b.kinds)
        if special in (FOLD, HOPF)
    ]


def curve_through(states: SteadyStates, second: SecondParameter, of: str, kind: Kind, u: np.ndarray) -> FollowedCurve | str:
    """The curve through a fold or Hopf point, followed both ways; or why it cannot be followed."""
    equations = states.equations_with(second.path, second.bounds[1] - second.bounds[0])
    problem = states.equilibria
    bounds = (states.bounds, second.bounds)
    more: Folds | HopfPoints = (Folds if of == FOLD else HopfPoints)(equations, bounds, problem.steps, dict(problem.limits))
    try:
        curve = more.branch(more.start(u[:-1], (float(u[-1]), second.value)))
    except RunError as error:
        return str(error)
    points = curve.points
    ends = curve.ends if curve.closed else tuple(
        _in_words(states, second, end, at) for end, at in zip(curve.ends, curve.u.T[[0, -1]], strict=True)
    )  # fmt: skip
    return FollowedCurve(
        of, kind, curve.u, tuple(p.kind for p in points),
        tuple(dict(p.coefficients) if p.kind else {} for p in points), (ends[0], ends[1]),
    )  # fmt: skip


def _in_words(states: SteadyStates, second: SecondParameter, said: str, at: np.ndarray) -> str:
    """Why a curve ends at a point (n+2,)."""
    low, high = second.bounds
    if min(abs(at[-1] - low), abs(at[-1] - high)) <= ON * (high - low):
        return RANGE_ENDS
    where = f"{states.path} = {at[-2]:.5g}, {second.path} = {at[-1]:.5g}"
    return end_in_words(states.equilibria, where, states.end, at[:-1], said)


def passes(states: SteadyStates, second: SecondParameter, curve: FollowedCurve, of: str, u: np.ndarray) -> bool:
    """Whether a special point at the second parameter's own value lies on a curve."""
    if curve.of != of:
        return False
    q, scale = curve.u[-1], np.append(states.equilibria.equations.scale, second.bounds[1] - second.bounds[0])
    near = (np.abs(np.diff(curve.u / scale[:, None], axis=1)) ** 2).sum(axis=0) ** 0.5
    for i in np.flatnonzero((q[:-1] - second.value) * (q[1:] - second.value) <= 0).tolist():
        width = q[i + 1] - q[i]
        share = (second.value - q[i]) / width if width else 0.0
        at = curve.u[:, i] + share * (curve.u[:, i + 1] - curve.u[:, i])
        away = (at[-2] - u[-1]) / scale[-2]
        moved = states.shown(np.append(at[:-2], u[-1])[:, None]).speed - states.shown(u[:, None]).speed
        if max(abs(away), abs(float(moved[0])) / states.size_of_shown) < max(_SAME, 0.1 * near[i]):
            return True
    return False
