"""First connections near other orbits: of a homoclinic leaf whose saddle is a saddle-node, and between two saddle-nodes."""

from __future__ import annotations

import math
from functools import cache

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
    prolong_at_saddle_node,
    saddle_node_of,
    saddle_node_to_saddle,
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


THETA, V = sp.symbols("theta v", real=True)
ENERGY = V**2 / 2 - sp.cos(THETA) - 1
PENDULUM = System((THETA, V), (V, -sp.sin(THETA) + V * (MU - ENERGY)), (MU,), angles=frozenset({THETA}))


@pytest.mark.parametrize("saddle", [3 * math.pi])
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


@pytest.mark.parametrize("time", [240.0])
def test_a_connection_of_a_saddle_node_for_a_longer_time(time: float) -> None:
    """It comes from ever nearer to it, as 1/x = t + ..., so that x t tends to 1; its other end decays as exp(-4 t)."""
    _, short = of_a_saddle_node()
    with pytest.raises(RunError, match="the time 60 must be longer than that of the connection, 60"):
        prolong_at_saddle_node(with_time(60.0), short)
    found = prolong_at_saddle_node(with_time(time), short)
    assert found.time == time
    np.testing.assert_allclose(found.parameter_values, [0.0, 0.0, 0.1], atol=1e-9)
    x, y = found.states
    assert x[0] * (time - 60) == pytest.approx(1.0, abs=0.32 * 240 / time) and y[0] == pytest.approx(x[0], rel=1e-2)
    assert np.hypot(x[-1], y[-1]) < 1e-9
    np.testing.assert_allclose(x**2 * (1 - x), y**2, atol=1e-7)


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
