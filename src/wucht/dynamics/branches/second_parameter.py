"""Curves of folds and Hopf points in the plane of two parameters, and their crossings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.branches.equilibrium_branches import BOUND_TOLERANCE, RANGE_ENDS, EquilibriumBranch, describe_end
from wucht.dynamics.branches.plane_regions import COINCIDE, PlanePoint
from wucht.dynamics.branches.steady_states import Kind, SteadyStates
from wucht.errors import WuchtError
from wucht.numerics.continuation.equilibria import FOLD, HOPF
from wucht.numerics.continuation.fold_curves import FoldPairs, Folds
from wucht.numerics.continuation.hopf_curves import HopfPoints
from wucht.numerics.zeros_and_peaks import values_at_passages

_SAME = 1e-5  # in units of scale: a special point that lies on a curve


@dataclass(frozen=True)
class BifurcationCurve:
    """Curve of special points in two parameters.

    bifurcation: "fold" or "hopf". unknowns (n+2, N): states and both parameters. kinds (N): "" or the kind of a
    point where a second condition holds. coefficients (N): of the normal form at these, empty at others. ends: why it ends, at
    its first and its last point.
    """

    bifurcation: str
    kind: Kind
    unknowns: np.ndarray
    kinds: tuple[str, ...]
    coefficients: tuple[Mapping[str, float], ...]
    ends: tuple[str, str]


@dataclass(frozen=True)
class SecondParameter:
    """Second parameter. path, bounds: of it. value: its nominal value, at which branches are followed."""

    path: str
    bounds: tuple[float, float]
    value: float


def curve_starts(branches: Sequence[EquilibriumBranch]) -> list[tuple[str, Kind, np.ndarray]]:
    """Return the folds and Hopf points of branches of isolated states: bifurcation, kind of the states, unknowns (n+1,)."""
    return [
        (special, b.kind, b.unknowns[:, i])
        for b in branches
        if not b.dimension
        for i, special in enumerate(b.kinds)
        if special in (FOLD, HOPF)
    ]


def curve_through(
    steady_states: SteadyStates, second: SecondParameter, bifurcation: str, kind: Kind, unknowns: np.ndarray
) -> BifurcationCurve:
    """Follow the curve through a fold or Hopf point both ways. Raises ``RunError`` where it cannot be followed."""
    equations = steady_states.equations_with(second.path, second.bounds[1] - second.bounds[0])
    problem = steady_states.equilibria
    bounds = (steady_states.bounds, second.bounds)
    more: Folds | HopfPoints = (Folds if bifurcation == FOLD else HopfPoints)(
        equations, bounds, problem.steps, dict(problem.limits)
    )
    curve = more.follow_curve(more.start(unknowns[:-1], (float(unknowns[-1]), second.value)))
    points = curve.points
    ends = curve.ends if curve.is_closed else tuple(
        _describe_curve_end(steady_states, second, end, at)
        for end, at in zip(curve.ends, curve.unknowns.T[[0, -1]], strict=True)
    )  # fmt: skip
    return BifurcationCurve(
        bifurcation, kind, curve.unknowns, tuple(p.kind for p in points),
        tuple(dict(p.coefficients) if p.kind else {} for p in points), (ends[0], ends[1]),
    )  # fmt: skip


def _describe_curve_end(steady_states: SteadyStates, second: SecondParameter, reason: str, at: np.ndarray) -> str:
    """Return why a curve ends at a point (n+2,)."""
    low, high = second.bounds
    if min(abs(at[-1] - low), abs(at[-1] - high)) <= BOUND_TOLERANCE * (high - low):
        return RANGE_ENDS
    place = f"{steady_states.path} = {at[-2]:.5g}, {second.path} = {at[-1]:.5g}"
    return describe_end(steady_states.equilibria, place, steady_states.end_reason, at[:-1], reason)


def lies_on_curve(
    steady_states: SteadyStates, second: SecondParameter, curve: BifurcationCurve, bifurcation: str, unknowns: np.ndarray
) -> bool:
    """True if a special point at the second parameter's nominal value lies on a curve."""
    if curve.bifurcation != bifurcation:
        return False
    scale = np.append(steady_states.equilibria.equations.scale, second.bounds[1] - second.bounds[0])
    near = (np.abs(np.diff(curve.unknowns / scale[:, None], axis=1)) ** 2).sum(axis=0) ** 0.5
    passages, points = values_at_passages(curve.unknowns[-1], second.value, curve.unknowns)
    for i, at in zip(passages.tolist(), points.T, strict=True):
        away = (at[-2] - unknowns[-1]) / scale[-2]
        here, there = (steady_states.ordinate(x[:, None])[0] for x in (np.append(at[:-2], unknowns[-1]), unknowns))
        if max(abs(away), abs(float(here - there)) / steady_states.ordinate_size) < max(_SAME, 0.1 * near[i]):
            return True
    return False


def fold_crossings(
    steady_states: SteadyStates, second: SecondParameter, curves: Sequence[BifurcationCurve]
) -> tuple[PlanePoint | str, ...]:
    """Return the crossings of fold curves of states of one name: there two pairs of steady states vanish at once.

    In the place of one that is not located stands a sentence.
    """
    folds, points, omissions = [c for c in curves if c.bifurcation == FOLD], list[PlanePoint](), list[str]()
    equations = steady_states.equations_with(second.path, second.bounds[1] - second.bounds[0])
    pairs = FoldPairs(equations, (steady_states.bounds, second.bounds))
    for i, a in enumerate(folds):
        for b in folds[i + 1 :]:
            if a.kind.name != b.kind.name:
                continue
            for k, m in crossing_pieces(a.unknowns[-2:], b.unknowns[-2:]):
                x, y = at = (a.unknowns[-2:, k] + b.unknowns[-2:, m]) / 2
                try:
                    unknowns = pairs.nearest_pair(a.unknowns[:-2, k], b.unknowns[:-2, m], at)
                except WuchtError as error:
                    place = f"{steady_states.path} = {x:.6g}, {second.path} = {y:.6g}"
                    omissions.append(f"the crossing of two curves of folds near {place} is not located: {error}")
                    continue
                if not any(abs(c.x - unknowns[-2]) + abs(c.y - unknowns[-1]) < 1e-9 for c in points):
                    points.append(PlanePoint(COINCIDE, float(unknowns[-2]), float(unknowns[-1])))
    return (*points, *omissions)


def crossing_pieces(a: np.ndarray, b: np.ndarray) -> list[tuple[int, int]]:
    """Return the pieces of two lines (2, N), (2, M) that cross."""
    p, r, q, s = a[:, :-1, None], np.diff(a)[:, :, None], b[:, None, :-1], np.diff(b)[:, None, :]
    determinant = r[0] * s[1] - r[1] * s[0]
    with np.errstate(all="ignore"):
        t = ((q[0] - p[0]) * s[1] - (q[1] - p[1]) * s[0]) / determinant
        w = ((q[0] - p[0]) * r[1] - (q[1] - p[1]) * r[0]) / determinant
        meet = (t >= 0) & (t <= 1) & (w >= 0) & (w <= 1)
    return [(int(i), int(k)) for i, k in np.argwhere(meet)]
