"""A motion law seen through a linkage: the lever's for a law of the output, and the output's for a law of the lever."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.cams.derivatives import composed
from wucht.cams.laws.law import Law
from wucht.cams.linkages.closure import Linkage
from wucht.numerics.zeros import crossings

_GRID = 2048  # angles a turn, between which no law has two extremes


@dataclass(frozen=True, eq=False)
class LeverMotion:
    """The lever's motion rho(phi), a law, that makes the output move by a law psi(phi).

    Raises ``InputError`` (linkage) where the output would reach a dead point: which psi, and between which it must stay.
    """

    law: Law
    linkage: Linkage

    def __post_init__(self) -> None:
        self.linkage.lever_derivatives(_extremes(self.law))

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles in rad of any shape."""
        return _through(self.linkage.lever_derivatives, self.law, phi, order)

    def transmission_angle(self, phi: np.ndarray | float) -> np.ndarray:
        """Of the linkage (``Linkage.transmission_angle``), at cam angles of any shape."""
        return self.linkage.transmission_angle(self(phi))


@dataclass(frozen=True, eq=False)
class OutputMotion:
    """The output's motion psi(phi), a law, that a lever makes which moves by a law rho(phi).

    The lever may pass positions in line with the rod, where the output turns back. Raises ``InputError`` (linkage) where it
    could not move the output any more: which rho, and between which it must stay.
    """

    lever_law: Law
    linkage: Linkage

    def __post_init__(self) -> None:
        self.linkage.output_derivatives(_extremes(self.lever_law))

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles in rad of any shape."""
        return _through(self.linkage.output_derivatives, self.lever_law, phi, order)

    def transmission_angle(self, phi: np.ndarray | float) -> np.ndarray:
        """Of the linkage (``Linkage.transmission_angle``), at cam angles of any shape."""
        return self.linkage.transmission_angle(self.lever_law(phi))


def _through(derivatives: Callable[[np.ndarray], np.ndarray], law: Law, phi: np.ndarray | float, order: int) -> np.ndarray:
    inner = [law(phi, n) for n in range(order + 1)]
    return composed(derivatives(inner[0]), inner)


def _extremes(law: Law) -> np.ndarray:
    """The values of a law on a grid and where its velocity changes its sign in between."""
    grid = np.linspace(0, 2 * math.pi, _GRID + 1)
    return law(np.concatenate([grid, crossings(lambda phi: law(phi, 1), grid)]))
