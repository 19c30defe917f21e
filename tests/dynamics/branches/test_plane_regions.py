"""Curves in a plane: the regions between them, and where they cross."""

from __future__ import annotations

import numpy as np

from wucht.dynamics.branches.plane_regions import divide_plane, kinds_by_region, sides_of
from wucht.dynamics.branches.second_parameter import crossing_pieces


def test_regions_of_a_circle_and_a_line() -> None:
    angle = np.linspace(0.0, 2 * np.pi, 200)
    circle, line = (np.cos(angle), np.sin(angle)), (np.array([-2.0, 2.0]), np.array([0.0, 0.0]))
    found = divide_plane([circle, line], [(-2.0, 2.0), (-2.0, 2.0)])
    assert found.count == 4
    assert found.region_at(0.0, 0.5) != found.region_at(0.0, -0.5)
    assert np.hypot(*found.innermost_point(found.region_at(0.0, 0.5))) < 0.7
    kinds, against = kinds_by_region(found, [(0, 0.5, "in"), (0.3, 0.5, "in"), (0, 1.5, "out"), (0.1, 0.5, "out")])
    assert kinds[found.region_at(0.0, 0.5)] == "in"
    assert kinds[found.region_at(0.0, -1.5)] == ""
    assert against == [(0.1, 0.5, "out")]
    sides = sides_of(found, kinds, *(np.array(c)[80:90] for c in circle))
    assert {frozenset(s) for s in sides} == {frozenset(("in", "out"))}


def test_pieces_of_two_lines_that_cross() -> None:
    a, b = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 2.0]]), np.array([[0.0, 2.0], [1.5, 1.4]])
    assert crossing_pieces(a, b) == [(1, 0)]
