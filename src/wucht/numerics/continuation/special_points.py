"""Where a function of the points of a curve passes zero, and what the defining equations of a branch point are."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.problem import CurvePoint
from wucht.numerics.zeros import crossings

P = TypeVar("P")

_ENDS = np.array([0.0, 1.0])


def located(
    curve: Curve, a: CurvePoint, b: CurvePoint, seen: Callable[[CurvePoint], P], test: Callable[[P], float]
) -> P | None:
    """The point between two neighbours where a test function, of what is seen of a point, passes zero.

    None where it jumps instead (a pole), or where the curve cannot be computed there.
    """
    points: dict[float, P] = {}

    def values(shares: np.ndarray) -> np.ndarray:
        for share in shares.tolist():
            points[share] = seen(curve.between(a, b, share))
        return np.array([test(points[share]) for share in shares.tolist()])

    try:
        shares = crossings(values, _ENDS)
    except RunError:
        return None
    if not len(shares):
        return None
    found = points[shares[0]]
    jumps = abs(test(found)) > min(abs(test(points[end])) for end in _ENDS.tolist())
    return None if jumps else found
