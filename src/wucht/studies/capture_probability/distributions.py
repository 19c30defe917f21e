"""Random quantities: distributions, independent sets of points by scrambled Sobol' sequences, and the sensitivity to each."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
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
_LEAST_LEFT = 1e-6  # least probability between the limits: a smaller one changes the distribution too much
_FACTOR = Unit("", "factor")


@dataclass(frozen=True)
class Distribution:
    """A distribution of ``scipy.stats``: its name, shape, location and scale. logarithmic: of the natural logarithms."""

    name: str
    shape: tuple[float, ...]
    place: float
    width: float
    logarithmic: bool = False

    def at(self, share: np.ndarray) -> np.ndarray:
        """Values at these cumulative probabilities (M,), in (0, 1)."""
        from scipy import stats

        values = np.asarray(getattr(stats, self.name).ppf(share, *self.shape, loc=self.place, scale=self.width))
        return np.asarray(np.exp(values)) if self.logarithmic else values


def check_form(given: Mapping[str, Any], where: str) -> None:
    """Raise ``InputError`` if a table is not of the form of a distribution; its numbers are read when their unit is known."""
    for key in given:
        if key not in (*KINDS, _BETWEEN):
            raise InputError(f"{where}.{key}", given[key], f"unknown key; {nearest(key, (*KINDS, _BETWEEN))}")
    kinds = [key for key in given if key in KINDS]
    if len(kinds) != 1:
        forms = ", ".join(f"{kind} = [{', '.join(numbers)}]" for kind, numbers in KINDS.items())
        raise InputError(where, dict(given), f"must be a table of one distribution: {forms}")
    if _BETWEEN in given and kinds[0] not in _TRUNCATED:
        allowed = f"not allowed with {kinds[0]}, which is bounded already; it limits {' and '.join(_TRUNCATED)}"
        raise InputError(f"{where}.{_BETWEEN}", given[_BETWEEN], allowed)
    for key, numbers in given.items():
        names = KINDS.get(key, ("low", "high"))
        if not isinstance(numbers, list | tuple) or len(numbers) != len(names):
            raise InputError(f"{where}.{key}", numbers, f"must be [{', '.join(names)}]")


def distribution_of(given: Mapping[str, Any], unit: Unit, where: str) -> Distribution:
    """Build the distribution of a quantity with this unit. Raises ``InputError`` at ``location``."""
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


REPLICATES = 16  # with ten and more, intervals from the scatter of their means hold: see ``computation``


def points(count: int, dimensions: int, seed: int) -> np.ndarray:
    """Points (REPLICATES, count/REPLICATES, dimensions): each replicate begins a newly scrambled Sobol' sequence.

    count: a multiple of REPLICATES. The points are the same for the same seed.
    """
    from scipy.stats import qmc

    each = count // REPLICATES
    power = math.ceil(math.log2(each))  # drawn at once; the first points of them are used
    random = [np.random.default_rng(one) for one in np.random.SeedSequence(seed).spawn(REPLICATES)]
    return np.array([qmc.Sobol(dimensions, seed=r).random_base2(power)[:each] for r in random])


_RESAMPLES = 1000


@dataclass(frozen=True)
class Indices:
    """Sobol' indices. first, total: of each quantity (q,), with their uncertainties; NaN if the outcome is always the same.

    used_points: base points of which all runs have a verdict, of ``count``.
    """

    first: np.ndarray
    first_off: np.ndarray
    total: np.ndarray
    total_off: np.ndarray
    used: int
    count: int


def library(part: str = "sample") -> Any:
    """Load SALib's module of Sobol' indices. Raises ``InputError`` if it is not installed."""
    try:
        return import_module(f"SALib.{part}.sobol")
    except ImportError:
        raise InputError("study.sensitivity", True, "this needs the extra: pip install wucht[sensitivity]") from None


def cross_sampled(count: int, quantities: int, seed: int) -> np.ndarray:
    """Points (count (q + 2), q) of the unit cube: pairs of independent points, and mixtures with one exchanged coordinate."""
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0, 1)))
    drawn = library().sample(_problem(quantities), count, calc_second_order=False, seed=random)
    return np.asarray(drawn, float)


def indices(inside: np.ndarray, open_: np.ndarray, quantities: int, confidence: float, seed: int) -> Indices:
    """Compute the indices from the runs at the points of ``cross_samples``: masks of inside and of undecided ones.

    Base points with an undecided run are left out.
    """
    rows = inside.reshape(-1, quantities + 2)
    known = ~open_.reshape(-1, quantities + 2).any(axis=1)
    seen, independent = rows[known].astype(float), rows[known][:, [0, -1]]  # those in between are mixtures of these two
    if not independent.any() or independent.all():
        nothing = np.full(quantities, np.nan)
        return Indices(nothing, nothing, nothing, nothing, int(known.sum()), len(rows))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of a resample in which all are equal
        found = library("analyze").analyze(
            _problem(quantities),
            seen.ravel(),
            calc_second_order=False,
            num_resamples=_RESAMPLES,
            conf_level=confidence,
            seed=seed + 1,  # SALib takes 0 as no seed
        )
    first, first_off, total, total_off = (np.asarray(found[key], float) for key in ("S1", "S1_conf", "ST", "ST_conf"))
    return Indices(first, first_off, total, total_off, int(known.sum()), len(rows))


def _problem(quantities: int) -> dict[str, Any]:
    return {"num_vars": quantities, "names": [str(k) for k in range(quantities)], "bounds": [[0.0, 1.0]] * quantities}
