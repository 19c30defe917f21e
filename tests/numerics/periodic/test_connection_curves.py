"""Curves of connections over two parameters: special points and ends, by eigenvalues in closed form, and by shooting."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from tests.refusals import failed

from auto_demos import CIR
from wucht.numerics.periodic.connection import BOGDANOV_TAKENS, HOPF, LEFT_TWICE, STANDSTILL, Connection
from wucht.numerics.periodic.connection_starts import connection_from_excursion
from wucht.numerics.periodic.saddle_connections import Connections
from wucht.system import System

X, Y, Z, W, A, MU, S = sp.symbols("x y z w a mu s", real=True)
# B. Sandstede's planar example: the leaf x^2 (1 - x) = y^2 is a homoclinic orbit of the origin for each a, where mu = 0; the
# eigenvalues are a + 2, a - 2. Yu. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer 2004, example 6.1.
LEAF = (A * X + 2 * Y - A * X**2, 2 * X + (A + MU) * Y - 3 * X**2 - sp.Rational(3, 2) * A * X * Y)
LIMIT = 60  # points, each way


def leaves(
    more: tuple[sp.Symbol, ...], rates: tuple[sp.Expr, ...], varied: str, fixed: dict[str, float], value: float
) -> tuple[Connections, Connection]:
    """Connections of the leaf, other states being zero on it, over mu and one parameter, from mu = 0 on."""
    system = System((X, Y, *more), (*LEAF, *rates), (MU, A, S))
    connections = Connections.of(system, ("mu", varied), fixed, ((-0.5, 0.5), (-5.0, 1.5)), 30.0)
    return connections, connection_from_excursion(connections, np.zeros(len(system.states)), (1e-3, value))


def test_the_neutral_saddle_of_the_leaf() -> None:
    connections, leaf = leaves((), (), "a", {"s": 0.0}, -0.5)
    points = list(connections.walk(leaf))
    (neutral,) = [c for c in points if c.kind]
    assert neutral.kind == "neutral-saddle"
    np.testing.assert_allclose(neutral.parameter_values, [0.0, 0.0], atol=1e-8)
    np.testing.assert_allclose(neutral.eigenvalues, [[2.0, -2.0]], atol=1e-8)
    assert len(points) < LIMIT


def test_a_pair_that_comes_to_be_slowest_and_where_it_is_no_longer_reached() -> None:
    """With eigenvalues s +- i beside 1 and -3: a pair comes first at s = -3, the saddle is neutral at -1, a Hopf point at 0."""
    connections, leaf = leaves((Z, W), (S * Z - W, Z + S * W), "s", {"a": -1.0}, -4.0)
    walk = connections.walk(leaf)
    points = list(walk)
    special = [(c.kind, float(c.parameter_values[1])) for c in points if c.kind]
    assert special == [("three-leading", pytest.approx(-3.0, abs=1e-8)), ("neutral-saddle", pytest.approx(-1.0, abs=1e-8))]
    assert walk.end == HOPF and -0.51 < points[-1].parameter_values[1] < 0 and len(points) < LIMIT


def test_a_second_direction_in_which_a_saddle_is_left() -> None:
    """With an eigenvalue s beside 1 and -3. Where two real ones are the same, nothing becomes complex."""
    connections, leaf = leaves((Z,), (S * Z,), "s", {"a": -1.0}, -4.0)
    walk = connections.walk(leaf)
    points = list(walk)
    assert [c.kind for c in points if c.kind] == ["neutral-saddle"]
    assert walk.end == LEFT_TWICE and -0.51 < points[-1].parameter_values[1] < 0 and len(points) < LIMIT


def circuit(time: float) -> tuple[Connections, Connection]:
    """From the homoclinic orbit at be = 0.6 on."""
    connections = Connections.of(CIR, ("nu", "be"), {"r": 0.6, "ga": 0.0}, ((-1.5, -0.5), (-0.1, 1.5)), time)
    return connections, connection_from_excursion(connections, np.zeros(3), (-0.72, 0.6))


@lru_cache(maxsize=3)
def both_ways(time: float) -> dict[str, tuple[Connection, ...]]:
    """The connections of both halves of the curve, by how these end."""
    connections, orbit = circuit(time)
    walks = [connections.walk(start) for start in (orbit, connections.backwards(orbit))]
    points = [tuple(walk) for walk in walks]
    return {walk.end: half for walk, half in zip(walks, points, strict=True)}


def matrix(nu: float, be: float) -> np.ndarray:
    """The Jacobian at the origin, by hand."""
    return np.array([[-(be + nu) / 0.6, be / 0.6, 0.0], [be, -be, -1.0], [0.0, 1.0, 0.0]])


def characteristic(nu: float, be: float) -> np.ndarray:
    """Its coefficients 1, c2, c1, c0, by hand."""
    p, q = (be + nu) / 0.6, be**2 / 0.6
    return np.array([1.0, p + be, p * be + 1 - q, p])


@pytest.mark.slow
@pytest.mark.parametrize("time", [36.13, 60.0])
def test_the_circuits_curve_from_end_to_end(time: float) -> None:
    """A short time and a long one make no difference, and both ends are told.

    At 36.13, with which AUTO's demo begins, the curve went on beyond its first end, along orbits that end anywhere, for 1,015
    points: where the eigenvalues become small an orbit takes long to come near, and where the saddle has a second positive one
    any orbit from it meets the conditions.
    """
    halves = both_ways(time)
    assert set(halves) == {BOGDANOV_TAKENS, HOPF}
    assert sum(map(len, halves.values())) < LIMIT
    last = halves[BOGDANOV_TAKENS][-1]
    # Two eigenvalues vanish at c1 = c0 = 0: nu = -be, be^2 = r.
    np.testing.assert_allclose(last.parameter_values, [-np.sqrt(0.6), np.sqrt(0.6)], atol=1e-3)
    # An imaginary pair, c1 c2 = c0, at be = 0.
    assert 0 < halves[HOPF][-1].parameter_values[1] < 0.05
    for c in halves[BOGDANOV_TAKENS] + halves[HOPF]:
        by_hand = np.linalg.eigvals(matrix(*c.parameter_values))
        np.testing.assert_allclose(np.sort_complex(c.eigenvalues[0]), np.sort_complex(by_hand), atol=1e-6)


def special(time: float, kind: str) -> np.ndarray:
    (found,) = [c for half in both_ways(time).values() for c in half if c.kind == kind]
    return found.parameter_values


def test_the_circuits_neutral_saddle() -> None:
    """a, -a +- i w: the sum of all is -a = -c2, and a is a root."""
    nu, be = special(60.0, "neutral-saddle")
    leaving = characteristic(nu, be)[1]
    assert leaving == pytest.approx(0.3759, abs=1e-4)
    assert np.polyval(characteristic(nu, be), leaving) == pytest.approx(0.0, abs=1e-9)
    rates = np.sort(np.linalg.eigvals(matrix(nu, be)).real)
    assert rates[2] + rates[1] == pytest.approx(0.0, abs=1e-9)
    assert (nu, be) == (pytest.approx(-0.72039844, abs=1e-7), pytest.approx(0.59121455, abs=1e-7))


def test_where_the_circuits_saddle_becomes_a_focus() -> None:
    """The polynomial has a double root there: its discriminant vanishes."""
    nu, be = special(60.0, "saddle-focus")
    (c2, c1, c0), t = characteristic(nu, be)[1:], sp.Symbol("t")
    assert float(sp.discriminant(t**3 + c2 * t**2 + c1 * t + c0, t)) == pytest.approx(0.0, abs=1e-9)
    assert (nu, be) == (pytest.approx(-0.75905728, abs=1e-7), pytest.approx(0.74287097, abs=1e-7))


@pytest.mark.parametrize("kind", ["neutral-saddle", "saddle-focus"])
def test_special_points_by_shooting(kind: str) -> None:
    """SciPy: with nu 1e-8 less or more, the unstable manifold leaves again on different sides."""
    nu, be = special(60.0, kind)
    sides = [_side(nu + d, be) for d in (-1e-8, 1e-8)]
    assert sides[0] == -sides[1]


def _side(nu: float, be: float) -> float:
    """On which side of the origin the orbit that has left it, to the right, and returned leaves it again."""
    values, vectors = np.linalg.eig(matrix(nu, be))
    out = vectors[:, values.real.argmax()].real

    def rates(_: float, u: np.ndarray) -> list[float]:
        x, y, z = u
        cubic = 0.933578 * (y - x) ** 3
        return [(-(be + nu) * x + be * y - 0.328578 * x**3 + cubic) / 0.6, be * (x - y) - z - cubic, y]

    begin = 1e-6 * out / np.linalg.norm(out) * np.sign(out[0])
    away = 0.1  # once back within it, the next time that it is left
    run = solve_ivp(rates, (0, 400), begin, rtol=1e-12, atol=1e-18, method="DOP853", max_step=0.5)
    size = np.linalg.norm(run.y, axis=0)
    out_first = int((size > away).argmax())
    back = out_first + int((size[out_first:] < away / 3).argmax())
    again = back + int((size[back:] > away).argmax())
    return float(np.sign(run.y[0, again]))


def test_an_orbit_that_does_not_come_back_is_told() -> None:
    connections = Connections.of(CIR, ("nu",), {"be": 0.6, "r": 0.6, "ga": 0.0}, ((-1.0, -0.5),), 60.0)
    with failed("no-return"):
        connection_from_excursion(connections, np.zeros(3), [-0.8])
    with failed("no-saddle"):
        connection_from_excursion(connections, np.zeros(3), [-0.5])


@pytest.mark.slow
def test_a_curve_that_winds_up_at_a_point() -> None:
    """With ga = -0.6, be and ga of the torus-type system, one half of the curve comes to where the orbit turns ever more.

    There it was followed for 2,000 points. The other half has its neutral saddle after a few: c0 = p as before,
    c2 = p + be + ga, c1 = p (be + ga) + 1 - be^2/r.
    """
    connections = Connections.of(CIR, ("nu", "be"), {"r": 0.6, "ga": -0.6}, ((-1.5, -0.3), (0.05, 1.0)), 60.0)
    orbit = connection_from_excursion(connections, np.zeros(3), (-0.68, 0.6))
    walk = connections.walk(orbit)
    points = list(walk)
    first = next(c for c in points if c.kind)
    assert first.kind == "neutral-saddle" and walk.end == BOGDANOV_TAKENS and len(points) < LIMIT
    nu, be = first.parameter_values
    p = (be + nu) / 0.6
    leaving = p + be - 0.6
    assert np.polyval([1, leaving, p * (be - 0.6) + 1 - be**2 / 0.6, p], leaving) == pytest.approx(0.0, abs=1e-9)
    other = connections.walk(connections.backwards(orbit))
    points = list(other)
    assert other.end.startswith(STANDSTILL) and len(points) < 250
    assert "neutral-saddle" in {c.kind for c in points}
