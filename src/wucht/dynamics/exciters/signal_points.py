"""The signal of a failure at other values: the largest one, compared with its neighbours, and its cliff."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.sampling.choice import Cliff, Scores, Sides, nearest_cliff, sides_on_grid

NEAR = 0.05  # relative to a value: a cliff within it is near, as tolerances of a motor are of that size


@dataclass(frozen=True)
class SignalPoint:
    """Result at other values. before, after: speeds, signal: None where the specimen did not fail, or too late."""

    values: tuple[float, ...]
    before: float | None
    after: float | None
    signal: float | None
    outcome: str


def _scores(points: Sequence[SignalPoint]) -> Scores:
    """Return the scores of points: the reciprocal of the signal, without chance."""
    costs = np.array([[1 / p.signal if p.signal else np.inf] for p in points]).reshape(-1, 1)
    return Scores(costs, np.zeros(costs.shape, bool))


def best_index(points: Sequence[SignalPoint]) -> int | None:
    """Return the index of the point with the largest signal; None without any."""
    if not any(p.signal for p in points):
        return None
    return int(_scores(points).order[0])


def neighbours_of(points: Sequence[SignalPoint], k: int) -> Sides:
    """Return the sides of a point."""
    return sides_on_grid(np.array([p.values for p in points]), k)


def cliff_at(points: Sequence[SignalPoint], k: int, paths: Sequence[str]) -> Cliff | None:
    """Return the nearest value beside a point at which its signal is lost: less than half of it. paths: of the axes."""
    return nearest_cliff(_scores(points), k, paths, [p.values for p in points], neighbours_of(points, k))


def safe_index(points: Sequence[SignalPoint], paths: Sequence[str]) -> int | None:
    """Return the index of the point with the largest signal of those from which a cliff is not near; None without any."""
    for k in _scores(points).order.tolist():
        cliff = cliff_at(points, k, paths) if points[k].signal else None
        if points[k].signal and (cliff is None or abs(cliff.distance) >= NEAR):
            return int(k)
    return None


def values_beside_best(points: Sequence[SignalPoint]) -> list[tuple[float, ...]]:
    """Return the values halfway between the one of the largest signal and its neighbours. points: in the order of their one
    value."""
    best = best_index(points)
    if best is None:
        return []
    neighbours = [points[i].values for i in (best - 1, best + 1) if 0 <= i < len(points)]
    return [((points[best].values[0] + one[0]) / 2,) for one in neighbours]
