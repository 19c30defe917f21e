"""Distributions of random quantities: what a table says, as a distribution of ``scipy.stats``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.errors import InputError, nearest
from wucht.schema import Unit, read_quantity

KINDS = {
    "uniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "log-normal": ("median", "factor"),
    "triangular": ("low", "mode", "high"),
}
_TRUNCATED = ("normal", "log-normal")
_BETWEEN = "between"
_LEAST_LEFT = 1e-6  # of the probability between the limits: less is another distribution than the one that was meant
_FACTOR = Unit("", "factor")


@dataclass(frozen=True)
class Distribution:
    """A distribution of ``scipy.stats``: its name there, shape, place and width. logarithmic: of the natural logarithms."""

    name: str
    shape: tuple[float, ...]
    place: float
    width: float
    logarithmic: bool = False

    def at(self, share: np.ndarray) -> np.ndarray:
        """The values below which these shares (M,) lie, in (0, 1)."""
        from scipy import stats

        values = np.asarray(getattr(stats, self.name).ppf(share, *self.shape, loc=self.place, scale=self.width))
        return np.asarray(np.exp(values)) if self.logarithmic else values


def check_form(given: Mapping[str, Any], where: str) -> None:
    """Raises ``InputError`` where a table has not the form of a distribution; its numbers are read when their unit is known."""
    for key in given:
        if key not in (*KINDS, _BETWEEN):
            raise InputError(f"{where}.{key}", given[key], f"unknown key; {nearest(key, (*KINDS, _BETWEEN))}")
    kinds = [key for key in given if key in KINDS]
    if len(kinds) != 1:
        forms = ", ".join(f"{kind} = [{', '.join(numbers)}]" for kind, numbers in KINDS.items())
        raise InputError(where, dict(given), f"must be a table of one distribution: {forms}")
    if _BETWEEN in given and kinds[0] not in _TRUNCATED:
        allowed = f"not allowed with {kinds[0]}, which ends by itself; it limits {' and '.join(_TRUNCATED)}"
        raise InputError(f"{where}.{_BETWEEN}", given[_BETWEEN], allowed)
    for key, numbers in given.items():
        names = KINDS.get(key, ("low", "high"))
        if not isinstance(numbers, list | tuple) or len(numbers) != len(names):
            raise InputError(f"{where}.{key}", numbers, f"must be [{', '.join(names)}]")


def distribution_of(given: Mapping[str, Any], unit: Unit, where: str) -> Distribution:
    """A distribution of a quantity with this unit. Raises ``InputError`` at ``where``."""
    kind = next(key for key in given if key in KINDS)
    at = f"{where}.{kind}"
    units = [_FACTOR if name == "factor" else unit for name in KINDS[kind]]
    numbers = [read_quantity(u, one, f"{at}[{i}]") for i, (u, one) in enumerate(zip(units, given[kind], strict=True))]
    if kind in ("uniform", "triangular"):
        if not (numbers == sorted(numbers) and numbers[0] < numbers[-1]):
            names = " <= ".join(KINDS[kind]) if len(numbers) > 2 else "low below high"
            raise InputError(at, list(given[kind]), f"must be [{', '.join(KINDS[kind])}] with {names}", code="shape")
        low, width = numbers[0], numbers[-1] - numbers[0]
        shape = () if kind == "uniform" else ((numbers[1] - low) / width,)
        return Distribution("triang" if shape else "uniform", shape, low, width)
    logarithmic = kind == "log-normal"
    if logarithmic and not (numbers[0] > 0 and numbers[1] > 1):
        within = "68 % lie between median/factor and median factor"
        allowed = f"must be [median, factor] with a median above 0 and a factor above 1: {within}"
        raise InputError(at, list(given[kind]), allowed, code="factor")
    if not logarithmic and not numbers[1] > 0:
        raise InputError(at, list(given[kind]), "must be [mean, deviation] with a deviation above 0", code="deviation")
    ends = (-math.inf, math.inf)
    if _BETWEEN in given:
        ends = _ends(given[_BETWEEN], unit, f"{where}.{_BETWEEN}", logarithmic)
    scale = math.log if logarithmic else float
    mean, deviation = scale(numbers[0]), scale(numbers[1])
    low, high = ((end - mean) / deviation for end in ends)
    if not 0.5 * (math.erf(high / math.sqrt(2)) - math.erf(low / math.sqrt(2))) >= _LEAST_LEFT:
        allowed = f"there must be more than {_LEAST_LEFT:g} of the distribution between these limits"
        raise InputError(f"{where}.{_BETWEEN}", list(given[_BETWEEN]), allowed)
    return Distribution("truncnorm", (low, high), mean, deviation, logarithmic)


def _ends(given: Any, unit: Unit, where: str, logarithmic: bool) -> tuple[float, float]:
    low, high = (read_quantity(unit, one, f"{where}[{i}]") for i, one in enumerate(given))
    if not low < high or (logarithmic and low < 0):
        raise InputError(where, list(given), f"must be [low, high] with low below high{', not below 0' if logarithmic else ''}")
    if logarithmic:
        return math.log(low) if low > 0 else -math.inf, math.log(high)
    return low, high
