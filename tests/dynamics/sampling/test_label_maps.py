"""Borders of maps of labels: what is at one, and what is run anew when cells are halved."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.sampling.label_maps import (
    border_cells,
    border_cells_not_run,
    cells_to_halve,
    halve_cells,
    uncertainty,
    widen_cells,
)

OPEN = (False, False)


def test_eight_neighbours() -> None:
    labels = np.zeros((5, 6), int)
    labels[2, 3] = 1
    expected = np.zeros((5, 6), bool)
    expected[1:4, 2:5] = True
    assert np.array_equal(border_cells(labels, OPEN), expected)


@pytest.mark.parametrize("periodic", [OPEN, (True, False), (False, True), (True, True)])
def test_by_hand_on_every_cell(periodic: tuple[bool, bool]) -> None:
    """Against a loop over cells and their neighbours."""
    labels = np.random.default_rng(3).integers(0, 2, (6, 7)) * (np.arange(7) > 3)
    expected = np.zeros(labels.shape, bool)
    for i, j in np.ndindex(*labels.shape):
        for di, dj in np.ndindex(3, 3):
            k, m = i + di - 1, j + dj - 1
            k, m = k % 6 if periodic[0] else k, m % 7 if periodic[1] else m
            if 0 <= k < 6 and 0 <= m < 7:
                expected[i, j] |= bool(labels[k, m] != labels[i, j])
    assert np.array_equal(border_cells(labels, periodic), expected)
    grown = widen_cells(expected, periodic)
    alone = np.argwhere(expected)
    near = np.zeros(labels.shape, bool)
    for i, j in alone.tolist():
        for di, dj in np.ndindex(3, 3):
            k, m = i + di - 1, j + dj - 1
            k, m = k % 6 if periodic[0] else k, m % 7 if periodic[1] else m
            if 0 <= k < 6 and 0 <= m < 7:
                near[k, m] = True
    assert np.array_equal(grown, near)


def test_without_a_border_nothing_is_halved() -> None:
    assert not cells_to_halve(np.full((4, 4), 7), (True, True), True).any()


def test_a_rim_on_the_coarsest_map_alone() -> None:
    labels = np.zeros((8, 8), int)
    labels[:, 4:] = 1
    assert np.flatnonzero(cells_to_halve(labels, OPEN, False).all(axis=0)).tolist() == [3, 4]
    assert np.flatnonzero(cells_to_halve(labels, OPEN, True).all(axis=0)).tolist() == [2, 3, 4, 5]
    assert np.flatnonzero(cells_to_halve(labels, (False, True), False).all(axis=0)).tolist() == [0, 3, 4, 7]


def test_four_parts_of_each_cell() -> None:
    assert np.array_equal(halve_cells(np.array([[1, 2]])), [[1, 1, 2, 2], [1, 1, 2, 2]])


def test_what_was_handed_down_beside_another_label_is_left() -> None:
    labels = np.zeros((4, 6), int)
    labels[1, 2] = 1
    run = np.zeros((4, 6), bool)
    run[:, :3] = True
    assert np.argwhere(border_cells_not_run(labels, run, OPEN)).tolist() == [[0, 3], [1, 3], [2, 3]]


@pytest.mark.parametrize("periodic", [OPEN, (True, False), (False, True), (True, True)])
def test_the_uncertainty_of_a_share_knows_which_axis_comes_round(periodic: tuple[bool, bool]) -> None:
    """Turned by a right angle, map and periods alike, it is the same; a band across a periodic axis has two borders there."""
    inside = np.zeros((6, 9), bool)
    inside[:2] = True
    assert uncertainty(inside, periodic) == pytest.approx(uncertainty(inside.T, periodic[::-1]), rel=1e-15)
    borders = 2 if periodic[0] else 1
    assert uncertainty(inside, periodic) == pytest.approx(2 * np.sqrt(borders * 81 / 12) / 54, rel=1e-12)
