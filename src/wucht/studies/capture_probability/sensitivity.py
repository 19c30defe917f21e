"""Random points by scrambled Sobol' sequences, several independent ones, and the sensitivity by Sobol' indices."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from wucht.errors import InputError

REPLICATES = 16  # from ten on, intervals from the scatter of their means hold: see ``probability_bands``


def points(count: int, dimensions: int, seed: int) -> np.ndarray:
    """(REPLICATES, count/REPLICATES, dimensions): of each replicate the first points of a Sobol' sequence scrambled anew.

    count: a multiple of REPLICATES. The same for the same seed.
    """
    from scipy.stats import qmc

    each = count // REPLICATES
    power = math.ceil(math.log2(each))  # drawn at once: fewer are the first of these
    random = [np.random.default_rng(one) for one in np.random.SeedSequence(seed).spawn(REPLICATES)]
    return np.array([qmc.Sobol(dimensions, seed=r).random_base2(power)[:each] for r in random])


_RESAMPLES = 1000


@dataclass(frozen=True)
class Indices:
    """first, total: of each quantity (q,), and how far they may be off; nan where the outcome is always the same.

    used: base points of which all runs are known, of ``count``.
    """

    first: np.ndarray
    first_off: np.ndarray
    total: np.ndarray
    total_off: np.ndarray
    used: int
    count: int


def library(part: str = "sample") -> Any:
    """SALib's module of Sobol' indices. Raises ``InputError`` if it is not installed."""
    try:
        return import_module(f"SALib.{part}.sobol")
    except ImportError:
        raise InputError("study.sensitivity", True, "this needs the extra: pip install wucht[sensitivity]") from None


def cross_sampled(count: int, quantities: int, seed: int) -> np.ndarray:
    """Points (count (q + 2), q) of the unit cube: two independent ones, and those with one coordinate of the other."""
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0, 1)))
    drawn = library().sample(_problem(quantities), count, calc_second_order=False, seed=random)
    return np.asarray(drawn, float)


def indices(inside: np.ndarray, open_: np.ndarray, quantities: int, confidence: float, seed: int) -> Indices:
    """Of the runs at the points of ``cross_sampled``, which are inside and of which it is open.

    Base points of which a run is open are left out.
    """
    rows = inside.reshape(-1, quantities + 2)
    known = ~open_.reshape(-1, quantities + 2).any(axis=1)
    seen, independent = rows[known].astype(float), rows[known][:, [0, -1]]  # those in between are mixed of these two
    if not independent.any() or independent.all():
        nothing = np.full(quantities, np.nan)
        return Indices(nothing, nothing, nothing, nothing, int(known.sum()), len(rows))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of a resample in which all are alike
        found = library("analyze").analyze(
            _problem(quantities),
            seen.ravel(),
            calc_second_order=False,
            num_resamples=_RESAMPLES,
            conf_level=confidence,
            seed=seed + 1,  # to SALib 0 is none
        )
    first, first_off, total, total_off = (np.asarray(found[key], float) for key in ("S1", "S1_conf", "ST", "ST_conf"))
    return Indices(first, first_off, total, total_off, int(known.sum()), len(rows))


def _problem(quantities: int) -> dict[str, Any]:
    return {"num_vars": quantities, "names": [str(k) for k in range(quantities)], "bounds": [[0.0, 1.0]] * quantities}
