"""A rotor that nothing drives: in what time it comes to rest, if it does."""

from __future__ import annotations

import math

import numpy as np

from wucht.dynamics.verdicts.outcomes import AT_REST
from wucht.numerics.observers.projection import SHARE, windows_of
from wucht.numerics.observers.records import Blocks

COASTS = "the rotor coasts ever more slowly, and does not come to rest"
_SEEN_TO_FALL = 0.998  # of the speed, from the first to the last window: how it falls is seen then
_WITHOUT_END = 1.3  # the power of the speed in proportion to which it falls: from here on it takes for ever


def windows_to_rest(whole: Blocks, means: np.ndarray) -> float:
    """In how many tenths of the record's time a speed that falls comes to rest, of its means (w,) over tenths of the turns.

    It falls in proportion to a power of itself: 0 by dry friction, 1 by a viscous damper; beyond that it has no end: inf.
    """
    if (np.diff(means) >= 0).any() or means[-1] <= 0:
        return math.inf
    changes, power = -np.diff(means), 1.0
    if means[-1] < _SEEN_TO_FALL * means[0]:
        between = (means[1:] + means[:-1]) / 2
        # Over the angle, in which the windows are equal, the power is less by one.
        power = max(0.0, 1 + math.log(changes[0] / changes[-1]) / math.log(between[0] / between[-1]))
    if power > _WITHOUT_END:
        return math.inf
    last = float(np.ptp(windows_of(whole.time)[-1]) / np.ptp(whole.time)) / SHARE  # how long the last window is, in tenths
    exponential = math.log(1 / AT_REST)
    return last * float(means[-1] / changes[-1]) * (min(exponential, 1 / (1 - power)) if power < 1 else exponential)
