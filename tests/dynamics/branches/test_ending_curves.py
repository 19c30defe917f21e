"""Curves of the plane of endings: from a connection of two saddle-nodes in closed form, and when following one is given up."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import wucht
from known_connections import BETWEEN, GOMPERTZ
from wucht.dynamics.branches import ending_curves
from wucht.dynamics.branches.ending_curves import BOTH_VANISH, RETURNS, TO_SADDLE
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.orbit_endings import OrbitEnd, OrbitEnding
from wucht.dynamics.branches.plane_regions import DOUBLE, PlaneCurve, PlanePoint
from wucht.dynamics.branches.steady_states import SystemEquilibria
from wucht.errors import RunError
from wucht.numerics.periodic.connection import Connection
from wucht.numerics.periodic.connection_starts import Wait

SPACE = {"x": (-1.0, 2.0), "y": (-1.0, 1.0)}
EQUATIONS = wucht.UserSystem(BETWEEN, {"p": 0.0, "mu": 0.0, "r": 0.0})
PATHS, PLANE_RANGES = ("p", "mu", "r"), ((-0.2, 0.2), (-0.3, 0.3), (-0.1, 0.1))
NO_END = OrbitEnd("", 0.0, "")


@cache
def case() -> EndingMapCase:
    states = SystemEquilibria.of(EQUATIONS, "p", PLANE_RANGES[0], SPACE)
    motion = ModulatedMotion.of(EQUATIONS, "p", PLANE_RANGES[0], states, ranges=SPACE)
    return EndingMapCase(PATHS, PLANE_RANGES, motion, 2, states.labels)


@cache
def double() -> Connection:
    """From an orbit that waits at the origin, where p = 1e-3, and goes on to (1, 0), its only saddle-node."""
    p, mu, r = 1e-3, 2e-3, -1e-3

    def rates(_: float, u: np.ndarray) -> tuple[float, float]:
        x, y = u
        return p + x**2 * (1 - x), -(1 - x) * y + x * y**2 + r * x + mu * x * (1 - x)

    run = solve_ivp(rates, (0, 104), (-0.9, 0.0), rtol=1e-10, atol=1e-12, dense_output=True)
    time = float(np.interp(0.99, run.y[0], run.t))
    waits: Any = SimpleNamespace(
        states_at=lambda tau: run.sol(tau * time),
        time=time,
        parameter_values=np.array([p, mu, r]),
        equilibria=np.array([[1.0, 0.0]]),
    )
    one = ending_curves._connections(case(), time, (True, False))
    found = ending_curves._double_connection(case(), one, waits)
    assert found is not None
    return found


def test_the_connection_of_two_saddle_nodes_from_an_orbit_that_waits() -> None:
    """All parameters zero. In the longer time the error, as 1/time, is less than 1e-7 of the ranges."""
    found = double()
    np.testing.assert_allclose(found.parameter_values[:3], 0.0, atol=1e-8)
    np.testing.assert_allclose(found.equilibria, [[0.0, 0.0], [1.0, 0.0]], atol=1e-8)
    np.testing.assert_allclose(found.eigenvalues, [[0.0, -1.0], [0.0, -1.0]], atol=1e-8)
    assert 100.0 < found.time < 400.0  # longer, once


def test_the_curves_that_begin_there() -> None:
    """Both pairs vanish where p = r = 0; the saddle is at y = sqrt(-r), and reached where mu = y/(e E1(1)) + O(y^2)."""
    lost, watched = list[str](), list[str]()
    point, curves = ending_curves._from_double(case(), double(), lost, watched.append)
    assert (point.kind, lost) == (DOUBLE, [])
    assert (point.x, point.y, point.value) == pytest.approx((0.0, 0.0, 0.0), abs=1e-8)
    assert [c.kind for c in curves] == [TO_SADDLE, BOTH_VANISH, BOTH_VANISH]
    saddle, *both = curves
    np.testing.assert_allclose([saddle.x[0], saddle.y[0]], 0.0, atol=1e-8)
    assert (np.diff(saddle.x) > 0).all() and (np.diff(saddle.y) < 0).all()
    near = (saddle.y < -1e-9) & (saddle.y > -1e-3)
    y = np.sqrt(-saddle.y[near])
    np.testing.assert_allclose(saddle.x[near] * GOMPERTZ / y, 1.0, atol=0.02)
    assert near.any() and pytest.approx(0.0, abs=1e-12) == min(0.3 - saddle.x[-1], 0.1 + saddle.y[-1])
    for c in both:
        np.testing.assert_allclose(c.y, 0.0, atol=1e-8)
        assert c.x[0] == pytest.approx(0.0, abs=1e-8)
    assert sorted(c.x[-1] for c in both) == pytest.approx([-0.3, 0.3])
    for c in curves:
        np.testing.assert_allclose(c.value, 0.0, atol=1e-8)
    assert len(watched) == 2


def test_the_curve_to_a_saddle_is_one_from_the_double_point_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """The way that ends nearer to that comes first, turned round."""
    first, ways = connection(0.01), {"here": [0.02, 0.03], "back": [0.008, 0.004]}

    def walk(start: Any) -> list[Any]:
        return [connection(mu) for mu in ways["back" if start == "back" else "here"]]

    for _ in range(2):
        third = SimpleNamespace(walk=walk, backwards=lambda _: "back")
        monkeypatch.setattr(ending_curves, "_connections", lambda *_, third=third: third)
        monkeypatch.setattr(ending_curves, "saddle_node_to_saddle", lambda *_: first)
        _, (curve, *_) = ending_curves._from_double(case(), double(), [], lambda _: None)
        np.testing.assert_allclose(curve.x, [0.0, 0.004, 0.008, 0.01, 0.02, 0.03], atol=1e-8)
        ways = {"here": ways["back"], "back": ways["here"]}


def test_where_none_is_next_to_it_the_others_are_followed_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: Any) -> None:
        raise RunError("no saddle next to it")

    def lost_pairs(*_: Any) -> Any:
        raise RunError("singular")

    lost = list[str]()
    monkeypatch.setattr(ending_curves, "saddle_node_to_saddle", none)
    _, curves = ending_curves._from_double(case(), double(), lost, lambda _: None)
    assert [c.kind for c in curves] == [BOTH_VANISH, BOTH_VANISH] and lost == ["no saddle next to it"]
    monkeypatch.setattr(ending_curves.FoldPairs, "walk", lost_pairs)
    _, curves = ending_curves._from_double(case(), double(), lost, lambda _: None)
    assert curves == [] and lost[2:] == ["the curve at which both pairs vanish at once is not followed: singular"] * 2


def test_a_connection_that_changes_with_the_time_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three times as long, eight times at most, until the plane's parameters change by less than 1e-7 of their ranges."""
    place: Any = SimpleNamespace(equilibria=np.zeros((1, 2)), parameter_values=np.zeros(3))
    at: Any = SimpleNamespace(winding=np.array([1, 0]), rates=SimpleNamespace(n=2))
    given = list[Any]()

    def nearest_pair(state: np.ndarray, end: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        given.append((state.tolist(), end.tolist()))
        return np.arange(7.0)

    def started(times: Any, states: Any, equilibria: np.ndarray, values: list[float]) -> Any:
        given.append((equilibria.tolist(), values))
        return SimpleNamespace(time=1.0, parameter_values=np.zeros(3))

    monkeypatch.setattr(ending_curves, "longest_wait", lambda *_: Wait(0.5, 0.3, np.array([0.7, 0.0])))
    monkeypatch.setattr(ending_curves, "rest_of", lambda *_: (np.array([0.0, 2.0]), np.zeros((2, 2))))
    monkeypatch.setattr(ending_curves, "FoldPairs", lambda *_: SimpleNamespace(nearest_pair=nearest_pair))
    times = list[float]()

    def connections(_: Any, time: float, folds: Any) -> Any:
        times.append(time)
        return SimpleNamespace(start=started, time=time)

    changes = iter([0.1, 0.01, 1e-8, *[0.1] * 20])

    def longer(later: Any, old: Any) -> Any:
        return SimpleNamespace(
            time=later.time, parameter_values=old.parameter_values + np.array([9.0, next(changes) * 0.6, 0.0])
        )

    monkeypatch.setattr(ending_curves, "_connections", connections)
    monkeypatch.setattr(
        ending_curves, "prolong_at_saddle_node",
        longer,
    )  # fmt: skip
    found = ending_curves._double_connection(case(), at, place)
    assert found is not None and found.time == 27.0 and times == [2.0, 3.0, 9.0, 27.0]
    assert given == [([0.7, 0.0], [2 * np.pi, 0.0]), ([[0.0, 1.0], [2.0, 3.0]], [4.0, 5.0, 6.0])]
    times.clear()
    assert ending_curves._double_connection(case(), at, place) is None and len(times) == 9
    monkeypatch.setattr(ending_curves, "prolong_at_saddle_node", lambda *_: (_ for _ in ()).throw(RunError("")))
    assert ending_curves._double_connection(case(), at, place) is None
    monkeypatch.setattr(ending_curves, "longest_wait", lambda *_: None)
    assert ending_curves._double_connection(case(), at, place) is None


def connection(mu: float, r: float = 0.0) -> Any:
    return SimpleNamespace(parameter_values=np.array([0.0, mu, r]))


class Walked:
    """A walk along some connections, with its end."""

    def __init__(self, points: list[Any], end: str) -> None:
        self.points, self.end = points, end

    def __iter__(self) -> Any:
        return iter(self.points)


def returning(
    monkeypatch: pytest.MonkeyPatch, points: list[Any], shares: list[float | None], doubles: list[Any], *,
    looks: bool = True, end: str = "it is lost",
) -> tuple[int, Any, str, int]:  # fmt: skip
    """How many points are kept, the double one, why it ends, and how often it is looked for waits."""
    waits, double_ones, looked = iter(shares), iter(doubles), list[int]()

    def waiting(_: Any, __: Any) -> Any:
        looked.append(1)
        share = next(waits)
        return None if share is None else Wait(share, 0.5, np.zeros(2))

    monkeypatch.setattr(ending_curves, "longest_wait", waiting)
    monkeypatch.setattr(ending_curves, "_double_connection", lambda *_: next(double_ones))
    connections: Any = SimpleNamespace(walk=lambda _: Walked(points, end))
    half, found, why = ending_curves._returning_curve(case(), connections, points[0], lambda _: None, looks)
    assert half == points[: len(half)]
    return len(half), found, why, len(looked)


def test_one_way_along_the_curve_until_it_waits_too_long_at_a_second_saddle_node(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is looked for after 10 points, then after half as many again; then every 10, until it waits for 0.12 of its time."""
    way = [connection(0.2 - 0.002 * k, 0.05 - 0.0005 * k) for k in range(90)]
    target = connection(0.0, 0.0)
    # After 10: none waits; after 15: there is none near it; after 22: there is one; after 33 and 43 it is looked at again.
    shares = [None, 0.2, 0.05, 0.11, 0.121]
    found = returning(monkeypatch, way, shares, [None, target])
    assert found == (44, target, "", 5)
    assert returning(monkeypatch, way[:40], [None] * 9, [])[:3] == (40, None, "the curve ends: it is lost")
    assert returning(monkeypatch, way[:40], [None] * 9, [], end="it leaves the range at 1")[2] == ""
    assert returning(monkeypatch, way[:40], [], [], looks=False)[3] == 0


def test_it_ends_where_it_goes_away_from_the_second_saddle_node(monkeypatch: pytest.MonkeyPatch) -> None:
    """Or leaves the plane, with its first point beyond that."""
    way = [connection(0.2 - 0.004 * k, 0.05 - 0.001 * k) for k in range(15)]
    back = [connection(way[-1].parameter_values[1] - 0.001, way[-1].parameter_values[2] + 0.001)] * 9
    target = connection(0.0, 0.0)
    assert returning(monkeypatch, [*way, *back], [0.05, 0.05], [target])[:3] == (15, target, "")
    out = [connection(0.2 + 0.03 * k) for k in range(9)]
    assert returning(monkeypatch, out, [], [])[:3] == (5, None, "")


def table(*columns: tuple[float, float, float]) -> np.ndarray:
    return np.array(columns).T


def test_a_curve_is_cut_at_the_edges_of_the_plane() -> None:
    """At the first edge that is passed: from (0.2, 0.08) to (0.5, 0.2) that is r = 0.1, a sixth of the way."""
    made = ending_curves._curve(
        case(), RETURNS, table((9, -0.5, 0.0), (8, -0.1, 0.0), (7, 0.2, 0.08), (1, 0.5, 0.2), (0, 0.6, 0.3))
    )
    assert made is not None and made.kind == RETURNS
    np.testing.assert_allclose(made.x, [-0.3, -0.1, 0.2, 0.25], atol=1e-12)
    np.testing.assert_allclose(made.y, [0.0, 0.0, 0.08, 0.1], atol=1e-12)
    np.testing.assert_allclose(made.value, [8.5, 8.0, 7.0, 6.0], atol=1e-12)
    assert ending_curves._curve(case(), RETURNS, table((0, 0.4, 0.0), (0, 0.5, 0.0))) is None
    whole = ending_curves._curve(case(), RETURNS, table((0, 0.1, 0.0), (1, 0.2, 0.01)))
    assert whole is not None and whole.x.tolist() == [0.1, 0.2]


def test_curves_are_followed_beyond_the_plane_on_the_same_side_of_zero() -> None:
    """Half its width; down to a tenth of a lower end that is positive, at least."""
    plane = replace(case(), ranges=((0.0, 1.0), (1.0, 3.0), (4.0, 5.0)))
    assert plane.wider_ranges == ((0.0, 1.0), (0.1, 4.0), (3.5, 5.5))
    assert plane.contains(np.array([0.5, 1.0, 2.0, 2.0]), np.array([4.5, 5.0, 3.9, 5.1])).tolist() == [
        False,
        True,
        False,
        False,
    ]


def joined(monkeypatch: pytest.MonkeyPatch, at: float) -> tuple[Any, list[str]]:
    """The curve through 0.1, 0.2, 0.3 (of mu), and the point at which one of its halves ends."""
    connections: Any = SimpleNamespace(backwards=lambda c: "back")
    here, there = OrbitEnding(0.2, 0.0, 0.0, NO_END), OrbitEnding(0.1, 0.0, 0.0, NO_END)
    first = connection(0.2)
    halves = ([connection(0.1)], connection(at), "why"), ([connection(0.3)], None, "")
    looks = list[bool]()

    def half(_case: Any, _c: Any, start: Any, _w: Any, looked: bool) -> Any:
        looks.append(looked)
        return halves[start is first]

    monkeypatch.setattr(ending_curves, "_limit", lambda *_: (connections, first))
    monkeypatch.setattr(ending_curves, "_returning_curve", half)
    third = PlaneCurve("third", np.zeros(2), np.zeros(2), np.zeros(2))
    point = PlanePoint(DOUBLE, at, 0.0, 0.0)
    monkeypatch.setattr(ending_curves, "_from_double", lambda *_: (point, [third]))
    found = ending_curves.curves_between(case(), here, there, lambda _: None)
    curve, *others = found
    assert looks == [True, False] and others[0] is third and others[1] is point
    return curve, others[2:]


def test_both_halves_and_the_point_at_which_one_ends_are_one_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    curve, lost = joined(monkeypatch, 0.0)
    assert curve.x.tolist() == [0.0, 0.1, 0.2, 0.3] and lost == ["why"] and curve.kind == RETURNS
    curve, _ = joined(monkeypatch, 0.29)
    assert curve.x.tolist() == [0.1, 0.2, 0.3, 0.29]


def test_an_orbit_that_is_not_known_begins_no_curve() -> None:
    here, there = OrbitEnding(0.2, 0.05, 0.0, NO_END), OrbitEnding(0.1, 0.05, 0.0, NO_END)
    found = ending_curves.curves_between(case(), here, there, lambda _: None)
    assert found == ("near mu = 0.2, r = 0.05: the orbit's end is not known well enough to start from it",)


@pytest.mark.parametrize(
    ("here", "there", "along", "grows"),
    [
        ((0.2, 0.05), (0.1, 0.05), 1, -1), ((0.1, 0.05), (0.2, 0.05), 1, 1), ((0.2, 0.05), (0.2, -0.05), 2, -1),
        ((0.2, -0.05), (0.2, 0.05), 2, 1),
    ],
)  # fmt: skip
@pytest.mark.parametrize("tangent", [1.0, -1.0])
def test_from_one_place_towards_the_other_along_the_parameter_that_differs(
    monkeypatch: pytest.MonkeyPatch, here: Any, there: Any, along: int, grows: int, tangent: float
) -> None:
    """Up to the saddle-node, whose values are those of its fold and of the place but for that parameter."""
    begun = list[Any]()
    first: Any = SimpleNamespace(point=SimpleNamespace(tangent=np.array([9.0, tangent])), parameter_values=np.array([0.5, 0.7]))
    last: Any = SimpleNamespace(parameter_values=np.array([0.11, 0.22]), equilibria=np.array([[1.0, 2.0]]))

    class Way:
        end = ending_curves.SADDLE_NODE

        def __iter__(self) -> Any:
            return iter([first, last])

    def walk(start: Any) -> Way:
        begun.append("back" if start == "back" else "onward")
        return Way()

    narrow: Any = SimpleNamespace(backwards=lambda _: "back", walk=walk, winding="winding", time=10.0)

    def at(_motion: Any, path: str, bounds: Any, end: Any, value: float) -> Any:
        assert (path, bounds, value) == (PATHS[along], case().wider_ranges[along], here[along - 1]) and end is NO_END
        return narrow, first

    def of(_motion: Any, _paths: Any, _bounds: Any, time: float, winding: str, folds: Any) -> Any:
        assert winding == "winding" and folds == (True,)
        return time

    def node(whole: float, orbit: Any, state: str, values: np.ndarray) -> Any:
        expected = [0.33, *here]
        expected[along] = 0.22
        assert whole == 10.0 and orbit is last and state == "state" and values.tolist() == expected
        return "short"

    def fold(_motion: Any, x: np.ndarray, value: float) -> Any:
        assert x.tolist() == [1.0, 2.0] and value == 0.11
        return SimpleNamespace(parameter=0.33, x="state")

    monkeypatch.setattr(ending_curves, "connections_at", at)
    monkeypatch.setattr(ending_curves, "connections_of", of)
    monkeypatch.setattr(ending_curves, "nearest_fold", fold)
    monkeypatch.setattr(ending_curves, "saddle_node_of", node)
    monkeypatch.setattr(ending_curves, "prolong_at_saddle_node", lambda whole, short: (whole, short))
    ends = OrbitEnding(*here, 0.0, NO_END), OrbitEnding(*there, 0.0, NO_END)
    whole, prolonged = ending_curves._limit(case(), *ends)
    assert begun == ["onward" if tangent * grows > 0 else "back"]
    assert prolonged == (whole, "short") and whole == ending_curves._SPARE * 10.0  # type: ignore[comparison-overlap]
