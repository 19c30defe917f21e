"""Curves in a plane: the regions between them, and where they cross."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.branches.plane_regions import (
    NOT_DECIDED,
    PlaneRegions,
    cell_centres,
    cell_size,
    divide_plane,
    divided_by_places,
    kinds_by_region,
    sides_of,
    widest_difference,
)


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


def columns() -> PlaneRegions:
    """Twenty columns over 0 to 20, ten rows over 0 to 5: region 1 from x = 12 on, else region 0."""
    x, y = np.arange(20) + 0.5, (np.arange(10) + 0.5) / 2
    return PlaneRegions(np.tile((x > 12).astype(int), (10, 1)), x, y)


def test_the_kinds_left_and_right_of_a_curve() -> None:
    """Upwards along x = 12 region 0 lies left, downwards right; of a single point both neighbours of the diagonal count."""
    found, kinds = columns(), ["low", "high"]
    x, y = np.full(3, 12.0), np.array([1.0, 2.0, 3.0])
    assert sides_of(found, kinds, x, y) == [("low", "high")] * 3
    assert sides_of(found, kinds, x, y[::-1]) == [("high", "low")] * 3
    assert sides_of(found, kinds, np.array([12.0]), np.array([2.5])) == [("low", "high")]
    assert (
        sides_of(found, kinds, x - 3.5, y) == [("low", "low")] * 3
        and sides_of(found, kinds, x - 2.5, y) == [("low", "high")] * 3
    )


def test_a_tiny_region_belongs_to_its_neighbour() -> None:
    """A corner cut off at 1/100 of a side has half of 1e-4 of the plane; without curves there is one region."""
    bounds = [(0.0, 10.0), (-1.0, 1.0)]
    corner = np.array([9.9, 10.0]), np.array([-1.0, -0.98])
    assert divide_plane([corner], bounds).count == 1 and divide_plane([], bounds).count == 1
    whole = divide_plane([(np.array([0.0, 10.0]), np.array([0.5, 0.5]))], bounds)
    assert whole.count == 2 and whole.region_at(5.0, 0.6) != whole.region_at(5.0, 0.4) == whole.region_at(9.0, -0.9)
    assert (whole.x[0], whole.x[-1], whole.y[0]) == (10 / 480, 10 - 10 / 480, -1 + 1 / 240)


def test_the_kind_of_a_region_is_that_of_most_places_and_those_at_an_edge_do_not_contradict() -> None:
    places = [
        (2.0, 1.0, "a"),
        (3.0, 2.0, "a"),
        (4.0, 3.0, "b"),
        (11.0, 3.0, "b"),
        (15.0, 1.0, "c"),
        (18.0, 1.0, "d"),
        (19.0, 1.0, "d"),
    ]
    kinds, against = kinds_by_region(columns(), places)
    assert kinds == ["a", "d"] and against == [(4.0, 3.0, "b")]


@pytest.mark.parametrize("border", [0.37, 0.61])
def test_what_no_curve_separates_is_divided_by_places_and_not_decided_between_them(border: float) -> None:
    """Places of two kinds, left and right of a line that is not known; halved until they are a quarter of a cell apart."""
    bounds, cells = ((0.0, 1.0), (0.0, 2.0)), 5
    whole, cell = divide_plane([], bounds), cell_size(bounds, cells)

    def kind(x: float) -> str:
        return "left" if x < border else "right"

    places = [(float(x), float(y), kind(x)) for x in cell_centres(bounds[0], cells) for y in cell_centres(bounds[1], cells)]
    shares, known = list[dict[str, float]](), len(places)
    for _ in range(2):
        regions, kinds = divided_by_places(whole, kinds_by_region(whole, places)[0], places, cell)
        shares.append({name: float((regions.index == k).mean()) for k, name in enumerate(kinds)})
        while (between := widest_difference(whole, places, cell)) is not None:
            places.append((*between, kind(between[0])))
    for share in shares:
        assert sum(share.values()) == pytest.approx(1.0)
        assert share["left"] <= border + 0.005 and share["right"] <= 1 - border + 0.005
    assert 0.2 / 3 < shares[0][NOT_DECIDED] < 0.2 / 2, "a third of a cell, more between the rows"
    assert shares[1][NOT_DECIDED] < 0.75 * shares[0][NOT_DECIDED]
    assert known < len(places) <= known + 4 * cells
