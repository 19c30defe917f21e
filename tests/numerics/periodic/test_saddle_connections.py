"""Connections against one known in closed form, against integration, and curves of two folds at once in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.errors import RunError
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.fold_curves import FoldPairs
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.periodic import saddle_connections
from wucht.numerics.periodic.connection import Connection
from wucht.numerics.periodic.saddle_connections import Connections
from wucht.system import System

X, Y, A, B, P, Q, R = sp.symbols("x y a b p q r", real=True)
# B. Sandstede's planar example: at a = 0 the leaf x^2 (1 - x) = y^2 is a homoclinic orbit of the origin, whose eigenvalues are
# 1 and -3; the term with b vanishes on it, so that the curve in (a, b) is a = 0. Yu. A. Kuznetsov, "Elements of Applied
# Bifurcation Theory", Springer 2004, example 6.1.
LEAF = X**2 * (1 - X) - Y**2
SYSTEM = System((X, Y), (-X + 2 * Y + X**2, (2 - A) * X - Y - 3 * X**2 + sp.Rational(3, 2) * X * Y + B * LEAF), (A, B))
TIME = 30.0


def _leaf() -> tuple[np.ndarray, np.ndarray]:
    """Times and states of the orbit, by integration from near the origin, where it leaves along (1, 1)."""
    times = np.linspace(0.0, TIME, 3001)
    states = integrate(compile_system(SYSTEM, 1e-13), [1e-6, 1e-6], SYSTEM.values({"a": 0.0, "b": 0.0}), times).states
    away = np.hypot(*states)
    last = 1500 + int(away[1500:].argmin()) if away[1500:].min() < 0.2 else len(times) - 1
    return times[: last + 1], states[:, : last + 1]


@pytest.fixture(scope="module")
def found() -> tuple[Connections, Connection]:
    times, states = _leaf()
    bounds = ((-0.5, 0.5), (-0.3, 0.3))
    connections = Connections.of(SYSTEM, ("a", "b"), {}, bounds, float(times[-1]))
    # Samples with an error of 1e-2, and a wrong parameter.
    return connections, connections.start(times, states * 1.01, np.zeros((1, 2)), (0.02, 0.0))


def test_the_leaf_is_found(found: tuple[Connections, Connection]) -> None:
    _, leaf = found
    assert leaf.parameter_values[0] == pytest.approx(0.0, abs=1e-7)
    x, y = leaf.states
    np.testing.assert_allclose(x**2 * (1 - x), y**2, atol=2e-6)
    np.testing.assert_allclose(leaf.eigenvalues[0], [1.0, -3.0], rtol=1e-6)
    assert leaf.saddle_quantity == pytest.approx(-2.0, rel=1e-6)
    assert leaf.states[0].max() == pytest.approx(1.0, abs=1e-3)


def test_the_curve_is_straight_and_ends_at_the_bounds(found: tuple[Connections, Connection]) -> None:
    connections, leaf = found
    walk = connections.walk(leaf)
    points = list(walk)
    assert "it leaves the range" in walk.end
    np.testing.assert_allclose([c.parameter_values[0] for c in points], 0.0, atol=1e-6)
    assert abs(points[-1].parameter_values[1]) == pytest.approx(0.3)
    assert connections.backwards(leaf).point.tangent[-1] == -leaf.point.tangent[-1]


def test_the_number_of_parameters_has_to_fit() -> None:
    with rejected("count"):
        Connections.of(SYSTEM, ("a", "b"), {}, ((0, 1), (0, 1)), 10.0, folds=(True, True))


def test_two_folds_at_once_in_closed_form() -> None:
    """x' = p + r x + q x^2 - x^4 has folds at x = +-sqrt(q/2) with the same p, -q^2/4, where r = 0."""
    system = System((X,), (P + R * X + Q * X**2 - X**4,), (P, R, Q))
    pairs = FoldPairs(EquilibriumEquations.from_system(system, ("p", "r", "q"), {}), ((-5.0, 5.0), (-1.0, 1.0), (0.2, 3.0)))
    unknowns = pairs.nearest_pair(np.array([0.6]), np.array([-0.8]), np.array([-0.3, 0.1, 1.0]))
    walk = pairs.walk(unknowns)
    last = [p.unknowns for _, p in walk][-1]
    assert walk.end == "it leaves the range at 3"
    np.testing.assert_allclose(last, [np.sqrt(1.5), -np.sqrt(1.5), -2.25, 0.0, 3.0], atol=1e-8)
    with rejected("count"):
        FoldPairs(EquilibriumEquations.from_system(system, ("p",), {"r": 0.0, "q": 1.0}), ((-5.0, 5.0),))


def test_folds_that_do_not_coincide_anywhere() -> None:
    """x' = p - x^2 has one fold alone; of p + x^3 - 3 x, at p = 2 and -2, no parameter changes that."""

    def pairs(rate: sp.Expr) -> FoldPairs:
        return FoldPairs(
            EquilibriumEquations.from_system(System((X,), (rate + 0 * R,), (P, R)), ("p", "r"), {}), ((-1.0, 1.0), (-1.0, 1.0))
        )

    with pytest.raises(RunError, match="both folds are the same point"):
        pairs(P - X**2).nearest_pair(np.array([0.3]), np.array([-0.2]), np.array([0.1, 0.0]))
    with pytest.raises(RunError, match="does not converge to a point at which both folds coincide"):
        pairs(P + X**3 - 3 * X).nearest_pair(np.array([1.1]), np.array([-0.9]), np.array([0.1, 0.0]))


@pytest.mark.parametrize(("ends", "near"), [((1.1, 0.0), False), ((0.0, 1.1), False), ((0.9, 0.9), True)])
def test_an_orbit_whose_ends_are_far_is_followed_longer(
    found: tuple[Connections, Connection], monkeypatch: pytest.MonkeyPatch, ends: tuple[float, float], near: bool
) -> None:
    """Either end, in terms of the largest distance that is allowed, though its time is long enough."""
    connections, leaf = found
    connections = replace(connections, time=leaf.time, longest=1e3)
    far = saddle_connections._FAR
    monkeypatch.setattr(saddle_connections, "end_distances", lambda *_: (ends[0] * far, ends[1] * far))
    asked = list[int]()
    monkeypatch.setattr(saddle_connections, "missing_times", lambda *_: asked.append(1) or np.zeros(2))
    assert connections.prolong(leaf) is leaf and (asked == []) is near


def test_a_curve_has_as_many_points_as_are_asked_for(found: tuple[Connections, Connection]) -> None:
    connections, leaf = found
    walk = replace(connections, steps=replace(connections.steps, points=2)).walk(leaf)
    assert len(list(walk)) == 2 and walk.end == "it has reached the largest number of points, 2"
