"""Zeros of torques on a grid that are near each other, and speeds at which no torque acts."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations.closed_form import balance_speeds, zeros_of

GRID = np.linspace(0.0, 1.0, 11)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("half", [1e-2, 1e-4, 1e-6])
def test_two_zeros_between_samples_are_both_located(sign: float, half: float) -> None:
    """A parabola of either sign that dips below zero between 0.5 and 0.6, or 0.4 and 0.5."""
    for middle in (0.5371, 0.4629):
        zeros = zeros_of(lambda x, at=middle: sign * ((x - at) ** 2 - half**2), GRID)  # type: ignore[misc]
        assert zeros == pytest.approx([middle - half, middle + half], abs=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_zeros_at_the_ends_of_the_grid_count(sign: float) -> None:
    assert zeros_of(lambda x: sign * x * (x - 0.25) * (1 - x), GRID) == pytest.approx([0.0, 0.25, 1.0])


def balanced(torque: Any) -> list[tuple[float, bool]]:
    """Of two bodies, of which the second has a tenth of the torque of the first against it."""

    def shaft_torque(w: np.ndarray) -> tuple[np.ndarray, None]:
        return np.array([torque(w) / 0.9, -0.1 * torque(w) / 0.9]), None

    torques: Any = SimpleNamespace(shaft_torque=shaft_torque)
    return balance_speeds(torques, np.linspace(0.0, 100.0, 41))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_drive_that_gives_no_torque_from_a_speed_on_balances_at_all_greater_ones(sign: float) -> None:
    """The first of them stands for all, not the end of the range as well."""
    ((speed, beyond),) = balanced(lambda w: sign * np.maximum(61.3 - w, 0.0))
    assert (speed, beyond) == (pytest.approx(61.3, rel=1e-9), True)


def test_a_balance_at_one_speed_is_no_interval() -> None:
    for at in (50.0, 51.3):  # on the grid, and beside it
        ((speed, beyond),) = balanced(lambda w, zero=at: zero - w)  # type: ignore[misc]
        assert (speed, beyond) == (pytest.approx(at, rel=1e-9), False)
