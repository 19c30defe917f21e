"""How a motion around a homoclinic leaf ends: at a saddle where mu < 0, at a saddle-node where mu > 0; the curve between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import wucht
from known_connections import LOOP
from wucht.dynamics.branches import ending_map, orbit_endings
from wucht.dynamics.branches.ending_curves import RETURNS
from wucht.dynamics.branches.ending_map import (
    EndingFindings,
    map_endings,
    unexplained_changes,
)
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.orbit_endings import NO_MOTION, OrbitEnd, OrbitEnding, ending_at
from wucht.dynamics.branches.plane_regions import PlaneCurve, PlanePoint
from wucht.dynamics.work import Work
from wucht.errors import RunError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT

RANGES = {"x": (-0.6, 1.4), "y": (-1.0, 1.0)}
EQUATIONS = wucht.UserSystem(LOOP, {"p": 0.0, "mu": 0.0, "b": 0.0})
PATHS, PLANE_RANGES = ("p", "mu", "b"), ((-0.4, 0.4), (-0.06, 0.06), (-0.3, 0.3))


def case() -> EndingMapCase:
    return EndingMapCase.of(EQUATIONS, PATHS, PLANE_RANGES, 2, ranges_of_states=RANGES)


class Names:
    """Notes the names of units, and what is reported."""

    def __init__(self) -> None:
        self.units, self.reports = list[str](), list[tuple[float, str]]()

    def unit(self, name: str, compute: Callable[[], Any]) -> Any:
        self.units.append(name)
        return compute()

    def knows(self, name: str) -> bool:
        return False

    def keep(self, name: str, outcome: Any) -> None:
        pass

    @property
    def work(self) -> Work:
        return Work(self, lambda share, what: self.reports.append((share, what)))


@cache
def mapped() -> tuple[list[EndingFindings], Names]:
    names = Names()
    return list(map_endings(case(), names.work)), names


def fold_of(mu: float, b: float) -> float:
    """c at the saddle-node near the origin: f = 0 and det f' = 0, by Newton's method from there."""
    x, y, c = (1 / 4 * -mu, 1 / 4 * -mu, 0.0)
    for _ in range(30):

        def f(u: np.ndarray) -> np.ndarray:
            x, y, c = u
            fx = np.array([[-2 + 4 * x, 2], [2 - 6 * x + 3 * y + b * (2 * x - 3 * x**2), -2 + mu + 3 * x - 2 * b * y]])
            leaf = x**2 * (1 - x) - y**2
            first = c - 2 * x + 2 * y + 2 * x**2
            return np.array([first, 2 * x + (-2 + mu) * y - 3 * x**2 + 3 * x * y + b * leaf, np.linalg.det(fx)])

        u = np.array([x, y, c])
        slopes = np.array([(f(u + h) - f(u - h)) / 2e-6 for h in 1e-6 * np.eye(3)]).T
        x, y, c = u - np.linalg.solve(slopes, f(u))
    return float(c)


@pytest.mark.slow
def test_the_motions_end_at_a_saddle_or_at_a_saddle_node() -> None:
    """Row by row; begun at the one saddle-node, over p, and ended at the other or beyond it."""
    places = mapped()[0][-1].places
    assert [(round(p.x, 9), round(p.y, 9)) for p in places] == [(-0.03, -0.15), (0.03, -0.15), (-0.03, 0.15), (0.03, 0.15)]
    assert [p.kind for p in places] == [SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT] * 2
    for p in places:
        begin = (0.05 - fold_of(p.x, p.y)) ** 0.5
        assert p.begins == pytest.approx(-begin, abs=1e-9)
        assert p.end.last is not None
        if p.kind == SADDLE_NODE_ON_ORBIT:
            assert p.end.value == pytest.approx(begin, abs=1e-9)
            assert p.end.sentence == f"at p = {p.end.value:.7g} steady states appear on the orbit, a saddle-node"
        else:
            assert begin + 0.01 < p.end.value < begin + 0.015
            assert p.end.sentence == f"at p = {p.end.value:.7g} the orbit runs into a saddle"


def test_where_it_runs_into_a_saddle_by_shooting() -> None:
    """A little less or more of p: the orbit that leaves the saddle returns on the one side of it, or on the other."""
    from scipy.integrate import solve_ivp

    place = mapped()[0][-1].places[0]
    mu, b = place.x, place.y

    def rates(_: float, u: np.ndarray, c: float) -> tuple[float, float]:
        x, y = u
        leaf = x**2 * (1 - x) - y**2
        return c - 2 * x + 2 * y + 2 * x**2, 2 * x + (-2 + mu) * y - 3 * x**2 + 3 * x * y + b * leaf

    ways = []
    for p in (place.end.value - 1e-5, place.end.value + 1e-5):
        c, x = 0.05 - p**2, place.end.equilibrium
        for _ in range(20):
            fx = np.array([
                [-2 + 4 * x[0], 2],
                [2 - 6 * x[0] + 3 * x[1] + b * (2 * x[0] - 3 * x[0] ** 2), -2 + mu + 3 * x[0] - 2 * b * x[1]],
            ])  # fmt: skip
            x = x - np.linalg.solve(fx, np.array(rates(0.0, x, c)))
        values, vectors = np.linalg.eig(fx)
        assert values.min() < 0 < values.max()
        out = vectors[:, values.argmax()] * np.sign(vectors[0, values.argmax()])
        run = solve_ivp(rates, (0, 200), x + 1e-4 * out, args=(c,), rtol=1e-10, atol=1e-12)
        away = run.y[0] - x[0]
        k = int(away.argmax())
        ways.append(away[k:].min() < -0.02)  # past the saddle, down to the other side of it
    assert ways[0] != ways[1]


def test_the_curve_on_which_the_orbit_returns_to_the_saddle_node() -> None:
    """mu = 0, p^2 = 1/20 for each b, cut at the edges of the plane."""
    (curve,) = mapped()[0][-1].curves
    assert curve.kind == RETURNS and mapped()[0][-1].points == ()
    np.testing.assert_allclose(curve.x, 0.0, atol=1e-9)
    np.testing.assert_allclose(curve.value, 0.05**0.5, atol=1e-9)
    assert sorted(curve.y[[0, -1]]) == pytest.approx([-0.3, 0.3], abs=1e-12)
    assert (np.diff(curve.y) > 0).all() or (np.diff(curve.y) < 0).all()


def test_stages_and_names_of_units() -> None:
    """What is there is handed out place by place; one curve explains both rows, and each region has a place."""
    stages, names = mapped()
    assert [(len(s.places), len(s.curves), s.complete) for s in stages] == [
        (1, 0, False), (2, 0, False), (3, 0, False), (4, 0, False), (4, 1, False), (4, 1, True)
    ]  # fmt: skip
    assert names.units[:2] == [f"place {x!r} {y!r}" for x, y in [(s.places[-1].x, s.places[-1].y) for s in stages[:2]]]
    (curves,) = names.units[4:]
    first, second = stages[-1].places[:2]
    assert curves in {f"curves {a.x!r} {a.y!r} {b.x!r} {b.y!r}" for a, b in ((first, second), stages[-1].places[2:])}
    shares = [share for share, _ in names.reports]
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert names.reports[0] == (0.0, "mu = -0.03, b = -0.15")
    begun = [s for s, what in names.reports if what == "mu = 0.03, b = 0.15"]
    assert begun == pytest.approx([0.7 * 3 / 4] * len(begun)) and begun
    assert unexplained_changes(case(), stages[-1]) == [] and len(unexplained_changes(case(), stages[3])) == 2


def there(bounds: tuple[float, float]) -> ModulatedMotion:
    """At mu = 0.03, b = 0.15, with p within other bounds."""
    motion = case().motion.with_values({"mu": 0.03, "b": 0.15})
    return replace(motion, subject=replace(motion.subject, bounds=bounds))


def test_a_place_at_which_no_stable_state_is_lost() -> None:
    """Between the folds, at p = -0.2234 and 0.2234, there are none."""
    found = ending_at(there((-0.2, 0.2)), (0.03, 0.15), lambda: None)
    assert (found.x, found.y, found.kind) == (0.03, 0.15, NO_MOTION) and np.isnan(found.begins)
    assert found.end.sentence == "no stable state is lost in the range of p"


def test_a_motion_that_begins_as_the_parameter_falls_is_followed_down() -> None:
    found = ending_at(there((0.15, 0.4)), (0.03, 0.15), lambda: None)
    assert found.begins == pytest.approx((0.05 - fold_of(0.03, 0.15)) ** 0.5, abs=1e-9)
    assert (found.kind, found.end.value, found.end.sentence) == ("range", 0.15, "the range ends at p = 0.15")


FOLDS = [(SimpleNamespace(parameter=p), 1) for p in (-1.0, 0.1, 0.2)]


def ending(monkeypatch: pytest.MonkeyPatch, born: list[Any], end: Any) -> OrbitEnding:
    """At a place with folds at -1 (the range's end), 0.1 and 0.2; born: what there is beyond those within."""
    monkeypatch.setattr(orbit_endings, "lost_states", lambda _: FOLDS)
    orbits = iter(born)

    def orbit_beyond_loss(_: Any, __: Any, ___: int, sentences: list[str], ____: Any) -> Any:
        sentences.append("it settles")
        return next(orbits)

    monkeypatch.setattr(orbit_endings, "orbit_beyond_loss", orbit_beyond_loss)
    monkeypatch.setattr(orbit_endings, "branch_to_end", end)
    motion: Any = SimpleNamespace(steady_branches=lambda: (), subject=SimpleNamespace(path="p", bounds=(-1.0, 1.0)))
    return ending_at(motion, (3.0, 4.0), lambda: None)


def test_the_first_motion_that_can_be_followed_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    def end(_: Any, seed: Any, way: int, watch: Any) -> Any:
        if seed == "short":
            raise RunError("lost on its way")
        return SimpleNamespace(end=OrbitEnd("kind", 0.9, f"{seed} {way}"))

    found = ending(monkeypatch, ["short", "long"], end)
    assert (found.begins, found.end.kind, found.end.value, found.end.sentence) == (0.2, "kind", 0.9, "long 1")
    assert (found.x, found.y) == (3.0, 4.0)
    none = ending(monkeypatch, [None, "short"], end)
    assert (none.kind, none.begins, none.end.sentence) == (NO_MOTION, 0.1, "it settles; lost on its way")


def test_a_run_begins_just_beyond_a_fold_and_nearer_if_that_is_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 0.01 and 0.002 of the range, on the side on which the state is gone, for 50 times its fastest decay."""
    tried: list[tuple[float, float]] = []

    def near(_: Any, value: float, state: Any, watch: Any, span: Any) -> Any:
        tried.append((value, span(state)))
        return SimpleNamespace(orbit=None, sentence=f"nothing at {value:g}")

    monkeypatch.setattr(orbit_endings, "orbit_near", near)
    motion: Any = SimpleNamespace(subject=SimpleNamespace(bounds=(0.0, 1.0)))
    sentences = list[str]()
    for value, way in ((0.5, 1), (0.5, -1), (0.995, 1)):
        fold: Any = SimpleNamespace(parameter=value, x=np.zeros(2), eigenvalues=np.array([-2.0, 1e-9]), kind="fold")
        assert orbit_endings.orbit_beyond_loss(motion, fold, way, sentences, lambda: None) is None
    assert tried == [(pytest.approx(v), 25.0) for v in (0.51, 0.502, 0.49, 0.498, 0.997)]
    assert sentences[-1] == "nothing at 0.997"


def straight(x: float, low: float = -2.0, high: float = 2.0) -> PlaneCurve:
    y = np.linspace(low, high, 5)
    return PlaneCurve(RETURNS, np.full(5, x), y, 0 * y)


def at(x: float, y: float, kind: str) -> OrbitEnding:
    return OrbitEnding(x, y, 0.0, OrbitEnd(kind, 0.0, ""))


def test_a_curve_crosses_the_way_between_two_places() -> None:
    a, b = (0.0, 0.0), (1.0, 0.5)
    assert straight(0.5).passes_between(a, b) and straight(0.5).passes_between(b, a)
    assert not straight(1.5).passes_between(a, b) and not straight(-0.5).passes_between(a, b)
    assert not straight(0.5, 0.4, 2.0).passes_between(a, b)


Parts = tuple[PlaneCurve | PlanePoint | str, ...]


def square(cells: int) -> EndingMapCase:
    """A plane of x, y from -1.5 to 1.5."""
    nothing: Any = SimpleNamespace()
    return EndingMapCase(("p", "x", "y"), ((0.0, 1.0), (-1.5, 1.5), (-1.5, 1.5)), nothing, cells, nothing)


def planned(
    monkeypatch: pytest.MonkeyPatch, kinds: list[str], made: Callable[[OrbitEnding, OrbitEnding], Parts], cells: int
) -> list[EndingFindings]:
    """Stages of a map of x, y from -1.5 to 1.5, of so many cells a side, whose places end as is given, row by row."""
    todo = iter(kinds)
    monkeypatch.setattr(ending_map, "_place", lambda _, __, place, ___: at(*place, next(todo)))
    monkeypatch.setattr(ending_map, "curves_between", lambda _case, connected, other, _report: made(connected, other))
    return list(map_endings(square(cells), Work()))


S, N = SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT


def test_curves_begin_next_to_the_middle_and_three_times_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[tuple[OrbitEnding, OrbitEnding]]()

    def made(connected: OrbitEnding, other: OrbitEnding) -> Parts:
        asked.append((connected, other))
        return (f"lost {len(asked)}",)

    stages = planned(monkeypatch, [S, N, S, S, S, N, N, N, S], made, 3)
    assert all((a.kind, b.kind) == (S, N) for a, b in asked)
    assert {frozenset(((a.x, a.y), (b.x, b.y))) for a, b in asked} <= {
        frozenset(pair) for pair in (((0.0, 0.0), (0.0, -1.0)), ((0.0, 0.0), (1.0, 0.0)), ((0.0, 0.0), (0.0, 1.0)))
    }
    assert len(asked) == 3 and stages[-1].omissions == ("lost 1", "lost 2", "lost 3")


def test_what_a_known_curve_explains_is_not_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """And a region without a place gets one: between the curve at 0.5 and another one at 0.9."""
    point = PlanePoint("meets", 0.5, 0.0, 0.1)
    calls = list[float]()

    def made(connected: OrbitEnding, other: OrbitEnding) -> Parts:
        calls.append(connected.y)
        more = PlaneCurve("other", np.full(2, 0.9), np.array([-2.0, 2.0]), np.zeros(2))
        return straight(0.5), more, point, "a sentence"

    stages = planned(monkeypatch, [N, N, S, N, N, S, N, N, S, "third"], made, 3)
    assert calls == [0.0]
    assert [len(s.places) for s in stages] == [*range(1, 10), 9, 10, 10]
    last = stages[-1]
    assert last.complete and last.points == (point,) and last.omissions == ("a sentence",) and len(last.curves) == 2
    extra = last.places[-1]
    assert extra.kind == "third" and 0.5 < extra.x < 0.9 and extra.x == pytest.approx(0.7, abs=0.02)


def test_changes_between_rows_count_up_to_the_last_column() -> None:
    """Of three columns and rows, the place in the last column of the middle row ends in another way than its neighbours."""
    mapped = square(3)
    places = tuple(at(*c, S if c == (1.0, 0.0) else N) for c in mapped.centres)
    pairs = unexplained_changes(mapped, EndingFindings(places))
    assert {((a.x, a.y), (b.x, b.y)) for a, b in pairs} == {
        ((1.0, -1.0), (1.0, 0.0)), ((0.0, 0.0), (1.0, 0.0)), ((1.0, 0.0), (1.0, 1.0)),
    }  # fmt: skip
    beside = unexplained_changes(mapped, EndingFindings(places, (straight(0.5),)))
    assert beside == [(a, b) for a, b in pairs if a.x == b.x], "a curve beside the last column explains the change within a row"


def test_a_curve_explains_only_what_it_passes_between(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second pair is asked too, as the first curve ends before it; a curve of another kind explains nothing."""
    asked = list[float]()

    def made(connected: OrbitEnding, other: OrbitEnding) -> Parts:
        asked.append(connected.y)
        return straight(0.0, connected.y - 0.3, connected.y + 0.3), replace(straight(0.0), kind="another")

    planned(monkeypatch, [S, N, S, N, *["further"] * 9], made, 2)
    assert sorted(asked) == [-0.75, 0.75]


def test_steady_states_are_those_in_the_middle_of_the_plane() -> None:
    """Of the second parameter, over the first; what modulates them depends on the third."""
    given = list[Any]()

    class Observed(wucht.UserSystem):
        """Equations that note the values that they are asked for."""

        def with_values(self, values: Any) -> wucht.UserSystem:
            given.append(values)
            return super().with_values(values)

    equations = Observed(EQUATIONS.system, EQUATIONS.values, EQUATIONS.title)
    EndingMapCase.of(equations, PATHS, ((-0.4, 0.4), (-0.06, 0.06), (0.1, 0.3)), 2, ranges_of_states=RANGES)
    assert given == [{"b": pytest.approx(0.2)}]


def test_a_place_that_fails_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> None:
        raise RunError("the run fails")

    monkeypatch.setattr(ending_map, "ending_at", fails)
    found = ending_map._ending(case(), (0.03, 0.15), partial(print))
    assert (found.x, found.y, found.kind, found.end.sentence) == (0.03, 0.15, "failed", "the run fails")
    assert np.isnan([found.begins, found.end.value]).all()
