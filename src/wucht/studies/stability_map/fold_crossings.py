"""Where curves of folds cross in the plane: there two pairs of steady states vanish at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.continuation.equilibria import FOLD
from wucht.numerics.periodic.fold_pairs import FoldPairs
from wucht.studies.speed_curve.second_parameter import FollowedCurve
from wucht.studies.stability_map.prepare import Plan

COINCIDE = "two folds at once"


@dataclass(frozen=True)
class Crossing:
    """A point of the plane at which two curves of folds meet, at different states."""

    x: float
    y: float


@dataclass(frozen=True)
class Crossings:
    """Those that were found, and sentences on those that were not."""

    found: tuple[Crossing, ...]
    lost: tuple[str, ...] = ()


def fold_crossings(plan: Plan, curves: tuple[FollowedCurve, ...]) -> Crossings:
    """Where the curves of folds of states of one name cross."""
    folds, found, lost = [c for c in curves if c.of == FOLD], list[Crossing](), list[str]()
    states = plan.row(sum(plan.bounds[1]) / 2).curves[0][1]
    equations = states.equations_with(plan.second.path, plan.bounds[1][1] - plan.bounds[1][0])
    pairs = FoldPairs(equations, plan.bounds)
    for i, a in enumerate(folds):
        for b in folds[i + 1 :]:
            if a.kind.name != b.kind.name:
                continue
            for k, m in crossing_pieces(a.u[-2:], b.u[-2:]):
                x, y = at = (a.u[-2:, k] + b.u[-2:, m]) / 2
                try:
                    u = pairs.near(a.u[:-2, k], b.u[:-2, m], at)
                except WuchtError as error:
                    place = f"{plan.along.path} = {x:.6g}, {plan.second.path} = {y:.6g}"
                    lost.append(f"where two curves of folds cross near {place} is not located: {error}")
                    continue
                if not any(abs(c.x - u[-2]) + abs(c.y - u[-1]) < 1e-9 for c in found):
                    found.append(Crossing(float(u[-2]), float(u[-1])))
    return Crossings(tuple(found), tuple(lost))


def crossing_pieces(a: np.ndarray, b: np.ndarray) -> list[tuple[int, int]]:
    """Which pieces of two lines (2, N), (2, M) cross."""
    p, r, q, s = a[:, :-1, None], np.diff(a)[:, :, None], b[:, None, :-1], np.diff(b)[:, None, :]
    determinant = r[0] * s[1] - r[1] * s[0]
    with np.errstate(all="ignore"):
        t = ((q[0] - p[0]) * s[1] - (q[1] - p[1]) * s[0]) / determinant
        w = ((q[0] - p[0]) * r[1] - (q[1] - p[1]) * r[0]) / determinant
        meet = (t >= 0) & (t <= 1) & (w >= 0) & (w <= 1)
    return [(int(i), int(k)) for i, k in np.argwhere(meet)]
