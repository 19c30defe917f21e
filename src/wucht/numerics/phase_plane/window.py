"""A window of a phase plane that shows all its fixed points, as far as they are found."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wucht.numerics.phase_plane.fixed_points import fixed_points
from wucht.numerics.phase_plane.plane import Plane
from wucht.system import System

_SIZES = (1.0, 10.0, 100.0, 1e3)  # half sides of the boxes that are searched one after the other
_MANY = 20  # fixed points: where a larger box has more, as of periodic functions, the smaller one is shown
_AROUND = 0.6  # of their extent: how much is shown around the fixed points, and at least
_LEAST = 1.5  # times the distance of the farthest one from zero; 1.5 where all are at zero


def window_around(
    system: System, values: Mapping[str, float], low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Ends (2,), (2,) of a window where ``low`` and ``high`` are not numbers; None where no fixed point is found."""
    free = np.isnan(low)
    seen: np.ndarray | None = None
    for size in _SIZES:
        plane = Plane(system, values, np.where(free, -size, low), np.where(free, size, high))
        states = np.array([p.state for p in fixed_points(plane).points]).T
        if states.size and seen is not None and states.shape[1] > _MANY:
            break
        seen = states if states.size else seen
    if seen is None:
        return None
    extent = np.maximum(np.ptp(seen, axis=1), 0.0)
    far = np.abs(seen).max(axis=1)
    margin = np.maximum(_AROUND * extent, np.where(far > 0, 0.5 * far, 0.0))
    margin = np.where(margin > 0, margin, _LEAST * (max(float(margin[free].max()), 0.0) or 1.0))
    return np.where(free, seen.min(axis=1) - margin, low), np.where(free, seen.max(axis=1) + margin, high)
