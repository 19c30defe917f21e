"""First connections near other orbits: of a homoclinic leaf whose saddle is a saddle-node, and between two saddle-nodes."""

from __future__ import annotations

import math
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from known_connections import BETWEEN, GOMPERTZ, LEAF, MU, P, R, X, Y
from wucht.errors import RunError
from wucht.numerics.periodic.connection import SADDLE_NODE, Connection
from wucht.numerics.periodic.connection_starts import (
    connection_from_cycle,
    connection_from_excursion,
    fold_at,
    longest_wait,
    prolong_at_saddle_node,
    rest_of,
    saddle_node_of,
    saddle_node_to_saddle,
    saddles_near,
)
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.saddle_connections import Connections
from wucht.system import System

NAMES, RANGES, TIME = ("p", "mu", "r"), ((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5)), 30.0


@cache
def last_orbit() -> Cycle:
    """The stable orbit within the leaf at mu = -0.001, a = -1, beginning next to its tip."""

    def rates(_: float, u: np.ndarray) -> tuple[float, float]:
        x, y = u
        return -x + 2 * y + x**2, 2 * x - 1.001 * y - 3 * x**2 + 1.5 * x * y

    def up(_: float, u: np.ndarray) -> float:
        return float(u[1])

    up.direction = -1.0  # type: ignore[attr-defined]
    run = solve_ivp(rates, (0, 90), (0.6, 0.3), rtol=1e-9, atol=1e-11, dense_output=True, events=up)
    begin, end = run.t_events[0][-2:]
    times = np.linspace(begin, end, 400)
    cycles = Cycles.of(LEAF, "mu", {"a": -1.0, "b": 0.0, "c": 0.0}, (-0.5, 0.5))
    return cycle_near(cycles, times - begin, run.sol(times), -0.001)


def test_the_connection_near_the_last_orbit_of_a_branch() -> None:
    """Followed for longer than that orbit's period: its ends come equally near to the saddle, as exp(t) and exp(-3 t)."""
    cycle = last_orbit()
    assert cycle.period == pytest.approx(8.6956, abs=1e-3)
    connections = Connections.of(LEAF, ("mu",), {"a": -1.0, "b": 0.0, "c": 0.0}, ((-0.5, 0.5),), 20.0)
    found = connection_from_cycle(connections, cycle, np.array([1e-3, -1e-3]), np.array([cycle.parameter]))
    assert found.time == pytest.approx(20.0)
    assert found.parameter_values[0] == pytest.approx(0.0, abs=1e-10)
    np.testing.assert_allclose(found.equilibria, [[0.0, 0.0]], atol=1e-10)
    np.testing.assert_allclose(found.eigenvalues, [[1.0, -3.0]], atol=1e-8)
    x, y = found.states
    np.testing.assert_allclose(x**2 * (1 - x), y**2, atol=1e-7)
    assert y[x.argmax() - 10] > 0 > y[x.argmax() + 10]
    begin, end = (np.hypot(x[k], y[k]) for k in (0, -1))
    assert begin < 2e-6 and end < 2e-6 and 0.2 < begin / end < 5.0


def test_what_is_missing_of_a_connection_is_that_of_the_linearised_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Samples before Newton's method: the orbit once, begun where it is next to the saddle, with exponentials at both ends."""
    cycle = last_orbit()
    connections = Connections.of(LEAF, ("mu",), {"a": -1.0, "b": 0.0, "c": 0.0}, ((-0.5, 0.5),), 20.0)
    kept: list[Any] = []
    monkeypatch.setattr(Connections, "start", lambda *given: kept.append(given))
    connection_from_cycle(connections, cycle, np.zeros(2), np.array([-0.001]))
    _, times, states, equilibria, values = kept[0]
    assert values == [-0.001] and np.abs(equilibria).max() == 0.0
    assert (times[0], times[-1]) == pytest.approx((0.0, 20.0)) and (np.diff(times) > 0).all()
    more, away = 20.0 - cycle.period, np.linalg.norm(states, axis=0)
    k = int(np.abs(times - 0.75 * more).argmin())  # 3/4 of it before, as the rates are 1 and -3
    m = int(np.abs(times - 0.75 * more - cycle.period).argmin())
    nearest = np.linalg.norm(cycle.states_at(np.linspace(0, 1, 20_001)), axis=0).min()
    assert away[[k, m]] == pytest.approx(nearest, rel=1e-2)
    assert away[0] / nearest == pytest.approx(math.exp(-0.75 * more), rel=1e-2)
    assert away[-1] / nearest == pytest.approx(math.exp(-3 * 0.25 * more), rel=1e-2)
    assert away[k : m + 1].max() == pytest.approx(float(np.linalg.norm(cycle.states, axis=0).max()), rel=1e-6)


THETA, V = sp.symbols("theta v", real=True)
ENERGY = V**2 / 2 - sp.cos(THETA) - 1
PENDULUM = System((THETA, V), (V, -sp.sin(THETA) + V * (MU - ENERGY)), (MU,), angles=frozenset({THETA}))


@pytest.mark.parametrize("saddle", [-math.pi, 3 * math.pi])
def test_the_connection_of_a_saddle_with_itself_a_turn_on(saddle: float) -> None:
    """The orbit of energy 1 + mu rotates; at mu = 0 it is v = 2 cos(theta/2), wherever the saddle is counted from."""
    energy, theta = 1 + 1e-3, np.linspace(0.0, 2 * math.pi, 20_001)
    v = np.sqrt(2 * (energy + np.cos(theta)))
    times = np.concatenate([[0.0], np.cumsum((1 / v[1:] + 1 / v[:-1]) / 2 * np.diff(theta))])
    cycles = Cycles.of(PENDULUM, "mu", {}, (-0.5, 0.5), winding={"theta": 1})
    cycle = cycle_near(cycles, times, np.array([theta, v]), 1e-3)
    connections = Connections.of(PENDULUM, ("mu",), {}, ((-0.5, 0.5),), cycle.period + 4.0, winding={"theta": 1})
    found = connection_from_cycle(connections, cycle, np.array([saddle, 0.0]), np.array([cycle.parameter]))
    assert found.parameter_values[0] == pytest.approx(0.0, abs=1e-8)
    theta, v = found.states
    assert np.ptp(theta) == pytest.approx(2 * math.pi, abs=1e-4)
    assert theta[0] == pytest.approx(math.pi, abs=1e-4)  # the saddle on the orbit's way
    np.testing.assert_allclose(v, 2 * np.abs(np.cos(theta / 2)), atol=1e-6)


def of_a_saddle_node() -> tuple[Connections, Connection]:
    """At a = -2, from the connection at a = -1.5: the leaf again, b being given."""
    near = Connections.of(LEAF, ("mu", "a"), {"b": 0.0, "c": 0.0}, ((-0.5, 0.5), (-3.0, 0.5)), 60.0)
    other = connection_from_excursion(near, np.zeros(2), (1e-3, -1.5))
    connections = with_time(60.0)
    return connections, saddle_node_of(connections, other, np.array([0.01, 0.02]), np.array([1e-3, 2e-3, 0.1]))


def with_time(time: float) -> Connections:
    return Connections.of(LEAF, ("c", "mu", "b"), {"a": -2.0}, ((-0.5, 0.5), (-0.5, 0.5), (-0.3, 0.3)), time, folds=(True,))


def test_the_connection_of_a_saddle_node() -> None:
    """c = mu = 0 for every b; left along (1, 1) as x' = x^2, and reached along (1, -1) with -4."""
    connections, found = of_a_saddle_node()
    np.testing.assert_allclose(found.parameter_values, [0.0, 0.0, 0.1], atol=1e-9)
    np.testing.assert_allclose(found.equilibria, [[0.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(found.eigenvalues, [[0.0, -4.0]], atol=1e-9)
    walk = connections.walk(found)
    points = list(walk)
    assert walk.end == "it leaves the range at 0.3" and not any(c.kind for c in points)
    np.testing.assert_allclose([c.parameter_values[:2] for c in points], 0.0, atol=1e-9)
    np.testing.assert_allclose([c.parameter_values[2] for c in points][-1], 0.3)


@pytest.mark.parametrize("time", [240.0, 1000.0])
def test_a_connection_of_a_saddle_node_for_a_longer_time(time: float) -> None:
    """It comes from ever nearer to it, as 1/x = t + ..., so that x t tends to 1; its other end decays as exp(-4 t)."""
    _, short = of_a_saddle_node()
    found = prolong_at_saddle_node(with_time(time), short)
    assert found.time == time
    np.testing.assert_allclose(found.parameter_values, [0.0, 0.0, 0.1], atol=1e-9)
    x, y = found.states
    assert x[0] * (time - 60) == pytest.approx(1.0, abs=0.32 * 240 / time) and y[0] == pytest.approx(x[0], rel=1e-2)
    assert np.hypot(x[-1], y[-1]) < 1e-9
    np.testing.assert_allclose(x**2 * (1 - x), y**2, atol=1e-7)


@pytest.mark.parametrize("time", [60.0, 59.0])
def test_a_time_that_is_no_longer_one_is_refused(time: float) -> None:
    short: Any = SimpleNamespace(time=60.0)
    with pytest.raises(RunError, match=f"the time {time:.6g} must be longer than that of the connection, 60"):
        prolong_at_saddle_node(with_time(time), short)


def test_what_a_longer_time_puts_before_and_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Samples before Newton's method: d/(1 + a d t) a time t before; exp(-4 t) behind, until that has decayed by exp(-20)."""
    _, whole = of_a_saddle_node()
    tau = np.linspace(0.5, 1.0, 5001)
    end = float(
        tau[np.abs(np.linalg.norm(whole.states_at(tau), axis=0) - 1e-3).argmin()]
    )  # of the orbit, 1e-3 from the saddle-node
    short: Any = SimpleNamespace(
        states_at=lambda tau: whole.states_at(tau * end), time=60 * end, equilibria=whole.equilibria,
        eigenvalues=whole.eigenvalues, parameter_values=whole.parameter_values,
    )  # fmt: skip
    kept: list[Any] = []
    monkeypatch.setattr(Connections, "start", lambda *given: kept.append(given))
    prolong_at_saddle_node(with_time(200.0 + short.time), short)
    _, times, (x, _), equilibria, values = kept[0]
    assert values == pytest.approx([0.0, 0.0, 0.1], abs=1e-9) and equilibria is short.equilibria
    assert (times[0], times[-1]) == pytest.approx((0.0, 200.0 + short.time)) and (np.diff(times) > 0).all()
    begun = 200.0 - 20 / 4
    k, half = (int(np.abs(times - at).argmin()) for at in (begun, begun / 2))
    assert x[k] == pytest.approx(whole.states[0, 0], rel=1e-6)
    # Its first state lies on the line y = x, where (x', y') = (2 x^2, 0): a d is 2 x^2/(sqrt(2) x).
    assert 1 / x[0] == pytest.approx(1 / x[k] + math.sqrt(2) * begun, rel=1e-3)
    assert 1 / x[half] == pytest.approx(1 / x[0] - math.sqrt(2) * times[half], rel=1e-3)
    m, behind = (int(np.abs(times - begun - short.time - t).argmin()) for t in (0.0, 0.5))
    assert x[m] == pytest.approx(1e-3 / math.sqrt(2), rel=2e-2)
    assert x[behind] / x[m] == pytest.approx(math.exp(-4 * (times[behind] - times[m])), rel=1e-3)
    assert x[-1] == pytest.approx(x[m] * math.exp(-20), abs=2e-12)  # as the saddle-node is known


@cache
def double() -> Connection:
    """From a saddle-node to a saddle-node, from the orbit along y = 0 moved a little, and wrong parameters."""

    def rates(_: float, u: np.ndarray) -> tuple[float]:
        return (float(u[0] ** 2 * (1 - u[0])),)

    run = solve_ivp(rates, (0, TIME), (0.05,), rtol=1e-10, atol=1e-12, dense_output=True)
    times = np.linspace(0, TIME, 2000)
    states = np.array([run.sol(times)[0], np.full(2000, 0.003)])
    return between(True, True).start(times, states, np.array([[0.01, 0.01], [0.99, 0.01]]), [0.002, 0.001, 0.001])


def between(*folds: bool) -> Connections:
    return Connections.of(BETWEEN, NAMES, {}, RANGES, TIME, folds=folds)


def test_the_connection_of_two_saddle_nodes() -> None:
    found = double()
    np.testing.assert_allclose(found.parameter_values[:3], 0.0, atol=1e-9)
    np.testing.assert_allclose(found.equilibria, [[0.0, 0.0], [1.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(found.eigenvalues, [[0.0, -1.0], [0.0, -1.0]], atol=1e-9)
    np.testing.assert_allclose(found.states[1], 0.0, atol=1e-9)


def test_beyond_it_a_saddle_node_is_connected_with_a_saddle() -> None:
    """At (1, sqrt(-r)), left along y with 2 sqrt(-r); mu = sqrt(-r)/(e E1(1)), to first order."""
    connections = between(True, False)
    found = saddle_node_to_saddle(connections, double())
    p, mu, r = found.parameter_values[:3]
    assert r == pytest.approx(-1e-5) and p == pytest.approx(0.0, abs=1e-12)
    y = math.sqrt(-r)
    assert mu * GOMPERTZ == pytest.approx(y, rel=2 * y)
    np.testing.assert_allclose(found.equilibria, [[0.0, 0.0], [1.0, y]], atol=1e-8)
    np.testing.assert_allclose(found.eigenvalues, [[0.0, -1.0], [2 * y, -1.0]], atol=1e-6)


def test_that_curve_ends_where_the_pair_vanishes_and_else_by_shooting() -> None:
    connections = between(True, False)
    first = saddle_node_to_saddle(connections, double())
    walks = [connections.walk(start) for start in (first, connections.backwards(first))]
    counts = [list(walk) for walk in walks]
    assert {walk.end for walk in walks} == {SADDLE_NODE, "it leaves the range at 0.5"}
    for c in max(counts, key=len)[2::3]:
        p, mu, r = c.parameter_values[:3].tolist()
        assert p == pytest.approx(0.0, abs=1e-9)

        def rates(_: float, u: np.ndarray, mu: float = mu, r: float = r) -> tuple[float, float]:
            x, y = u
            return x**2 * (1 - x), -(1 - x) * y + x * y**2 + r * x + mu * x * (1 - x)

        x = 0.02  # on the centre manifold y = (r + mu) x + ...
        run = solve_ivp(rates, (0, 90), (x, (r + mu) * x), rtol=1e-11, atol=1e-13)
        assert np.hypot(*(run.y - [[1.0], [math.sqrt(-r)]])).min() < 2e-3


def test_where_none_is_next_to_it_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Six places are tried, on both sides: 1e-5, 1e-4, 1e-3 of the last parameter."""
    at, tried = double(), []

    def lost(_: Any, __: Any, values: np.ndarray) -> None:
        tried.append(values[-1])
        raise RunError("none")

    monkeypatch.setattr("wucht.numerics.periodic.connection_starts.fold_at", lost)
    with pytest.raises(RunError, match="no connection of the saddle-node"):
        saddle_node_to_saddle(between(True, False), at)
    assert tried == pytest.approx([-1e-5, 1e-5, -1e-4, 1e-4, -1e-3, 1e-3], rel=1e-6)


def test_saddles_beside_a_saddle_node_that_has_parted() -> None:
    """Of (1, +-0.1) at r = -0.01 the upper one; at r = 0.01 there is none, and at -0.36 both are too far away."""
    equations, place = between(True, False).rates, np.array([1.0, 0.0])
    (one,) = saddles_near(equations, place, np.array([0.0, 0.0, -0.01]))
    assert one == pytest.approx([1.0, 0.1], abs=1e-9)
    assert saddles_near(equations, place, np.array([0.0, 0.0, 0.01])) == []
    assert saddles_near(equations, place, np.array([0.0, 0.0, -0.36])) == []


def test_saddles_are_in_order_of_their_distance() -> None:
    """x' = (x^2 - e^2) (x - 0.3), y' = -y, left along x at -e and 0.3, e = 0.1."""
    system = System((X, Y), ((X**2 - P) * (X - sp.Rational(3, 10)), -Y), (P, MU, R))
    equations = Connections.of(system, NAMES, {}, RANGES, TIME, folds=(True, False)).rates
    found = saddles_near(equations, np.array([0.0, 0.0]), np.array([0.01, 0.0, 0.0]))
    np.testing.assert_allclose(found, [[-0.1, 0.0], [0.3, 0.0]], atol=1e-9)


def test_a_saddle_node_near_a_place() -> None:
    """x^2 (1 - x) + p = 0 folds at x = 0, p = 0 and at x = 2/3, p = -4/27; the other parameters are kept."""
    equations = between(True, False).rates
    x, values = fold_at(equations, np.array([0.05, 0.02]), np.array([0.03, 0.0, -0.01]))
    assert values == pytest.approx([0.0, 0.0, -0.01], abs=1e-10) and x == pytest.approx([0.0, 0.0], abs=1e-9)
    x, values = fold_at(equations, np.array([0.55, 0.02]), np.array([-0.1, 0.0, 0.0]))
    assert values == pytest.approx([-4 / 27, 0.0, 0.0], abs=1e-10) and x == pytest.approx([2 / 3, 0.0], abs=1e-8)


def test_where_there_is_none() -> None:
    """x' = p + x has no fold; x' = 1 + x^2 no equilibrium."""
    straight = System((X, Y), (P + X, -Y), (P, MU, R))
    equations = Connections.of(straight, NAMES, {}, RANGES, TIME, folds=(True, False)).rates
    with pytest.raises(RunError):
        fold_at(equations, np.array([0.1, 0.1]), np.array([0.1, 0.0, 0.0]))
    empty = System((X, Y), (1 + X**2, -Y + MU), (MU, R))
    connections = Connections.of(empty, ("mu", "r"), {}, RANGES[:2], TIME)
    for begin in (0.0, 0.4):
        with pytest.raises(RunError, match="no equilibrium was found near this place"):
            connection_from_excursion(connections, np.array([begin, 0.0]), (0.0, 0.0))


def test_the_longest_wait_on_the_way() -> None:
    """x' = p + x^2 (1 - x), p = 1e-3: slow next to x = 0, and shorter next to x = 0.999, where it ends: that does not count.

    Slow is less than 0.05 of the largest speed, 4/27 + p.
    """
    p = 1e-3

    def rates(_: float, u: np.ndarray) -> tuple[float]:
        return (float(p + u[0] ** 2 * (1 - u[0])),)

    run = solve_ivp(rates, (0, 104), (-0.9,), rtol=1e-10, atol=1e-12, dense_output=True)
    time = float(np.interp(0.999, run.y[0], run.t))
    orbit: Any = SimpleNamespace(
        states_at=lambda tau: np.array([run.sol(tau * time)[0], 0 * tau]), time=time, parameter_values=np.array([p, 0.0, 0.0])
    )
    waits = longest_wait(between(True, False), orbit)
    assert waits is not None
    fine = np.linspace(0, time, 100_001)
    x = run.sol(fine)[0]
    assert waits.state == pytest.approx([0.0, 0.0], abs=1e-4)
    assert waits.tau == pytest.approx(float(np.interp(0.0, x, fine)) / time, abs=1e-3)
    fastest = float((p + x**2 * (1 - x)).max())  # where it begins
    slow = p + x**2 * (1 - x) < 0.05 * fastest
    assert waits.share == pytest.approx(float((slow & (x < 0.6)).mean()), abs=2e-4)
    times, states = rest_of(orbit, waits.tau)
    assert (times[0], times[-1]) == pytest.approx((0.0, (1 - waits.tau) * time))
    assert states[0, [0, -1]] == pytest.approx([0.0, 0.999], abs=1e-3)
    # Slow next to 0 and 1, and at both ends of the way for longer: the longer one in between counts.
    shares, places = (0, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.65, 0.7, 1), (0, 0, 0.5, 1, 1, 0.5, 0, 0, 1, 1)
    to_and_fro: Any = SimpleNamespace(
        states_at=lambda tau: np.array([np.interp(tau, shares, places), 0 * tau]), time=1.0, parameter_values=np.zeros(3)
    )
    waits = longest_wait(between(True, False), to_and_fro)
    assert waits is not None and 0.55 <= waits.tau <= 0.65 and waits.state[0] == 0.0
    quick: Any = SimpleNamespace(
        states_at=lambda tau: np.array([0.4 + 0.2 * tau, 0 * tau]), time=1.0, parameter_values=orbit.parameter_values
    )
    assert longest_wait(between(True, False), quick) is None


def test_places_next_to_it_are_apart_by_shares_of_the_size_of_the_last_parameter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which is 4; all others stay as they are."""
    tried = list[list[float]]()

    def lost(_: Any, place: np.ndarray, values: np.ndarray) -> None:
        assert place.tolist() == [7.0]
        tried.append(values.tolist())
        raise RunError("none")

    monkeypatch.setattr("wucht.numerics.periodic.connection_starts.fold_at", lost)
    monkeypatch.setattr("wucht.numerics.periodic.connection_starts.rest_of", lambda *_: (None, None))
    connections: Any = SimpleNamespace(rates=SimpleNamespace(scale=np.array([1.0, 2.0, 3.0, 4.0])), bounds=(0, 0, 0))
    at: Any = SimpleNamespace(parameter_values=np.array([0.1, 0.2, 0.3, 30.0]), equilibria=np.array([[7.0], [8.0]]))
    with pytest.raises(RunError):
        saddle_node_to_saddle(connections, at)
    assert [values[:2] for values in tried] == [[0.1, 0.2]] * 6
    shifts = [(values[2] - 0.3) / 4.0 for values in tried]
    assert shifts == pytest.approx([-1e-5, 1e-5, -1e-4, 1e-4, -1e-3, 1e-3], rel=1e-6)
