"""Points that fill the unit cube evenly and at random: scrambled Sobol' sequences, several independent ones."""

from __future__ import annotations

import math

import numpy as np

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
