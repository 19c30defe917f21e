"""Checks of numbers, each with an error message, and the text of lengths and angles in such messages."""

from __future__ import annotations

import math

import numpy as np

from wucht.errors import InputError

MOST_DECIMALS = 12


def require_positive(location: str, value: float) -> float:
    """Return a finite number above zero. Raises ``InputError``."""
    if not (math.isfinite(value) and value > 0):
        raise InputError(location, value, "must be a positive number", code="not-positive")
    return float(value)


def require_not_negative(location: str, value: float) -> float:
    """Return a finite number that is not below zero. Raises ``InputError``."""
    if not (math.isfinite(value) and value >= 0):
        raise InputError(location, value, "must not be negative", code="negative")
    return float(value)


def require_at_least(location: str, value: int, least: int) -> int:
    """Return a whole number from ``least`` on. Raises ``InputError``."""
    if not _whole(value) or value < least:
        raise InputError(location, value, f"it must be a whole number, {least} or more", code="whole-number")
    return int(value)


def require_decimals(location: str, value: int) -> int:
    """Return a number of decimals, 0 to 12. Raises ``InputError``."""
    if not _whole(value) or not 0 <= value <= MOST_DECIMALS:
        raise InputError(location, value, f"decimals must be a whole number from 0 to {MOST_DECIMALS}", code="decimals")
    return int(value)


def _whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def require_finite(location: str, values: np.ndarray) -> np.ndarray:
    """Return values of any shape, none of them missing. Raises ``InputError``."""
    if not np.isfinite(values).all():
        raise InputError(location, None, "it gives values that are not numbers (NaN or infinite)", code="not-finite")
    return values


def format_degrees(angle: float) -> str:
    """Return an angle in rad as text for the user."""
    return f"{math.degrees(angle):.6g} deg"


def format_millimetres(length: float) -> str:
    """Return a length in m as text for the user."""
    return f"{1e3 * length:.6g} mm"
