"""Whether two numbers of results are alike, as far as they are printed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from wucht.numerics.angles import wrap_to_pi

_ALIKE = 1e-4  # of a number, or of a turn: as much as is printed
_ROUNDING = 1e-6  # of the largest number in the unit, below which numbers are zero


def largest_number(value: Any) -> float:
    """The largest of some numbers, in magnitude; 0 for a text or None."""
    if isinstance(value, Mapping | list | tuple):
        return max(map(largest_number, value.values() if isinstance(value, Mapping) else value), default=0.0)
    return abs(float(value)) if isinstance(value, int | float) and math.isfinite(value) else 0.0


def are_alike(a: Any, b: Any, unit: str, size: float) -> bool:
    """True if two values, or all of two tables or vectors, are alike. size: below a millionth of which a number is zero."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(are_alike(x, b[name], unit, size) for name, x in a.items())
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        of_vector = max(size, largest_number(a) * _ALIKE / _ROUNDING)
        return len(a) == len(b) and all(are_alike(x, y, unit, of_vector) for x, y in zip(a, b, strict=True))
    if not (isinstance(a, int | float) and isinstance(b, int | float)):
        return bool(a == b)
    if unit == "rad" and abs(float(wrap_to_pi(a - b))) <= _ALIKE * 2 * math.pi:
        return True
    return math.isclose(a, b, rel_tol=_ALIKE, abs_tol=_ROUNDING * size)
