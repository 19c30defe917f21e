"""Connections against one known in closed form, against integration, and curves of two folds at once in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

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
from wucht.numerics.periodic.connection import STANDSTILL, Connection
from wucht.numerics.periodic.saddle_connections import Connections, Directions
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


def test_a_single_connection_needs_one_parameter_less(found: tuple[Connections, Connection]) -> None:
    connections, leaf = found
    one = Connections.of(SYSTEM, ("a",), {"b": 0.1}, ((-0.5, 0.5),), connections.time)
    times = leaf.tau * leaf.time
    again = one.start(times, leaf.states, leaf.equilibria, (0.01,))
    assert again.parameter_values[0] == pytest.approx(0.0, abs=1e-7)


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


def test_a_curve_has_as_many_points_as_are_asked_for(found: tuple[Connections, Connection]) -> None:
    connections, leaf = found
    walk = replace(connections, steps=replace(connections.steps, points=2)).walk(leaf)
    assert len(list(walk)) == 2 and walk.end == "it has reached the largest number of points, 2"


def test_a_curve_on_which_the_parameters_stand(found: tuple[Connections, Connection], monkeypatch: pytest.MonkeyPatch) -> None:
    """At one point after another, twenty; a point at which they move begins the count anew."""
    connections, leaf = found
    stand = iter([True, False, *[True] * 30])
    monkeypatch.setattr(saddle_connections, "is_standstill", lambda *_: next(stand))
    fine = replace(connections, steps=replace(connections.steps, first=1e-3, most=1e-3))
    walk = fine.walk(replace(leaf, curve=replace(leaf.curve, steps=fine.steps)))
    points = list(walk)
    assert len(points) == 22 and walk.end.startswith(STANDSTILL)
    a, b = points[-1].parameter_values
    assert walk.end == f"{STANDSTILL}, a = {a:.7g}, b = {b:.7g}"


def test_an_orbit_that_cannot_be_followed_longer_stays_as_it_is(
    found: tuple[Connections, Connection], monkeypatch: pytest.MonkeyPatch
) -> None:
    connections, leaf = found
    later = replace(connections, time=leaf.time + 10.0)
    assert later.prolong(leaf).time == pytest.approx(leaf.time + 10.0, abs=1e-6)
    assert replace(later, longest=leaf.time + 4.0).prolong(leaf).time == pytest.approx(leaf.time + 4.0)
    assert replace(later, longest=leaf.time).prolong(leaf) is leaf
    assert replace(later, folds=(True,)).prolong(leaf) is leaf
    # A saddle that is not left: nothing says how much longer.
    assert later.prolong(replace(leaf, eigenvalues=np.array([[-1.0, -3.0]]))).time == leaf.time

    def lost(*_: Any) -> None:
        raise RunError("no orbit")

    monkeypatch.setattr(saddle_connections, "solve_near", lost)
    assert later.prolong(leaf) is leaf


def test_special_points_that_are_not_located_are_unresolved(
    found: tuple[Connections, Connection], monkeypatch: pytest.MonkeyPatch
) -> None:
    connections, leaf = found
    other = replace(leaf, eigenvalues=np.array([[3.5, -3.0]]))
    monkeypatch.setattr(saddle_connections, "refine_on_common_mesh", lambda *_: (leaf.curve, leaf.point, leaf.point))
    monkeypatch.setattr(saddle_connections, "locate_zero", lambda *_: None)
    (special,) = connections._special(leaf, other)
    assert special.kind == "unresolved" and special.point is other.point
    assert connections._special(leaf, leaf) == [] and replace(connections, folds=(True,))._special(leaf, other) == []
    assert replace(connections, folds=(False, False))._special(leaf, other) == []

    def lost(*_: Any) -> None:
        raise RunError("singular")

    monkeypatch.setattr(saddle_connections, "refine_on_common_mesh", lost)
    assert [c.kind for c in connections._special(leaf, other)] == ["unresolved"]


@pytest.mark.parametrize(
    ("time", "change", "prolonged"),
    [
        (30.0, {}, True), (40.0, {}, False), (30.0, {"longest": 30.0}, False), (30.0, {"longest": 30.1}, True),
        (30.0, {"folds": (True,)}, False),
    ],
)  # fmt: skip
def test_where_an_orbit_is_followed_longer(
    found: tuple[Connections, Connection], monkeypatch: pytest.MonkeyPatch, time: float, change: dict[str, Any], prolonged: bool
) -> None:
    """Where its ends are far from its saddle or its time is short, up to a longest one; never that of a saddle-node."""
    connections, leaf = replace(found[0], **({"time": 40.0, "longest": 1e3} | change)), replace(found[1], time=time)
    asked = list[Any]()

    def lengthened(connection: Connection, more: np.ndarray, *_: Any) -> Any:
        asked.append(more)
        raise RunError("enough")

    monkeypatch.setattr(saddle_connections, "end_distances", lambda *_: (1e-9, 1e-9))
    monkeypatch.setattr(saddle_connections, "missing_times", lambda *_: np.array([300.0, 100.0]))
    monkeypatch.setattr(saddle_connections, "lengthen_orbit", lengthened)
    if prolonged:
        with pytest.raises(RunError, match="enough"):
            connections.prolong(leaf)
        room = 90.0 if connections.longest == 1e3 else 0.1  # up to four times as long, or to the longest one
        assert asked[0] == pytest.approx(room * np.array([0.75, 0.25]))
    else:
        assert connections.prolong(leaf) is leaf


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


def test_directions_of_a_saddle_are_those_of_its_own_units() -> None:
    """Its left eigenvector, and rows normal to the right one, whatever the sizes; each normalised by a state."""
    vectors = np.array([[1.0, 1.0, 0.0], [0.5, -1.0, 2.0], [2.0, 0.0, 1.0]])
    jacobian = vectors @ np.diag([0.7, -1.0, -3.0]) @ np.linalg.inv(vectors)
    left, right = np.linalg.inv(vectors)[0], vectors[:, 0]
    for scale in (np.ones(3), np.array([2.0, 50.0, 0.3])):
        found = Directions.from_jacobian(jacobian, scale)
        assert found.by_right == int(np.abs(right / scale).argmax()) and found.by_left == int(np.abs(left * scale).argmax())
        assert found.leaving / found.leaving[0] == pytest.approx(left / left[0])
        assert found.leaving[found.by_left] * scale[found.by_left] == pytest.approx(1.0)
        assert found.complement @ right == pytest.approx(np.zeros(2), abs=1e-12)
        assert np.linalg.matrix_rank(found.complement * scale) == 2
        by = (found.by_right + 1) % 3, (found.by_left + 1) % 3
        other = Directions.from_jacobian(jacobian, scale, by)
        assert (other.by_right, other.by_left) == by
        assert other.leaving[by[1]] * scale[by[1]] == pytest.approx(1.0)
    with pytest.raises(RunError, match="more than one unstable direction"):
        Directions.from_jacobian(np.array([[0.1, 1.0], [-1.0, 0.1]]), np.ones(2))


def test_a_state_without_part_in_the_leaving_direction_normalises_nothing() -> None:
    """Saddles of a diagonal matrix: the other state has no part in either eigenvector."""
    jacobian = np.diag([0.7, -1.0])
    for by in ((1, 0), (0, 1)):
        with np.errstate(all="raise"):
            directions = Directions.from_jacobian(jacobian, np.ones(2), by)
        assert not (np.isfinite(directions.leaving).all() and np.isfinite(directions.complement).all())
