"""The energy balance, of motions whose works are known."""

import numpy as np
import pytest

from wucht.numerics.observers.energy_balance import EnergyBalance

TIME = np.linspace(0, 5, 501)
STORED = 3 + 2 * np.cos(TIME)
SUPPLIED = np.array([4 * TIME, np.sin(TIME)])
LOST = SUPPLIED.sum(axis=0) - (STORED - STORED[0])


def residual(lost=LOST, shift=0.0):
    return EnergyBalance().update(STORED + shift, SUPPLIED, lost)[1]


def test_what_adds_up_leaves_no_residual():
    assert residual().max() < 1e-15


def test_the_residual_is_what_is_missing_over_the_largest_energy():
    assert residual(LOST + 1e-3)[-1] < 1e-15, "what was lost before is of no interest"
    missing = np.where(TIME > 2, 1e-3, 0.0)
    assert residual(LOST + missing)[-1] == pytest.approx(1e-3 / SUPPLIED.max(), rel=1e-9)
    assert residual(LOST + missing, shift=100.0)[-1] == pytest.approx(1e-3 / (100 + STORED.max()), rel=1e-9)


@pytest.mark.parametrize("cuts", [[250], [1, 2, 499]])
def test_it_is_the_same_in_parts_at_the_end(cuts):
    """A part begins with the last sample of the part before; the scale is the largest so far."""
    balance, missing = EnergyBalance(), LOST + 1e-3 * TIME
    for i, j in zip([0, *cuts], [*cuts, len(TIME) - 1], strict=True):
        part = slice(i, j + 1)
        balance, last = balance.update(STORED[part], SUPPLIED[:, part], missing[part])
    whole, each = EnergyBalance().update(STORED, SUPPLIED, missing)
    assert balance == whole
    assert last[-1] == each[-1]
