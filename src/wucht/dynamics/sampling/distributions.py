"""Random quantities: distributions, independent sets of points by scrambled Sobol' sequences, and the sensitivity to each."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Protocol

import numpy as np

from wucht.errors import InputError, nearest
from wucht.schema import Unit, read_quantity

KINDS = {
    "uniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "log-normal": ("median", "factor"),
    "triangular": ("low", "mode", "high"),
}
_TRUNCATABLE = ("normal", "log-normal")
_BETWEEN = "between"
_LEAST_PROBABILITY = 1e-6  # least probability between the limits: a smaller one changes the distribution too much
_FACTOR = Unit("", "factor")


class JointDistribution(Protocol):
    """Values of one or several quantities that are drawn together."""

    @property
    def dimensions(self) -> int:
        """Number of the quantities, and of the independent uniform numbers that they follow from."""
        ...

    def values(self, shares: np.ndarray) -> np.ndarray:
        """Values (k, M) of the k quantities at points (M, k) of the open unit cube."""
        ...


@dataclass(frozen=True)
class Distribution:
    """A distribution of ``scipy.stats``: its name, shape, location and scale. logarithmic: of the natural logarithms."""

    dimensions: ClassVar[int] = 1

    name: str
    shape: tuple[float, ...]
    place: float
    width: float
    logarithmic: bool = False

    def quantiles(self, share: np.ndarray) -> np.ndarray:
        """Values at these cumulative probabilities (M,), in (0, 1)."""
        from scipy import stats

        values = np.asarray(getattr(stats, self.name).ppf(share, *self.shape, loc=self.place, scale=self.width))
        return np.asarray(np.exp(values)) if self.logarithmic else values

    def values(self, shares: np.ndarray) -> np.ndarray:
        """See ``JointDistribution``."""
        return self.quantiles(shares[:, 0])[None]


def check_form(definition: Mapping[str, Any], location: str) -> None:
    """Raise ``InputError`` if a table is not of the form of a distribution; its numbers are read when their unit is known."""
    for key in definition:
        if key not in (*KINDS, _BETWEEN):
            raise InputError(f"{location}.{key}", definition[key], f"unknown key; {nearest(key, (*KINDS, _BETWEEN))}")
    kinds = [key for key in definition if key in KINDS]
    if len(kinds) != 1:
        forms = ", ".join(f"{kind} = [{', '.join(numbers)}]" for kind, numbers in KINDS.items())
        raise InputError(location, dict(definition), f"must be a table of one distribution: {forms}")
    if _BETWEEN in definition and kinds[0] not in _TRUNCATABLE:
        requirement = f"not allowed with {kinds[0]}, which is bounded already; it limits {' and '.join(_TRUNCATABLE)}"
        raise InputError(f"{location}.{_BETWEEN}", definition[_BETWEEN], requirement)
    for key, numbers in definition.items():
        names = KINDS.get(key, ("low", "high"))
        if not isinstance(numbers, list | tuple) or len(numbers) != len(names):
            raise InputError(f"{location}.{key}", numbers, f"must be [{', '.join(names)}]")


def distribution_of(definition: Mapping[str, Any], unit: Unit, location: str) -> Distribution:
    """Build the distribution of a quantity with this unit. Raises ``InputError`` at ``location``."""
    kind = next(key for key in definition if key in KINDS)
    at = f"{location}.{kind}"
    units = [_FACTOR if name == "factor" else unit for name in KINDS[kind]]
    numbers = [read_quantity(u, one, f"{at}[{i}]") for i, (u, one) in enumerate(zip(units, definition[kind], strict=True))]
    if kind in ("uniform", "triangular"):
        if not (numbers == sorted(numbers) and numbers[0] < numbers[-1]):
            names = " <= ".join(KINDS[kind]) if len(numbers) > 2 else "low below high"
            raise InputError(at, list(definition[kind]), f"must be [{', '.join(KINDS[kind])}] with {names}", code="shape")
        low, width = numbers[0], numbers[-1] - numbers[0]
        shape = () if kind == "uniform" else ((numbers[1] - low) / width,)
        return Distribution("triang" if shape else "uniform", shape, low, width)
    logarithmic = kind == "log-normal"
    if logarithmic and not (numbers[0] > 0 and numbers[1] > 1):
        within = "68 % lie between median/factor and median*factor"
        requirement = f"must be [median, factor] with a median above 0 and a factor above 1: {within}"
        raise InputError(at, list(definition[kind]), requirement, code="factor")
    if not logarithmic and not numbers[1] > 0:
        raise InputError(at, list(definition[kind]), "must be [mean, deviation] with a deviation above 0", code="deviation")
    ends = (-math.inf, math.inf)
    if _BETWEEN in definition:
        ends = _ends(definition[_BETWEEN], unit, f"{location}.{_BETWEEN}", logarithmic)
    scale = math.log if logarithmic else float
    mean, deviation = scale(numbers[0]), scale(numbers[1])
    low, high = ((end - mean) / deviation for end in ends)
    if not 0.5 * (math.erf(high / math.sqrt(2)) - math.erf(low / math.sqrt(2))) >= _LEAST_PROBABILITY:
        requirement = f"there must be more than {_LEAST_PROBABILITY:g} of the distribution between these limits"
        raise InputError(f"{location}.{_BETWEEN}", list(definition[_BETWEEN]), requirement)
    return Distribution("truncnorm", (low, high), mean, deviation, logarithmic)


def distribution_in_words(definition: Mapping[str, Any]) -> str:
    """A distribution in words: ``uniform: low 0 deg, high 360 deg``."""
    kind = next(k for k in definition if k in KINDS)
    numbers = ", ".join(f"{name} {value}" for name, value in zip(KINDS[kind], definition[kind], strict=True))
    return f"{kind}: {numbers}" + (", between {} and {}".format(*definition[_BETWEEN]) if _BETWEEN in definition else "")


def _ends(limits: Any, unit: Unit, location: str, logarithmic: bool) -> tuple[float, float]:
    low, high = (read_quantity(unit, one, f"{location}[{i}]") for i, one in enumerate(limits))
    if not low < high or (logarithmic and low < 0):
        raise InputError(
            location, list(limits), f"must be [low, high] with low below high{', not below 0' if logarithmic else ''}"
        )
    if logarithmic:
        return math.log(low) if low > 0 else -math.inf, math.log(high)
    return low, high


REPLICATES = 16  # with ten and more, intervals from the scatter of their means hold: see ``probability_bands``


def replicate_count(count: int) -> int:
    """Return the number of replicates of so many points; where they are no multiple of REPLICATES, each is independent."""
    return count if count % REPLICATES else REPLICATES


def points(count: int, dimensions: int, seed: int) -> np.ndarray:
    """Points (R, count/R, dimensions): each of the R = ``replicate_count(count)`` begins a newly scrambled Sobol' sequence.

    The points are the same for the same seed.
    """
    from scipy.stats import qmc

    replicates = replicate_count(count)
    replicate_size = count // replicates
    power = math.ceil(math.log2(replicate_size))  # drawn at once; the first points of them are used
    random = [np.random.default_rng(one) for one in np.random.SeedSequence(seed).spawn(replicates)]
    return np.array([qmc.Sobol(dimensions, seed=r).random_base2(power)[:replicate_size] for r in random])


def sample_values(distributions: Sequence[JointDistribution], shares: np.ndarray) -> np.ndarray:
    """Values (q, M) of random quantities at points (M, q) of the unit cube."""
    tiny = np.finfo(float).tiny
    inside = np.clip(shares, tiny, 1 - np.finfo(float).epsneg)  # at 0 and 1 the values of a normal distribution are infinite
    columns = np.split(inside, np.cumsum([one.dimensions for one in distributions])[:-1], axis=1)
    return np.concatenate([one.values(of_one) for one, of_one in zip(distributions, columns, strict=True)])


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
    used_points: int
    count: int


def library(part: str = "sample") -> Any:
    """Load SALib's module of Sobol' indices. Raises ``InputError`` if it is not installed."""
    try:
        return import_module(f"SALib.{part}.sobol")
    except ImportError:
        raise InputError("study.sensitivity", True, "this needs the extra: pip install wucht[sensitivity]") from None


def cross_samples(count: int, quantities: int, seed: int, dimensions: Sequence[int] | None = None) -> np.ndarray:
    """Points (count (q + 2), d) of the unit cube: pairs of independent points, and mixtures with one exchanged quantity.

    dimensions: number of coordinates of each of the q quantities, by default one; d is their sum.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0, 1)))
    problem = _problem(quantities)
    if dimensions is not None and max(dimensions) > 1:
        groups = [str(k) for k, columns in enumerate(dimensions) for _ in range(columns)]
        problem = _problem(len(groups)) | {"groups": groups}
    samples = library().sample(problem, count, calc_second_order=False, seed=random)
    return np.asarray(samples, float)


def indices(inside: np.ndarray, open_: np.ndarray, quantities: int, confidence: float, seed: int) -> Indices:
    """Compute the indices from the runs at the points of ``cross_samples``: masks of inside and of undecided ones.

    Base points with an undecided run are left out.
    """
    rows = inside.reshape(-1, quantities + 2)
    is_known = ~open_.reshape(-1, quantities + 2).any(axis=1)
    outcomes, independent = (
        rows[is_known].astype(float),
        rows[is_known][:, [0, -1]],
    )  # those in between are mixtures of these two
    if not independent.any() or independent.all():
        nothing = np.full(quantities, np.nan)
        return Indices(nothing, nothing, nothing, nothing, int(is_known.sum()), len(rows))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of a resample in which all are equal
        analysis = library("analyze").analyze(
            _problem(quantities),
            outcomes.ravel(),
            calc_second_order=False,
            num_resamples=_RESAMPLES,
            conf_level=confidence,
            seed=seed + 1,  # SALib takes 0 as no seed
        )
    first, first_off, total, total_off = (np.asarray(analysis[key], float) for key in ("S1", "S1_conf", "ST", "ST_conf"))
    return Indices(first, first_off, total, total_off, int(is_known.sum()), len(rows))


def _problem(quantities: int) -> dict[str, Any]:
    return {"num_vars": quantities, "names": [str(k) for k in range(quantities)], "bounds": [[0.0, 1.0]] * quantities}
