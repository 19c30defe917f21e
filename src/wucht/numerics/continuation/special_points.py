"""Where a function of the points of a curve passes zero, and what the defining equations of a branch point are."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.problem import CurvePoint
from wucht.numerics.zeros import crossings

P = TypeVar("P")

_NODES = 6
_JUMP = 0.1  # of the smaller value at the neighbours: a function that is larger at its change of sign jumps
_AROUND = (0.02, 0.05, 0.1, 0.2)  # of the way: nearer to a branch point rounding spoils what Newton's method finds
_ENDS = np.array([0.0, 1.0])


def located(
    curve: Curve, a: CurvePoint, b: CurvePoint, seen: Callable[[CurvePoint], P], test: Callable[[P], float]
) -> P | None:
    """The point between two neighbours where a test function, of what is seen of a point, passes zero.

    None where it jumps instead (a pole), or where the curve cannot be computed there. So near to a branch point that Newton's
    method fails, test function and curve are interpolated between the points found.
    """
    points: dict[float, tuple[CurvePoint, P]] = {}

    def values(shares: np.ndarray) -> np.ndarray:
        for share in shares.tolist():
            point = curve.between(a, b, share)
            points[share] = point, seen(point)
        return np.array([test(points[share][1]) for share in shares.tolist()])

    try:
        shares = crossings(values, _ENDS)
        found = points[shares[0]][1] if len(shares) else None
    except RunError:
        near = _root(points, test)
        for share in _AROUND:
            with suppress(RunError):
                values(np.clip(near + np.array([-share, share]), 0.0, 1.0))
        sound = {share: point for share, point in points.items() if abs(share - near) >= _AROUND[0]}
        found = _interpolated(curve, sound, seen, test)
    if found is None or abs(test(found)) > _JUMP * min(abs(test(points[end][1])) for end in _ENDS.tolist()):
        return None
    return found


def _interpolated(
    curve: Curve, points: dict[float, tuple[CurvePoint, P]], seen: Callable[[CurvePoint], P], test: Callable[[P], float]
) -> P | None:
    """The point where the polynomial through the test function's values passes zero, by that through the points."""
    root, shares = _root(points, test), _nearest(points, test)
    if len(shares) < _NODES or not min(points) <= root <= max(points):
        return None
    parts = [math.prod((root - r) / (s - r) for r in shares if r != s) for s in shares]
    u, tangent, length = (
        sum(part * getattr(points[s][0], name) for part, s in zip(parts, shares, strict=True))
        for name in ("u", "tangent", "length")
    )
    return seen(CurvePoint(u, tangent / curve.size(tangent), curve.problem.residual(u)[1], length, 0))


def _nearest(points: dict[float, tuple[CurvePoint, P]], test: Callable[[P], float]) -> list[float]:
    return sorted(points, key=lambda share: abs(test(points[share][1])))[:_NODES]


def _root(points: dict[float, tuple[CurvePoint, P]], test: Callable[[P], float]) -> float:
    """Where the share, as a polynomial of the test function's values, has the value for zero: Lagrange's formula."""
    values = {share: test(points[share][1]) for share in _nearest(points, test)}
    return sum(s * math.prod(values[r] / (values[r] - values[s]) for r in values if r != s) for s in values)
