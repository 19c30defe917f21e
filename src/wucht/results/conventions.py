"""The conventions of a result: every variable says what it is (``long_name``) and in which ``units``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

Variable = tuple[Sequence[str], Any, dict[str, str]]


def variable(dimensions: str | Sequence[str], values: Any, long_name: str, units: str = "") -> Variable:
    """A Dataset variable: dimensions (a string of names), values, what it is, in which units."""
    names = tuple(dimensions.split()) if isinstance(dimensions, str) else tuple(dimensions)
    return names, np.asarray(values), {"long_name": long_name, "units": units}
