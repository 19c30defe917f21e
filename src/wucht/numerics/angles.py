"""Angles in one turn."""

from __future__ import annotations

from typing import Any

import numpy as np

_ROUNDING = 1e-9  # rad


def wrapped(angle: Any) -> np.ndarray:
    """Angles in [0, 2 pi), what is a rounding below a whole turn being 0. Of any shape."""
    angles = np.remainder(angle, 2 * np.pi)
    return np.where(2 * np.pi - angles > _ROUNDING, angles, 0.0)


def within_half_a_turn(angle: Any) -> np.ndarray:
    """Angles in [-pi, pi), of any shape."""
    return np.asarray(np.remainder(angle + np.pi, 2 * np.pi) - np.pi)
