"""The conventions of a result: every variable says what it is (``long_name``) and in which ``units``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

_ROUNDING = 1e-9  # rad

Variable = tuple[Sequence[str], Any, dict[str, str]]


def variable(dimensions: str | Sequence[str], values: Any, long_name: str, units: str = "") -> Variable:
    """A Dataset variable: dimensions (a string of names), values, what it is, in which units."""
    names = tuple(dimensions.split()) if isinstance(dimensions, str) else tuple(dimensions)
    return names, np.asarray(values), {"long_name": long_name, "units": units}


def wrapped(angle: Any) -> np.ndarray:
    """Angles in [0, 2 pi), what is a rounding below a whole turn being 0. Of any shape."""
    turn = 2 * np.pi
    found = np.remainder(angle, turn)
    return np.where(turn - found > _ROUNDING, found, 0.0)
