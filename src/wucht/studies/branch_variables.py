"""Quantities common to the results of several studies of branches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.steady_states import Ordinates
from wucht.results.quantities import Quantity
from wucht.schema import Parameter


def join_arrays(parts: Sequence[Any], rows: int | None = None) -> np.ndarray:
    """Join the arrays (N,) or (rows, N) of all branches, one after another."""
    empty = np.empty(0) if rows is None else np.empty((rows, 0))
    return np.concatenate([empty, *parts], axis=-1)


def steady_branch_quantities(
    dimension: str, before: str, branches: Sequence[EquilibriumBranch], ordinates: Sequence[Ordinates], along: Parameter,
    words: tuple[str, str, str],
) -> list[Quantity]:  # fmt: skip
    """Quantities of the points on branches of steady states.

    before: prefix of the names of variables. ordinates: of each branch. words: name and unit of the ordinate, and the unit of
    the amplitude.
    """
    ordinate_words, unit, length = words
    numbers = np.repeat(np.arange(len(branches)), [b.unknowns.shape[1] for b in branches])
    return [
        Quantity(f"{before}value", join_arrays([b.values for b in branches]), along.full_name, along.unit, dimension),
        Quantity(f"{before}speed", join_arrays([s.speed for s in ordinates]), ordinate_words, unit, dimension),
        Quantity(
            f"{before}amplitude", join_arrays([s.amplitude for s in ordinates]), "amplitude of the axis", length, dimension
        ),
        Quantity(f"{before}stable", join_arrays([b.stable for b in branches]).astype(np.int8), "stable", "", dimension),
        Quantity(f"{before}branch", numbers.astype(int), "branch", "", dimension),
    ]
