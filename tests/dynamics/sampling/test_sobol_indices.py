"""Sobol' indices of indicators that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.sampling.distributions import cross_samples, indices


def test_what_does_not_enter_does_not_matter() -> None:
    """Of x1 + 0 x2 > c the first has all, alone and with the second."""
    at = cross_samples(512, 2, seed=1)
    found = indices(at[:, 0] > 0.3, np.zeros(len(at), bool), 2, 0.95, seed=1)
    assert found.first[0] == pytest.approx(1.0, abs=0.05)
    assert found.total[0] == pytest.approx(1.0, abs=0.05)
    assert found.first[1] == found.total[1] == found.total_off[1] == 0.0
    assert found.first_off[0] > 0


def test_a_corner() -> None:
    """Of x1 < a and x2 < b, x3 idle: with p = a b, S1 = b (1 - a)/(1 - p), T1 = (1 - a)/(1 - p), and so for the second."""
    a, b = 0.7, 0.4
    at = cross_samples(1024, 3, seed=2)
    found = indices((at[:, 0] < a) & (at[:, 1] < b), np.zeros(len(at), bool), 3, 0.95, seed=2)
    first = np.array([b * (1 - a), a * (1 - b), 0.0]) / (1 - a * b)
    total = np.array([1 - a, 1 - b, 0.0]) / (1 - a * b)
    assert np.abs(found.first - first) == pytest.approx(0.0, abs=0.06)
    assert np.abs(found.total - total) == pytest.approx(0.0, abs=0.06)
    assert (np.abs(found.first - first) <= found.first_off).all()
    assert (np.abs(found.total - total) <= found.total_off).all()
    assert (found.used_points, found.count) == (1024, 1024)


def test_quantities_that_are_drawn_together_count_as_one() -> None:
    """Three coordinates of a track and one more: u1 + u2 + u3 + v > 2. Two such sums with the first three in common are
    correlated by 3/4: of normal ones the sides of their mean on which they lie are by (2/pi) arcsin(3/4) = 0.540, the index of
    the first quantity; that of the other one is (2/pi) arcsin(1/4) = 0.161."""
    at = cross_samples(1024, 2, 5, [3, 1])
    assert at.shape == (1024 * 4, 4)
    of_first, of_second = at[1::4], at[2::4]
    assert np.array_equal(of_first[:, 3], at[::4, 3]) and not (of_first[:, :3] == at[::4, :3]).any()
    assert np.array_equal(of_second[:, :3], at[::4, :3]) and not (of_second[:, 3] == at[::4, 3]).any()
    found = indices(at.sum(axis=1) > 2, np.zeros(len(at), bool), 2, 0.95, seed=5)
    assert found.first == pytest.approx([2 * np.arcsin(0.75) / np.pi, 2 * np.arcsin(0.25) / np.pi], abs=0.06)


def test_its_intervals_hold() -> None:
    """Resampled as if the points were independent, they are too wide rather than too narrow."""
    a, b, held = 0.6, 0.5, []
    for seed in range(12):
        at = cross_samples(128, 2, seed)
        found = indices((at[:, 0] < a) & (at[:, 1] < b), np.zeros(len(at), bool), 2, 0.95, seed)
        held.append(abs(found.first[0] - b * (1 - a) / (1 - a * b)) <= found.first_off[0])
        held.append(abs(found.total[1] - (1 - b) / (1 - a * b)) <= found.total_off[1])
    assert np.mean(held) >= 0.9


def test_points_with_an_open_run_are_left_out() -> None:
    at = cross_samples(256, 2, seed=4)
    open_ = np.zeros(len(at), bool)
    open_[[1, 2, 4 * 7 + 3]] = True
    found = indices(at[:, 0] > 0.5, open_, 2, 0.95, seed=4)
    assert (found.used_points, found.count) == (254, 256)
    changed = at[:, 0] > 0.5
    changed[open_] = ~changed[open_]
    again = indices(changed, open_, 2, 0.95, seed=4)
    assert np.array_equal(again.first, found.first)
    assert np.array_equal(again.total_off, found.total_off)


@pytest.mark.parametrize("inside", [np.zeros(64 * 4, bool), np.ones(64 * 4, bool)])
def test_where_all_end_alike_there_are_none(inside: np.ndarray) -> None:
    found = indices(inside, np.zeros(len(inside), bool), 2, 0.95, seed=0)
    assert np.isnan(found.first).all()
    assert np.isnan(found.total).all()
    none_known = indices(inside, np.ones(len(inside), bool), 2, 0.95, seed=0)
    assert none_known.used_points == 0
    assert np.isnan(none_known.total).all()
