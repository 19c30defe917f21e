"""Whether bodies that are modulated together part: the difference of their phases grows from cycle to cycle."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from wucht.dynamics.verdicts.noise import Noise
from wucht.numerics.observers.records import Blocks
from wucht.numerics.observers.turns import PER_TURN

_SEEN = 1e-4  # rad: a difference that is seen beside what cycles are known to
_APART = 1.0  # rad
_SLOWS_DOWN = 0.5  # of its first growth, in the logarithm: what grows less at last comes to a limit


def windows_until_apart(whole: Blocks, about: Sequence[int], borders: np.ndarray, noise: Noise) -> float:
    """In how many windows two of the bodies about a rotor have parted, as their difference grows; inf where none does.

    about: which of the others. borders: the times (g + 1,) between groups of whole cycles, the windows. noise: of the
    integration.
    """
    turned = np.cumsum((whole.followers[list(about)] / whole.speed - 1) * (2 * math.pi * whole.size / PER_TURN), axis=1)
    at = np.searchsorted(whole.time, borders)
    apart = [a - b for a, b in itertools.combinations(turned, 2)]
    each = ([float(np.ptp(d[i:j])) for i, j in itertools.pairwise(at)] for d in apart)
    return min((_until_apart(sizes, max(_SEEN, noise.angle)) for sizes in each), default=math.inf)


def _until_apart(sizes: Sequence[float], least: float) -> float:
    """In how many windows a difference of such sizes in successive windows is a radian; inf if it is not going to be.

    least: below it a difference is none.
    """
    if len(sizes) < 3 or min(sizes) < least:
        return math.inf
    growth = np.diff(np.log(sizes))
    if (growth <= 0).any() or growth[-1] < _SLOWS_DOWN * growth[0]:
        return math.inf
    return max(math.log(_APART / sizes[-1]), 0.0) / float(growth.mean())
