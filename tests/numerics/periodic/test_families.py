"""What borders an orbit's linear equations: against null spaces that are known."""

from __future__ import annotations

import numpy as np
import pytest
from tests.refusals import failed

from wucht.numerics.periodic.families import Places, places

RNG = np.random.default_rng(3)
TURN = np.linalg.qr(RNG.normal(size=(4, 4)))[0]


def maps_of(values: list[float], count: int) -> np.ndarray:
    """Maps (count, 4, 4) whose product has these eigenvalues, in directions that are the columns of no unit matrix."""
    bases = [TURN, *(np.linalg.qr(RNG.normal(size=(4, 4)))[0] for _ in range(count - 1)), TURN]
    shares = np.sign(values) * np.abs(values) ** (1 / count)
    assert (np.array(values) > 0).all()
    return np.array([bases[k + 1] @ np.diag(shares) @ bases[k].T for k in range(count)])


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("free", [False, True])
def test_the_direction_of_a_family_and_what_cannot_be_closed(count: int, free: bool) -> None:
    """M is symmetric here: both are the eigenvector of 1, or with a free period what of them the flow leaves."""
    at = Places(maps_of([3.0, 1.0, 1.0, 0.2], count), np.zeros((count, 4)))
    if free:
        at.by_period[-1] = TURN[:, 1]  # the flow
    borders = at.borders((0,) if free else (), free, 0)
    k = 1 if free else 2
    assert borders.open.shape == (4, k) and borders.rows.shape == (k + 1, 5)
    np.testing.assert_allclose(borders.open.T @ borders.open, np.eye(k), atol=1e-13)
    outside = borders.open - TURN[:, 1:3] @ (TURN[:, 1:3].T @ borders.open)
    np.testing.assert_allclose(outside, 0, atol=1e-12)
    if free:
        np.testing.assert_allclose(borders.open.T @ TURN[:, 1], 0, atol=1e-12)
        assert borders.rows[0] == pytest.approx([1, 0, 0, 0, 0])
        assert borders.rows[1, 0] == 0.0


@pytest.mark.parametrize("count", [1, 4])
def test_corrections_close_what_can_be_closed(count: int) -> None:
    """Of linear motions: after one correction what is left is what was told, and nothing has moved along the family."""
    maps = maps_of([40.0, 1.0, 0.5, 1e-3], count)
    at = Places(maps, RNG.normal(size=(count, 4)))
    missed = RNG.normal(size=(count, 4))
    borders = at.borders((), False, 0)
    by, longer, s = at.correction(missed, borders)
    assert longer == pytest.approx(0.0, abs=1e-13) and s.shape == (1,)
    left = np.einsum("jab,jb->ja", maps, by) - np.roll(by, -1, axis=0) + missed
    np.testing.assert_allclose(left[:-1], 0, atol=1e-10)
    np.testing.assert_allclose(left[-1], borders.open @ s, atol=1e-10)
    assert by[0] @ TURN[:, 1] == pytest.approx(0.0, abs=1e-10)


def test_directions_are_left_open_as_asked_and_none_where_all_is_singular() -> None:
    at = Places(maps_of([3.0, 1.001, 0.99, 0.2], 2), np.zeros((2, 4)))
    assert at.borders((), False, 0).open.shape == (4, 0)
    assert at.borders((), False, 2).open.shape == (4, 2)
    near = Places(maps_of([3.0, 1 + 1e-5, 0.99, 0.2], 2), np.zeros((2, 4)))
    assert near.borders((), False, 0, 1e-3).open.shape == (4, 1)
    assert near.borders((), False, 0, 1e-7).open.shape == (4, 0)
    nowhere = Places(np.array([np.eye(4), np.zeros((4, 4))]), np.zeros((2, 4)))
    with failed("singular"):
        nowhere.borders((), False, 5)


def test_places_are_where_maps_become_too_different() -> None:
    """Twenty maps that grow and decay by 10 each: three at most between two places; their products, and that of delays."""
    maps = np.tile(np.diag([10.0**0.5, 10.0**-0.5]), (20, 1, 1))
    late = RNG.normal(size=(20, 2))
    merged, firsts = places(maps, late)
    assert list(firsts) == list(range(0, 20, 2))
    np.testing.assert_allclose(merged.maps, np.tile(np.diag([10.0, 0.1]), (10, 1, 1)))
    np.testing.assert_allclose(merged.by_period, (maps[1::2] @ late[::2, :, None])[..., 0] + late[1::2])
