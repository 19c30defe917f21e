"""Values as a file has them, of those that Python has besides: arrays and numbers of NumPy, ranges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def python_value(value: Any) -> Any:
    """Return arrays and ranges as lists and numbers of NumPy as Python's, also within lists and tables.

    Anything else is unchanged. NumPy need not be loaded for that, nor is it: a file has no such values.
    """
    if isinstance(value, Mapping):
        return {key: python_value(inner) for key, inner in value.items()}
    if isinstance(value, range):
        return list(value)
    if type(value) in (list, tuple):
        return type(value)(map(python_value, value))
    is_of_numpy = type(value).__module__ == "numpy" and hasattr(value, "tolist")
    return value.tolist() if is_of_numpy else value
