"""Laps of curves, distances in a window with an angle, and the ends of curves at its border, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.phase_plane import fixed_points
from wucht.numerics.phase_plane.closed_curves import ClosedCurve, last_lap
from wucht.numerics.phase_plane.fixed_points import kind_of, window_around
from wucht.numerics.phase_plane.phase_curves import Portrait
from wucht.numerics.phase_plane.plane import TURN, Plane
from wucht.system import System

X, Y = sp.symbols("x y", real=True)
FLAT = Plane(System((X, Y), (Y, -X)), {}, np.array([-2.0, -5.0]), np.array([2.0, 5.0]))
ROUND = Plane(System((X, Y), (Y, -X), angles=frozenset({X})), {}, np.array([1.0, -5.0]), np.array([1.0 + TURN, 5.0]))


def test_differences_and_lengths_are_in_units_of_the_window() -> None:
    """Of an angle within half a turn."""
    a, b = np.array([1.5, 3.0]), np.array([-0.5, -1.0])
    assert FLAT.difference(a, b) == pytest.approx([0.5, 0.4]) and FLAT.difference(b, a) == pytest.approx([-0.5, -0.4])
    assert ROUND.difference(np.array([6.0, 1.0]), np.array([0.5, 0.0])) == pytest.approx([(5.5 - TURN) / TURN, 0.1])
    many = np.array([[6.0, 0.5 + 3 * TURN], [1.0, 2.0]])
    assert ROUND.difference(many, np.array([[0.5], [0.0]])) == pytest.approx(np.array([[(5.5 - TURN) / TURN, 0.0], [0.1, 0.2]]))
    assert FLAT.length(np.array([[0.0, 4.0, 4.0], [0.0, 0.0, -5.0]])) == pytest.approx(1.5)
    assert FLAT.length(np.array([[0.0, 4.0], [0.0, 10.0]])) == pytest.approx(math.sqrt(2))


def test_angles_are_wrapped_into_the_window() -> None:
    """Which begins at 1; other states stay."""
    assert ROUND.wrap_to_window(np.array([0.5, 9.0])) == pytest.approx([0.5 + TURN, 9.0])
    assert ROUND.wrap_to_window(np.array([[1.0, 1.0 + TURN], [-9.0, 0.0]])) == pytest.approx(
        np.array([[1.0, 1.0], [-9.0, 0.0]])
    )
    assert FLAT.wrap_to_window(np.array([17.0, 9.0])).tolist() == [17.0, 9.0]


def circle(turns: float, growth: float = 0.0, count: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Around 0 with radii of a quarter of the window, which grow by a share each turn; a turn takes a time of 3."""
    share = np.linspace(0.0, turns, round(count * turns) + 1)
    r = (1 + growth * share) / 4
    return np.array([4 * r * np.cos(TURN * share), 10 * r * np.sin(TURN * share)]), 3 * share


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_last_lap_of_a_circle(way: float) -> None:
    """Between two samples of its start; backwards in time too."""
    states, time = circle(2.3 + 1e-3)
    lap = last_lap(FLAT, states, way * time)
    assert lap is not None
    assert lap.period == pytest.approx(3.0, rel=1e-5) and lap.advance.tolist() == [0.0, 0.0] and lap.gap < 1e-3
    assert lap.state == pytest.approx(states[:, -1])
    assert (lap.shares[0], lap.shares[-1]) == (pytest.approx(0.0, abs=6e-3), pytest.approx(1.0, abs=6e-3))
    assert (np.diff(lap.shares) > 0).all() and len(lap.shares) == 200


def test_the_gap_of_a_lap_that_grows() -> None:
    """Its radius has grown by a hundredth of a quarter; between two coarse samples the way there is a chord."""
    for count in (200, 37):
        lap = last_lap(FLAT, *circle(2.3, 0.01, count))
        assert lap is not None and lap.gap == pytest.approx(0.0025, rel=0.1) and lap.period == pytest.approx(3.0, rel=1e-2)
    assert last_lap(FLAT, *circle(2.3, 0.2)) is None and last_lap(FLAT, *circle(0.9)) is None
    assert last_lap(FLAT, np.zeros((2, 2)), np.arange(2.0)) is None


def test_a_lap_whose_end_lies_beside_its_beginning_between_two_samples() -> None:
    """Through (0.06, 0.03) and (0.14, 0.045) of the window, once around, and along x to (0.1, 0.05)."""
    way = np.array([[0.06, 0.14, 0.5, 0.5, -0.5, -0.5, -0.1, 0.1], [0.03, 0.045, 0.0, 0.5, 0.5, 0.0, 0.05, 0.05]])
    lap = last_lap(FLAT, way * [[4.0], [10.0]], np.arange(8.0))
    assert lap is not None
    # It passes x = 0.1 half way, at y = 0.0375: 0.0125 beside the end, after half of its first step.
    assert lap.gap == pytest.approx(0.0125) and lap.period == pytest.approx(6.5)
    assert lap.shares == pytest.approx((np.arange(1.0, 8.0) - 0.5) / 6.5)


def test_a_lap_around_the_circle_of_an_angle_gains_a_turn() -> None:
    time = np.linspace(0.0, 5.0, 401)
    for way in (1.0, -1.0):
        lap = last_lap(ROUND, np.array([1.0 + way * time * TURN / 2, 0 * time]), time)
        assert lap is not None and lap.period == pytest.approx(2.0) and lap.advance == pytest.approx([way * TURN, 0.0])
    back = last_lap(ROUND, np.array([1.0 + time * TURN / 2, 0 * time]), -time)
    assert back is not None and back.period == pytest.approx(2.0) and back.advance == pytest.approx([-TURN, 0.0])


def closed(multiplier: float) -> ClosedCurve:
    return ClosedCurve(np.array([[-1.0, 1.0, 1.0, -1.0, -1.0], [-2.0, -2.0, 2.0, 2.0, -2.0]]), 3.0, np.zeros(2), multiplier)


def test_the_distance_from_a_closed_curve_is_that_of_its_pieces() -> None:
    """In units of the window, 4 by 10: beside a piece, at a corner, on it, and far along its line."""
    assert closed(0.5).distance(FLAT, np.array([0.5, 3.0])) == pytest.approx(0.1)
    assert closed(0.5).distance(FLAT, np.array([1.4, 2.0 + 1.0])) == pytest.approx(math.hypot(0.1, 0.1))
    assert closed(0.5).distance(FLAT, np.array([0.3, -2.0])) == pytest.approx(0.0, abs=1e-15)
    assert closed(0.5).distance(FLAT, np.array([0.0, 0.0])) == pytest.approx(0.2)
    turned = ClosedCurve(np.array([[1.1, 2.0], [0.0, 0.0]]), 1.0, np.zeros(2), 0.5)
    assert turned.distance(ROUND, np.array([0.9 + TURN, 0.0])) == pytest.approx(0.2 / TURN)


def test_a_closed_curve_attracts_by_its_multiplier() -> None:
    for multiplier, kind, forwards, backwards in (
        (0.5, "stable", True, False), (2.0, "unstable", False, True), (1 + 0.9e-6, "one of a family", True, True),
        (1 - 0.9e-6, "one of a family", True, True), (1 + 1.1e-6, "unstable", False, True), (1 - 1.1e-6, "stable", True, False),
    ):  # fmt: skip
        made = closed(multiplier)
        assert (made.kind, made.attracts(True), made.attracts(False)) == (kind, forwards, backwards)


@pytest.mark.parametrize(
    ("eigenvalues", "kind"),
    [
        ([1.0, -2.0], "saddle"), ([-1.0, -2.0], "stable node"), ([1.0, 2.0], "unstable node"), ([2j, -2j], "centre"),
        ([-1 + 2j, -1 - 2j], "stable focus"), ([1 + 2j, 1 - 2j], "unstable focus"), ([0.0, -1.0], "degenerate"),
        ([1.0, 0.0], "degenerate"),
        ([0.0, 0.0], "degenerate"), ([1e-10 + 1j, 1e-10 - 1j], "centre"), ([1e-8 + 1j, 1e-8 - 1j], "unstable focus"),
        ([-1.0, 0.9e-9], "degenerate"), ([-1.0, 1.1e-9], "saddle"),
    ],
)  # fmt: skip
def test_kinds_of_fixed_points(eigenvalues: list[complex], kind: str) -> None:
    assert kind_of(np.array(eigenvalues, complex)) == kind


def test_a_window_around_fixed_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.6 of their extent beyond them, at least half of the farthest one's distance from zero; where all are there, 1.5."""

    def shown(points: list[list[float]], low: list[float], high: list[float]) -> tuple[list[float], list[float]]:
        states = [SimpleNamespace(state=np.array(p)) for p in points]
        monkeypatch.setattr(fixed_points, "fixed_points", lambda _: SimpleNamespace(points=states))
        computed = window_around(FLAT.system, {}, np.array(low), np.array(high))
        states[:] = [SimpleNamespace(state=-np.array(p)) for p in points]
        mirrored = window_around(FLAT.system, {}, -np.array(high), -np.array(low))
        assert computed is not None and mirrored is not None
        assert (-mirrored[1]).tolist() == computed[0].tolist() and (-mirrored[0]).tolist() == computed[1].tolist()
        return computed[0].tolist(), computed[1].tolist()

    free = [math.nan, math.nan]
    assert shown([[0.0, 1.0], [10.0, 1.0]], free, free) == ([-6.0, 0.5], [16.0, 1.5])
    assert shown([[8.0, 0.0], [10.0, 0.0]], free, free) == ([3.0, -7.5], [15.0, 7.5])
    assert shown([[0.0, 0.0]], free, free) == ([-1.5, -1.5], [1.5, 1.5])
    assert shown([[0.0, 1.0]], [math.nan, -3.0], [math.nan, 4.0]) == ([-1.5, -3.0], [1.5, 4.0])
    monkeypatch.setattr(fixed_points, "fixed_points", lambda _: SimpleNamespace(points=[]))
    assert window_around(FLAT.system, {}, np.array(free), np.array(free)) is None


def test_a_larger_box_with_very_many_fixed_points_is_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of boxes of 1, 10, 100 and 1000: more than 20 fixed points are those of periodic functions."""

    def within(many: int) -> list[float]:
        def points(plane: Plane) -> Any:
            size = plane.high[0]
            return SimpleNamespace(
                points=[SimpleNamespace(state=np.array([0.9 * size, k])) for k in range(2 if size < 50 else many)]
            )

        monkeypatch.setattr(fixed_points, "fixed_points", points)
        computed = window_around(FLAT.system, {}, np.full(2, math.nan), np.full(2, math.nan))
        assert computed is not None
        return [float(computed[0][0]), float(computed[1][0])]

    assert within(21) == pytest.approx([4.5, 13.5]) and within(20) == pytest.approx([450.0, 1350.0])


def test_a_curve_ends_where_it_leaves_the_window_or_arrives_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the samples before that, its last state and the time there; only new samples count."""
    points: Any = [SimpleNamespace(state=np.array([1.5, 0.0]), attracts=1, kind="")]
    portrait: Any = SimpleNamespace(plane=FLAT, points=points)
    states, time = np.array([[0.0, 1.0, 1.5, 3.0, 1.5], [0.0, 0.0, 1.0, 2.0, 0.0]]), np.arange(5.0) * 2
    portrait._arrival = lambda *_: (-1, 0.0)
    curve = Portrait._ended_curve(portrait, states, time, 1, True)
    assert curve is not None and (curve.end, curve.index) == ("left the window", -1)
    assert curve.time == pytest.approx([0.0, 2.0, 4.0, 4 + 2 / 3])
    assert curve.states == pytest.approx(np.column_stack([states[:, :3], [2.0, 1 + 1 / 3]]))
    for arrival, kind, count in ((0, "fixed point", 2), (3, "left the window", 3)):
        portrait._arrival = lambda *_, at=arrival: (at, 0.125)
        curve = Portrait._ended_curve(portrait, states, time, 1, True)
        assert curve is not None and (curve.end, len(curve.time)) == (kind, count + 1)
    portrait._arrival = lambda *_: (0, 0.125)
    curve = Portrait._ended_curve(portrait, states, time, 1, True)
    assert curve is not None and (curve.index, curve.gap, curve.time[-1]) == (0, 0.125, 2.0)
    assert curve.states[:, -1] == pytest.approx([1.5, 0.0])
    portrait._arrival = lambda *_: (-1, 0.0)
    assert Portrait._ended_curve(portrait, states, time, 4, True) is None


def test_the_usual_speed_is_the_median_in_units_of_the_window(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of x' = x over 1 to 5: x/4 at 41 places; places at rest do not count."""
    growing = System((X, Y), (X, sp.S.Zero))
    monkeypatch.setattr(Plane, "rates", lambda _, x: np.array([x[0], 0 * x[0]]))
    assert Plane(growing, {}, np.array([1.0, 0.0]), np.array([5.0, 9.0])).usual_speed == pytest.approx(0.75)
    assert Plane(growing, {}, np.array([0.0, 0.0]), np.array([4.0, 9.0])).usual_speed == pytest.approx(20.5 / 40)
    plane = Plane(growing, {}, np.array([1.0, 0.0]), np.array([5.0, 9.0]))
    assert plane.length_numbers(True, 1e-2) == pytest.approx([1.0, 4.0, 9.0, 0.0075])
    assert plane.length_numbers(False, 1e-2)[0] == -1.0
