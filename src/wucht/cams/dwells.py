"""The arcs on which the output of a cam drive is to rest, and how far a motion is off its place there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wucht.cams.elastic_output import Dwell
from wucht.cams.laws import Law
from wucht.cams.tables.motion_law import MotionLaw
from wucht.numerics.fourier_series import even_angles

_STILL = 1e-9  # of the largest velocity
_SCAN_ANGLES, _MIN_DWELL = 3600, 36  # cam angles at which a law without restrictions is scanned, and the fewest of a dwell
_FINE = 4001  # samples of an arc, both ends among them: between two the deviation changes by less than 1e-6 of itself


def dwells_of(motion_law: MotionLaw) -> tuple[Dwell, ...]:
    """Return the dwells that a law prescribes; without any, the arcs on which it rests."""
    return tuple(Dwell(b.begin, b.end, (b.low + b.high) / 2) for b in motion_law.dwells) or _resting_dwells(motion_law)


def _resting_dwells(motion_law: MotionLaw) -> tuple[Dwell, ...]:
    phi = even_angles(_SCAN_ANGLES)
    speed = np.abs(motion_law.function(phi, 1))
    still = speed <= _STILL * speed.max()
    if still.all() or not still.any():
        return ()
    first = int(np.flatnonzero(~still)[0])  # so that no dwell passes the end of the turn
    edges = np.flatnonzero(np.diff(np.append(np.roll(still, -first), False).astype(int))) + 1
    dwells = []
    for begin, end in edges.reshape(-1, 2).tolist():
        if end - begin >= _MIN_DWELL:
            start, stop = (2 * math.pi * (first + at) / _SCAN_ANGLES for at in (begin, end - 1))
            dwells.append(Dwell(start, stop, float(motion_law.function((start + stop) / 2))))
    return tuple(dwells)


def position_error(motion: Law, dwells: Sequence[Dwell]) -> float:
    """Return how far a motion is off the dwells at most, in its unit.

    Parameters
    ----------
    motion : Law
        Over tau, the time of a turn as an angle, in rad or m.
    dwells : sequence of Dwell
        At least one, over tau.

    Returns
    -------
    float
        The largest distance from the value of a dwell, at the ends of the arcs too.
    """
    return max(float(np.abs(motion(np.linspace(d.begin, d.last, _FINE)) - d.value).max()) for d in dwells)
