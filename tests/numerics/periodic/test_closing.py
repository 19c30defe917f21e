"""Orbits at given parameter values by collocation, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from tests.refusals import failed

from wucht.errors import RunError
from wucht.numerics.periodic.closing import Closing, Places, close_orbit, places, with_clock
from wucht.system import TIME, System

RNG = np.random.default_rng(3)
ROTATION = np.linalg.qr(RNG.normal(size=(4, 4)))[0]


def maps_of(values: list[float], count: int) -> np.ndarray:
    """Maps (count, 4, 4) whose product has these eigenvalues, in directions that are the columns of no unit matrix."""
    bases = [ROTATION, *(np.linalg.qr(RNG.normal(size=(4, 4)))[0] for _ in range(count - 1)), ROTATION]
    shares = np.sign(values) * np.abs(values) ** (1 / count)
    assert (np.array(values) > 0).all()
    return np.array([bases[k + 1] @ np.diag(shares) @ bases[k].T for k in range(count)])


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("free", [False, True])
def test_the_direction_of_a_family_and_what_cannot_be_closed(count: int, free: bool) -> None:
    """M is symmetric here: both are the eigenvector of 1, or with a free period what of them the flow leaves."""
    at = Places(maps_of([3.0, 1.0, 1.0, 0.2], count), np.zeros((count, 4)))
    if free:
        at.by_period[-1] = ROTATION[:, 1]  # the flow
    borders = at.borders((0,) if free else (), free, 0)
    k = 1 if free else 2
    assert borders.open.shape == (4, k) and borders.rows.shape == (k + 1, 5)
    np.testing.assert_allclose(borders.open.T @ borders.open, np.eye(k), atol=1e-13)
    outside = borders.open - ROTATION[:, 1:3] @ (ROTATION[:, 1:3].T @ borders.open)
    np.testing.assert_allclose(outside, 0, atol=1e-12)
    if free:
        np.testing.assert_allclose(borders.open.T @ ROTATION[:, 1], 0, atol=1e-12)
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
    assert by[0] @ ROTATION[:, 1] == pytest.approx(0.0, abs=1e-10)


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


x, v, y, a = sp.symbols("x v y a", real=True)
TURN = 2 * math.pi


def closing(reference: list[float], period: float, **more: object) -> Closing:
    n = len(reference)
    given = {"held_states": (), "free_period": False, "left_open": 0} | more
    return Closing(np.zeros(n), np.ones(n), np.array(reference, float), period, **given)  # type: ignore[arg-type]


def test_time_becomes_a_state() -> None:
    system = System((x,), (-a * x + sp.cos(TIME),), (a,))
    timed = with_clock(system)
    assert system.depends_on_time and not timed.depends_on_time
    assert len(timed.states) == 2 and timed.derivatives[1] == 1


def test_time_as_a_last_state_advances_by_a_period_and_begins_where_it_is_given() -> None:
    timed = closing([0.5, 0.25], TURN, held_states=(1,), free_period=True).with_time(1.5)
    assert timed.advance.tolist() == [0.0, 0.0, TURN] and timed.sizes.tolist() == [1.0, 1.0, TURN]
    assert timed.reference.tolist() == [0.5, 0.25, 1.5] and timed.held_states == (2, 1)
    assert (timed.period, timed.free_period, timed.left_open) == (TURN, True, 0)


def test_a_forced_oscillator_from_a_poor_motion() -> None:
    """x' = -a x + cos t from a constant: x = (a cos t + sin t)/(1 + a^2), seen from a time of 1."""
    system = System((x,), (-a * x + sp.cos(TIME),), (a,))
    found = close_orbit(system, np.array([0.3]), 1.0, np.full((1, 30), 0.7), closing([0.7], TURN), 25)
    t = 1.0 + TURN * found.times
    assert found.period == pytest.approx(TURN, rel=1e-14)
    np.testing.assert_allclose(found.states[0], (0.3 * np.cos(t) + np.sin(t)) / 1.09, atol=1e-10)


def test_a_free_period_and_a_held_state() -> None:
    """r' = r (1 - r^2), turning at the rate 3, from a circle of another radius at another rate."""
    r = 1 - x**2 - y**2
    system, tau = System((x, y), (r * x - 3 * y, 3 * x + r * y)), TURN * np.linspace(0, 1, 60)
    motion = np.array([0.6 * np.cos(tau), 0.6 * np.sin(tau)])
    found = close_orbit(system, np.zeros(0), 0.0, motion, closing([0.6, 0.0], 2.5, held_states=(1,), free_period=True), 25)
    assert found.period == pytest.approx(TURN / 3, rel=1e-9)
    assert found.states[:, 0] == pytest.approx([1.0, 0.0], abs=1e-9)


def test_of_a_family_the_nearest() -> None:
    """All motions of a linear oscillator are closed: none is preferred, the one that begins at the guess is found."""
    system, tau = System((x, v), (v, -x)), TURN * np.linspace(0, 1, 60)
    motion = np.array([1.2 * np.cos(tau), -1.1 * np.sin(tau)])
    found = close_orbit(system, np.zeros(0), 0.0, motion, closing([1.2, 0.0], TURN), 25)
    np.testing.assert_allclose(
        found.states, 1.2 * np.array([np.cos(TURN * found.times), -np.sin(TURN * found.times)]), atol=1e-9
    )


def test_where_there_is_none_it_is_told() -> None:
    """x'' = 1 + x^2 has no periodic motion at all."""
    system, tau = System((x, v), (v, 1 + x**2)), TURN * np.linspace(0, 1, 60)
    with pytest.raises(RunError):
        close_orbit(system, np.zeros(0), 0.0, np.array([np.cos(tau), -np.sin(tau)]), closing([1.0, 0.0], TURN), 25)
