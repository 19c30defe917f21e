"""Where the end of a branch of orbits, or a special orbit on it, is not what it seems: nothing is claimed then."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from known_orbits import BAUTIN, PLANE, X, Y, placed
from wucht.errors import RunError
from wucht.numerics.periodic import branch_ends, cycles, hopf_ends
from wucht.numerics.periodic.branch_ends import _fold, _saddles, _slow_places
from wucht.numerics.periodic.cycle import BRANCH_POINT, FOLD, TORUS, Cycle
from wucht.numerics.periodic.cycle_starts import cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.hopf_ends import hopf_point
from wucht.system import System

TAU = np.linspace(0, 1, 41)


@cache
def beside_the_fold() -> tuple[Cycles, Cycle, Cycle]:
    """Two neighbours on both sides of the fold p = -1/4 of r^2 = 1/2 +- sqrt(1/4 + p)."""
    of = Cycles.of(BAUTIN, "p", {"q": 1.0, "speed": 1.0}, (-1.0, 0.5))
    wave = {X: np.cos(2 * np.pi * TAU), Y: np.sin(2 * np.pi * TAU)}
    first = cycle_near(of, 2 * np.pi / 1.25 * TAU, placed(PLANE, wave), 0.0)
    start = first if first.point.tangent[-1] < 0 else of.backwards(first)
    before = start
    for orbit in of.walk(start):
        if orbit.kind:
            continue
        if orbit.point.tangent[-1] > 0:
            return of, before, orbit
        before = orbit
    raise AssertionError


def between(kind: str) -> list[Cycle]:
    of, here, there = beside_the_fold()
    return of._special_between(there.curve, here, there, kind)


def test_the_fold_between_two_neighbours() -> None:
    (fold,) = between(FOLD)
    assert (fold.kind, fold.parameter) == (FOLD, pytest.approx(-0.25, abs=1e-9))


def test_without_a_better_mesh_a_fold_is_not_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another special orbit is looked for on the mesh that there is."""
    _, here, there = beside_the_fold()
    seen = list[Any]()

    def lost(*_: Any) -> None:
        raise RunError("singular")

    def located(curve: Any, first: Any, last: Any, *_: Any) -> None:
        seen.append((curve is there.curve, np.array_equal(last.unknowns, there.point.unknowns)))

    monkeypatch.setattr(cycles, "refine_on_common_mesh", lost)
    monkeypatch.setattr(cycles, "locate_zero", located)
    assert between(FOLD) == []
    monkeypatch.setitem(cycles.TESTS, TORUS, lambda c: c.point.tangent[-1])  # type: ignore[arg-type]
    (hidden,) = between(TORUS)
    assert hidden.kind == "unresolved" and seen == [(True, True)]
    assert hidden.hidden_point == (TORUS, (here.parameter, there.parameter))


@pytest.mark.parametrize("kind", [FOLD, BRANCH_POINT])
def test_where_the_parameter_does_not_change_nothing_is_passed(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    _, _, there = beside_the_fold()
    tangent = np.append(there.point.tangent[:-1], 1e-12)
    still = SimpleNamespace(tangent=tangent, unknowns=there.point.unknowns)
    monkeypatch.setattr(cycles, "refine_on_common_mesh", lambda *_: (there.curve, there.point, still))
    assert between(kind) == []


def test_where_a_better_mesh_shows_no_change_of_sign_nothing_is_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    """But for one side that is all but zero there."""
    _, here, there = beside_the_fold()
    for values, count in (((1.0, 0.06), 0), ((-0.06, -1.0), 0), ((1.0, 0.04), 1)):
        given = iter(values)
        monkeypatch.setitem(cycles.TESTS, TORUS, lambda _, given=given: next(given))  # type: ignore[arg-type, misc]
        assert len(between(TORUS)) == count
    monkeypatch.setattr(cycles, "locate_zero", lambda *_: None)
    far = SimpleNamespace(
        **{n: getattr(here, n) for n in ("point_on", "basis", "parameter")}, logarithms=np.array([-11.0 + 0j])
    )
    of: Any = beside_the_fold()[0]
    for logarithm, count in ((-11.0, 0), (-9.0, 1)):
        at = SimpleNamespace(problem=there.problem, point=there.point, parameter=0.0, logarithms=np.array([logarithm + 0j]))
        given = iter((1.0, -1.0))
        monkeypatch.setitem(cycles.TESTS, TORUS, lambda _, given=given: next(given))  # type: ignore[arg-type, misc]
        monkeypatch.setattr(cycles, "replace", lambda given, **_: given)
        assert len(of._special_between(there.curve, far, at, TORUS)) == count


def shrinking(*squares: float, period: float = 2 * np.pi, mean: float = 0.0, shift: float = 0.0) -> list[Any]:
    """Orbits of x, y around (mean, 0) whose parameters are the squares of their radii, shifted."""
    angle = 2 * np.pi * np.arange(8) / 8
    shares = np.full(8, 1 / 8)
    return [
        SimpleNamespace(
            parameter=s + shift, period=period, states=np.array([mean + s**0.5 * np.cos(angle), s**0.5 * np.sin(angle)]),
            problem=SimpleNamespace(mesh=SimpleNamespace(shares=shares), sizes=np.ones(4)),
        )
        for s in squares
    ]  # fmt: skip


def test_the_hopf_point_at_which_orbits_end_that_shrink() -> None:
    """r^2 = p, T = 2 pi: at p = 0. Not of orbits that grow, turn at another rate, or shrink to another place."""
    p = sp.Symbol("p", real=True)
    growth = p - X**2 - Y**2
    of = Cycles.of(System((X, Y), (growth * X - Y, X + growth * Y), (p,)), "p", {}, (-1.0, 1.0)).equations
    found = hopf_point(of, shrinking(0.04, 0.01))
    assert found is not None and found.parameter == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(found.x, 0.0, atol=1e-9)
    alone = hopf_point(of, shrinking(0.01))
    assert alone is not None and alone.parameter == pytest.approx(0.0, abs=1e-9)
    assert hopf_point(of, shrinking(0.01, 0.04)) is None and hopf_point(of, shrinking(0.01, 0.012)) is None
    # Half the size of the last orbit but one, 0.2: so far from where their squares vanish.
    assert hopf_point(of, shrinking(0.04, 0.01, shift=0.095)) is not None
    assert hopf_point(of, shrinking(0.04, 0.01, shift=0.105)) is None
    assert hopf_point(of, shrinking(0.04, 0.01, period=2 * np.pi * 1.12)) is None
    assert hopf_point(of, shrinking(0.04, 0.01, period=2 * np.pi * 1.08)) is not None
    assert (
        hopf_point(of, shrinking(0.04, 0.01, mean=0.15)) is None
        and hopf_point(of, shrinking(0.04, 0.01, mean=0.05)) is not None
    )


def test_orbits_that_shrink_where_no_equilibrium_is_end_at_no_hopf_point(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*_: Any) -> None:
        raise RunError("no equilibrium")

    monkeypatch.setattr(
        hopf_ends, "equilibria_of", lambda _: SimpleNamespace(start=lost, equations=SimpleNamespace(scale=np.ones(3)))
    )
    of: Any = None
    assert hopf_point(of, shrinking(0.04, 0.01)) is None


def orbit_of(states: list[float], tau: list[float]) -> tuple[Any, Any]:
    """An orbit as it might be, by the speed at its nodes: x' = x."""
    equations = SimpleNamespace(values=lambda u: (u[:1], None), parameter_names=("T", "p"))
    here = SimpleNamespace(
        states=np.array([states]), tau=np.array(tau), parameter=0.5, problem=SimpleNamespace(sizes=np.ones(3))
    )
    return SimpleNamespace(equations=equations), here


def test_places_where_an_orbit_stays() -> None:
    """Slower than 0.05 of its fastest, for 0.05 of its period, in the order in which they are passed, round its begin too."""
    of, here = orbit_of([0.2, 9.0, 0.3, 9.0, 0.1, 0.4, 0.2], [0.0, 0.1, 0.2, 0.24, 0.3, 0.6, 1.0])
    assert [float(p[0]) for p in _slow_places(of, here)] == [0.1]
    of, here = orbit_of([0.2, 9.0, 0.3, 9.0, 0.1, 9.0, 0.2], [0.0, 0.1, 0.2, 0.34, 0.4, 0.9, 1.0])
    assert [float(p[0]) for p in _slow_places(of, here)] == [0.2, 0.3, 0.1]
    for states in ([1.0, 0.9, 0.8, 1.0], [1.0, 0.9, 0.5, 1.0]):  # nowhere so slow: the slowest place
        of, here = orbit_of(states, [0.0, 0.3, 0.6, 1.0])
        assert [float(p[0]) for p in _slow_places(of, here)] == [min(states)]


def test_of_two_places_none_is_a_fold_and_what_is_not_solved_is_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    of, here = orbit_of([0.2, 9.0, 0.2], [0.0, 0.5, 1.0])
    assert _fold(of, here, [np.zeros(1), np.ones(1)]) is None and _fold(of, here, []) is None

    def lost(*_: Any) -> None:
        raise RunError("none")

    equations = SimpleNamespace(scale=np.ones(2), values=lambda u: (u[:1], np.ones((1, 2))))
    problem = SimpleNamespace(equations=equations, curve=SimpleNamespace(start=lambda *_: 0), start=lost, evaluate=lost)
    monkeypatch.setattr(branch_ends, "equilibria_of", lambda _: problem)
    monkeypatch.setattr(branch_ends, "nearest_special", lost)
    assert _fold(of, here, [np.zeros(1)]) is None and _saddles(of, here, [np.zeros(1)], 0.5) == []
    for x, count in ((4.0, 1), (5.0, 0)):  # half the orbit's size, 8.8, is 4.4
        monkeypatch.setattr(branch_ends, "nearest_special", lambda *_, x=x: SimpleNamespace(x=np.array([x])))
        assert (_fold(of, here, [np.zeros(1)]) is not None) == bool(count)


@pytest.mark.parametrize(
    ("x", "passed", "count"), [(0.0, [1.0, -2.0, -3.0], 1), (5.0, [1.0, -2.0], 0), (0.0, [1.0, 2.0], 0), (0.0, [-1.0, -2.0], 0)]
)
def test_saddles_at_slow_places(monkeypatch: pytest.MonkeyPatch, x: float, passed: list[float], count: int) -> None:
    """Near to them, with directions that grow and that decay: the slowest of each; else none at all."""
    of, here = orbit_of([0.2, 9.0, 0.2], [0.0, 0.5, 1.0])
    point = SimpleNamespace(x=np.array([x]))
    problem = SimpleNamespace(start=lambda *_: 0, evaluate=lambda _: point)
    monkeypatch.setattr(branch_ends, "equilibria_of", lambda _: problem)
    monkeypatch.setattr(branch_ends, "_passage_rates", lambda *_: np.array(passed))
    found = _saddles(of, here, [np.zeros(1), np.zeros(1)], 0.5)
    assert len(found) == 2 * count
    if count:
        assert (found[0].growing, found[0].decaying) == (1.0, 2.0)
