"""Distributions of random quantities, by their inverse distribution functions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.checking import read_quantity
from wucht.errors import InputError, nearest
from wucht.quantities import Unit

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
class Uniform:
    """All values between low and high alike."""

    low: float
    high: float

    def at(self, share: np.ndarray) -> np.ndarray:
        """The values below which these shares (M,) lie, in (0, 1)."""
        return np.asarray(self.low + (self.high - self.low) * share)


@dataclass(frozen=True)
class Triangular:
    """A density that rises from low to the mode and falls to high."""

    low: float
    mode: float
    high: float

    def at(self, share: np.ndarray) -> np.ndarray:
        """See ``Uniform``."""
        width, left = self.high - self.low, self.mode - self.low
        below = self.low + np.sqrt(share * width * left)
        above = self.high - np.sqrt((1 - share) * width * (self.high - self.mode))
        return np.asarray(np.where(share * width < left, below, above))


@dataclass(frozen=True)
class Normal:
    """mean, deviation: of the whole distribution, of which the part between low and high is taken. logarithmic: all of these
    are natural logarithms."""

    mean: float
    deviation: float
    low: float = -math.inf
    high: float = math.inf
    logarithmic: bool = False

    def at(self, share: np.ndarray) -> np.ndarray:
        """See ``Uniform``."""
        from scipy.special import ndtr, ndtri

        a, b = ((end - self.mean) / self.deviation for end in (self.low, self.high))
        sign = -1 if a > 0 else 1  # beyond the mean by the mirror image: there shares near 1 would be rounded
        p, q = (ndtr(a), ndtr(b)) if sign > 0 else (ndtr(-a), ndtr(-b))
        normal = np.clip(sign * ndtri(p + share * (q - p)), a, b)
        values = self.mean + self.deviation * normal
        return np.asarray(np.exp(values) if self.logarithmic else values)

    @property
    def left(self) -> float:
        """The probability between low and high."""
        return 0.5 * (
            math.erf((self.high - self.mean) / self.deviation / math.sqrt(2))
            - math.erf((self.low - self.mean) / self.deviation / math.sqrt(2))
        )


Distribution = Uniform | Triangular | Normal


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
            raise InputError(at, list(given[kind]), f"must be [{', '.join(KINDS[kind])}] with {names}")
        return Uniform(*numbers) if kind == "uniform" else Triangular(*numbers)
    logarithmic = kind == "log-normal"
    if logarithmic and not (numbers[0] > 0 and numbers[1] > 1):
        within = "68 % lie between median/factor and median factor"
        allowed = f"must be [median, factor] with a median above 0 and a factor above 1: {within}"
        raise InputError(at, list(given[kind]), allowed)
    if not logarithmic and not numbers[1] > 0:
        raise InputError(at, list(given[kind]), "must be [mean, deviation] with a deviation above 0")
    ends = (-math.inf, math.inf)
    if _BETWEEN in given:
        ends = _ends(given[_BETWEEN], unit, f"{where}.{_BETWEEN}", logarithmic)
    scale = math.log if logarithmic else float
    made = Normal(scale(numbers[0]), scale(numbers[1]), *ends, logarithmic)
    if not made.left >= _LEAST_LEFT:
        allowed = f"there must be more than {_LEAST_LEFT:g} of the distribution between these limits"
        raise InputError(f"{where}.{_BETWEEN}", list(given[_BETWEEN]), allowed)
    return made


def _ends(given: Any, unit: Unit, where: str, logarithmic: bool) -> tuple[float, float]:
    low, high = (read_quantity(unit, one, f"{where}[{i}]") for i, one in enumerate(given))
    if not low < high or (logarithmic and low < 0):
        raise InputError(where, list(given), f"must be [low, high] with low below high{', not below 0' if logarithmic else ''}")
    if logarithmic:
        return math.log(low) if low > 0 else -math.inf, math.log(high)
    return low, high
