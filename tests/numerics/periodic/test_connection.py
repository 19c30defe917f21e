"""Orbits between equilibria: their test functions, ends, and what they lack of a longer time, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.numerics.periodic import connection as connections
from wucht.numerics.periodic.connection import (
    BOGDANOV_TAKENS,
    HOPF,
    LEFT_TWICE,
    SADDLE_NODE,
    TESTS,
    _edges,
    _without_leaving,
    end_distances,
    end_reason,
    is_standstill,
    leading_rate,
    missing_times,
)


def made(*eigenvalues: list[complex], **more: Any) -> Any:
    values = np.array(eigenvalues, complex)
    quantity = float((values[0, 0] + values[-1, 1]).real) if values.shape[1] > 1 else math.nan
    return SimpleNamespace(eigenvalues=values, saddle_quantity=quantity, **more)


def test_the_saddle_quantity_is_of_the_beginning_and_of_the_end() -> None:
    """It leaves the first with its largest eigenvalue and reaches the last with its second."""
    point: Any = None
    orbit = connections.Connection(point, point, 1.0, np.zeros((2, 2)), np.array([[2.0, -5.0], [7.0, -3.0]]), np.zeros(1))
    assert orbit.saddle_quantity == -1.0
    assert TESTS["neutral-saddle"](orbit) == -1.0


def test_the_slowest_reaching_eigenvalues() -> None:
    """Real ones have a positive squared difference, a pair a negative one; nothing where one is of a pair alone."""
    focus, leading = TESTS["saddle-focus"], TESTS["three-leading"]
    assert focus(made([1, -1, -3])) == pytest.approx(4.0) and focus(made([1, -1 + 2j, -1 - 2j])) == pytest.approx(-16.0)
    assert math.isnan(focus(made([1, -1, -3 + 1j, -3 - 1j]))) and math.isnan(focus(made([1, -1])))
    assert focus(made([1, -1, -9], [1, -2, -3])) == pytest.approx(1.0)
    assert leading(made([1, -1, -3 + 1j, -3 - 1j])) == pytest.approx(2.0)
    assert leading(made([9, 9, 9, 9], [1, -2 + 1j, -2 - 1j, -5])) == pytest.approx(-3.0)
    assert math.isnan(leading(made([1, -1, -3]))) and math.isnan(leading(made([1, -1 + 1j, -1 - 1j])))


def away(begin: float, end: float, size: float) -> Any:
    """Along x from its first equilibrium, at 1, up to a size, and then to one at 5 a turn further on."""
    states = np.array([[1 + begin, 1 + size, 5 + 2 * math.pi - end], [0.0, 0.0, 0.0]])
    return SimpleNamespace(states=states, equilibria=np.array([[1.0, 0.0], [5.0, 0.0]]), time=10.0)


def test_distances_of_the_ends_from_their_equilibria() -> None:
    """In terms of the largest distance from the first, and in units of the scale."""
    turn = np.array([2 * math.pi, 0.0])
    assert end_distances(away(0.5, 0.25, 20.0), np.ones(2), turn) == pytest.approx((0.025, 0.0125))
    assert end_distances(away(0.5, 0.25, 20.0), np.array([7.0, 1.0]), turn) == pytest.approx((0.025, 0.0125))


def test_times_that_an_orbit_lacks() -> None:
    """ln of the distance over 1e-7 at the rates 2 and 0.5, and what is missing of the least time, the slow end more of it."""
    turn, ones = np.array([2 * math.pi, 0.0]), np.ones(2)
    orbit = away(2e-3, 2e-5, 20.0)
    orbit.eigenvalues = np.array([[2.0, -9.0], [3.0, -0.5]])
    before, after = math.log(1e3) / 2, math.log(10.0) / 0.5
    assert missing_times(orbit, ones, turn, 10.0) == pytest.approx([before, after])
    spare = 5.0
    longer = missing_times(orbit, ones, turn, 10.0 + before + after + spare)
    assert longer == pytest.approx([before + spare * 0.2, after + spare * 0.8])
    assert missing_times(away_near(), ones, turn, 0.0) == pytest.approx([0.0, 0.0])
    orbit.eigenvalues = np.array([[2.0, -9.0], [3.0, 0.0]])
    assert missing_times(orbit, ones, turn, 99.0).tolist() == [0.0, 0.0]


def away_near() -> Any:
    orbit = away(1e-7, 1e-7, 20.0)
    orbit.eigenvalues = np.array([[2.0, -9.0], [3.0, -0.5]])
    return orbit


def test_a_saddle_that_is_reached_by_very_many_turns_limits_the_time() -> None:
    """To a hundred intervals, one for a time of 1/|eigenvalue|."""
    orbit = away(2e-3, 2e-3, 20.0)
    orbit.eigenvalues = np.array([[50.0, -9.0], [3.0, -0.1 + 40j]])
    more = missing_times(orbit, np.ones(2), np.array([2 * math.pi, 0.0]), 1e5)
    assert more == pytest.approx([100 / 50, 100 / abs(-0.1 + 40j)])


def test_edges_are_fine_enough_for_a_rate() -> None:
    assert _edges(2.0, 1.4).tolist() == pytest.approx([0.0, 2 / 3, 4 / 3, 2.0]) and _edges(0.0, 5.0).tolist() == [0.0]
    assert _edges(2.0, 1.5).tolist() == pytest.approx([0.0, 2 / 3, 4 / 3, 2.0])


def test_the_leaving_eigenvalue_is_mirrored_and_all_else_stays() -> None:
    vectors = np.array([[1.0, 2.0, 0.0], [0.5, -1.0, 1.0], [0.0, 1.0, 3.0]])
    matrix = vectors @ np.diag([-2.0, 1.5, -0.3]) @ np.linalg.inv(vectors)
    computed = _without_leaving(matrix)
    assert computed == pytest.approx(vectors @ np.diag([-2.0, -1.5, -0.3]) @ np.linalg.inv(vectors))


def test_the_leading_rate_is_that_of_the_first_equilibrium() -> None:
    assert leading_rate(made([1, -3, -9], [20, -20, -30])) == 3.0 and leading_rate(made([4, -3, -9])) == 4.0


@pytest.mark.parametrize(
    ("now", "folds", "reason"),
    [
        ([[1, -1]], [False], ""), ([[0.0, -1]], [False], SADDLE_NODE), ([[-1e-9, -1]], [False], SADDLE_NODE),
        ([[1, 0.0]], [False], LEFT_TWICE), ([[1, 1e-9 + 1j]], [False], HOPF), ([[1, -1e-9 + 1j]], [False], ""),
        ([[0.0, -1]], [True], ""), ([[1, -1], [1, 0.0]], [False, False], LEFT_TWICE), ([[1, -1], [1, 0.0]], [False, True], ""),
        ([[0.019, -0.019]], [False], BOGDANOV_TAKENS), ([[0.021, -0.001]], [False], ""), ([[0.019, -0.019]], [True], ""),
        ([[0.019, -0.019], [1, -1]], [False, False], ""),
    ],
)  # fmt: skip
def test_why_a_curve_of_connections_ends(now: list[list[complex]], folds: list[bool], reason: str) -> None:
    """Its first eigenvalue vanishes or the second does; both are a fiftieth of their largest value."""
    start = made(*([[1, -2]] * len(folds)))
    assert end_reason(folds, start, made(*now), 1.0) == reason


def test_an_eigenvalue_that_was_zero_from_the_start_does_not_end_it() -> None:
    assert end_reason([False], made([1, -0.5e-9]), made([1, 0.0]), 1.0) == ""
    assert end_reason([False], made([1, -2e-9]), made([1, 0.0]), 1.0) == LEFT_TWICE


def test_parameters_that_stand_still() -> None:
    """In units of their scale, less than 1e-4 of the step."""

    def at(length: float, *parameters: float) -> Any:
        return SimpleNamespace(parameter_values=np.array(parameters), point=SimpleNamespace(length=length))

    scale = np.array([2.0, 1.0])
    assert is_standstill(at(1.0, 0.0, 0.0), at(3.0, 3.9e-4, 0.0), scale)
    assert not is_standstill(at(1.0, 0.0, 0.0), at(3.0, 4.1e-4, 0.0), scale)
    assert not is_standstill(at(1.0, 0.0, 0.0), at(3.0, 3.2e-4, -1.7e-4), scale)
