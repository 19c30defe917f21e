"""The multiplier of a closed curve: of its monodromy, or by Liouville's formula where that has lost it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.numerics.phase_plane.closed_curves import _multiplier

TIMES = np.linspace(0, 3, 61)


def plane(*diagonal: float) -> Any:
    def jacobian(states: np.ndarray) -> np.ndarray:
        return np.einsum("ij,N->ijN", np.diag(diagonal), 2 * TIMES / 3)  # its mean over the period is 1

    return SimpleNamespace(scale=np.ones(2), jacobian=jacobian)


@pytest.mark.parametrize("diagonal", [(-0.5, -0.2), (0.4, 0.1), (1.0, -1.3)])
def test_where_rounding_hides_it_areas_grow_as_the_divergence_says(diagonal: tuple[float, float]) -> None:
    """d(ln area)/dt = div: a curve that attracts has a multiplier below 1."""
    lost = np.array([[1e9, 1e9], [1e9, 1e9]])
    assert _multiplier(plane(*diagonal), lost, TIMES, np.zeros((2, 61))) == pytest.approx(math.exp(3 * sum(diagonal)), rel=1e-6)


def test_else_it_is_the_determinant() -> None:
    assert _multiplier(plane(9.0, 9.0), np.diag([1.0, 0.3]), TIMES, np.zeros((2, 61))) == pytest.approx(0.3, rel=1e-14)
