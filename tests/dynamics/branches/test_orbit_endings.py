"""What belongs to the end of a branch of orbits, and by what evidence it is settled, on orbits as they might be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from wucht.dynamics.branches import orbit_endings
from wucht.dynamics.branches.first_orbits import SeedOrbit
from wucht.dynamics.branches.orbit_endings import branch_to_end, connection_time
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.errors import RunError
from wucht.files.user_system import UserSystem
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.numerics.periodic.periods import PERIOD
from wucht.system import System

X, Y, P = sp.symbols("x y p", real=True)
BOUNDS = (0.0, 1.0)


def test_the_time_in_which_both_ends_come_near_to_a_saddle() -> None:
    """exp(-5) at each: with rates 2 and -0.5, 5/2 and 10 more."""
    assert connection_time(7.0, np.array([-3.0, 2.0, -0.5])) == pytest.approx(7.0 + 2.5 + 10.0)


def test_the_places_where_an_orbit_is_slow() -> None:
    """x' = x at nodes of these speeds: least and slower than 0.3 of the fastest, round the orbit too, the slowest first."""
    equations = EquilibriumEquations.from_system(
        System((X,), (PERIOD * (X + 0 * P),), (PERIOD, P)), (PERIOD.name, "p"), {}, {"x": 2.0}
    )
    cycles: Any = SimpleNamespace(equations=equations)
    speeds = [0.6, 1.0, 5.0, 10.0, 1.5, 2.9, 0.5, 0.8, 9.0, 4.0, 8.0, 2.0, 1.0]
    cycle: Any = SimpleNamespace(states=np.array([[*speeds, 0.6]]), parameter=0.3, problem=SimpleNamespace(n=1))
    assert [float(place[0]) for place in orbit_endings._slow_places(cycles, cycle)] == [0.5, 0.6, 1.5]
    many: Any = SimpleNamespace(
        states=np.array([[v for k in range(6) for v in (9.0, 1 - 0.1 * k)] + [9.0]]),
        parameter=0.3,
        problem=SimpleNamespace(n=1),
    )
    assert [float(p[0]) for p in orbit_endings._slow_places(cycles, many)] == pytest.approx([0.5, 0.6, 0.7, 0.8])


@dataclass(frozen=True)
class Subject:
    path: str = "p"
    bounds: tuple[float, float] = BOUNDS
    width: float = 1.0


@dataclass
class Saddle:
    """At the origin, the connection found at a value."""

    unstable: int = 1
    at: float = 0.0
    value: float = 0.51
    leaving: float = 1.0
    fails: bool = False


def met(monkeypatch: pytest.MonkeyPatch, saddle: Saddle, stays: bool = False) -> Any:
    """Of an orbit at p = 0.5 that is 1 and 2 long, and slow at the origin."""
    found = SimpleNamespace(
        parameter_values=np.array([saddle.value]),
        equilibria=np.array([[0.1, 0.2]]),
        eigenvalues=np.array([[saddle.leaving + 0j, -2]]),
    )
    given = list[Any]()

    def connection_from_cycle(*given_: Any) -> Any:
        if saddle.fails:
            raise RunError("no connection")
        return found

    monkeypatch.setattr(orbit_endings, "connection_from_cycle", connection_from_cycle)
    monkeypatch.setattr(orbit_endings, "connections_of", lambda *rest: given.append(rest))
    equilibrium = SimpleNamespace(x=np.array([saddle.at, 0.0]), unstable=saddle.unstable, eigenvalues=np.array([1.0, -0.5]))
    motion: Any = SimpleNamespace(
        subject=Subject(), equilibria=SimpleNamespace(start=lambda *_: 0, evaluate=lambda _: equilibrium)
    )
    cycle: Any = SimpleNamespace(states=np.array([[0.0, 1.0], [0.0, 2.0]]), parameter=0.5, period=7.0)
    cycles: Any = SimpleNamespace(winding=np.array([1, 0]))
    made = orbit_endings._connection(motion, cycles, cycle, np.zeros(2), stays)
    if given:
        assert given[0][1:4] == (("p",), ((-1.0, 2.0),), pytest.approx(7.0 + 5.0 + 10.0))
    return None if made is None else (made[0], made[1].tolist())


def test_an_orbit_that_becomes_a_connection_of_the_saddle_it_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of one unstable direction, within 0.2 of its size and 0.02 of the range; else none, but where the parameter stays."""
    assert met(monkeypatch, Saddle()) == (0.51, [0.1, 0.2])
    for none in (
        Saddle(unstable=2),
        Saddle(unstable=0),
        Saddle(at=0.21),
        Saddle(value=0.521),
        Saddle(value=0.479),
        Saddle(leaving=-1.0),
    ):
        assert met(monkeypatch, none) is None
    assert met(monkeypatch, Saddle(at=0.19, value=0.481)) == (0.481, [0.1, 0.2])
    assert met(monkeypatch, Saddle(fails=True)) is None
    assert met(monkeypatch, Saddle(fails=True), stays=True) == (0.5, [0.0, 0.0])
    assert met(monkeypatch, Saddle(unstable=2, fails=True), stays=True) is None


def test_a_place_without_a_steady_state_is_no_saddle() -> None:
    def lost(*_: Any) -> None:
        raise RunError("none")

    motion: Any = SimpleNamespace(subject=Subject(), equilibria=SimpleNamespace(start=lost, evaluate=lost))
    nothing: Any = SimpleNamespace(parameter=0.5)
    assert orbit_endings._connection(motion, nothing, nothing, np.zeros(2), False) is None


@pytest.mark.parametrize(
    ("at", "x", "way", "ahead"),
    [
        (0.51, 0.0, 1, True), (0.49, 0.0, 1, False), (0.49, 0.0, -1, True), (0.51, 0.0, -1, False), (0.521, 0.0, 1, False),
        (0.51, 0.19, 1, True), (0.51, 0.21, 1, False),
    ],
)  # fmt: skip
def test_the_fold_ahead(monkeypatch: pytest.MonkeyPatch, at: float, x: float, way: int, ahead: bool) -> None:
    """On the way on which the parameter changes, within 0.02 of the range, and within 0.2 of the orbit's size."""
    monkeypatch.setattr(orbit_endings, "fold_at", lambda _e, _x, values: (np.array([x, 0.0]), np.array([at])))
    motion: Any = SimpleNamespace(subject=Subject(), equilibria=SimpleNamespace(equations=None))
    cycle: Any = SimpleNamespace(states=np.array([[0.0, 1.0], [0.0, 2.0]]), parameter=0.5)
    found = orbit_endings._fold_ahead(motion, cycle, np.zeros(2), way)
    assert (found is not None) == ahead
    if found is not None:
        assert (found[0].tolist(), found[1]) == ([x, 0.0], at)


def motion_of(system: System, bounds: tuple[float, float]) -> Any:
    of = UserSystem(system, {"p": 1.0}, "equations")
    return SimpleNamespace(subject=OrbitProblem.of(of, "p", bounds))


CIRCLE = System((X, Y), ((P - X**2 - Y**2) * X - Y, (P - X**2 - Y**2) * Y + X), (P,))


def test_whether_the_motion_goes_on_beyond_a_fold() -> None:
    """r' = r (p - r^2): a run turns on at p = 0.25, and settles at -0.25. It is not looked at outside the range."""
    angle = np.linspace(0, 2 * np.pi, 41)
    cycle: Any = SimpleNamespace(states=np.array([np.cos(angle), np.sin(angle)]), period=2 * np.pi)
    motion, place = motion_of(CIRCLE, (-0.5, 0.5)), np.array([1.0, 0.0])
    survives = orbit_endings._survives
    assert survives(motion, cycle, place, 0.25) and not survives(motion, cycle, place, -0.25)
    assert not survives(motion, cycle, place, 0.5) and not survives(motion, cycle, place, 0.6)


def test_that_run_begins_away_from_the_fold() -> None:
    """r' = r (p + 2 r^2 - r^4), p = -0.5: from r = 1.2, the place farthest from the fold, it turns on; from 0.1 it settles."""
    square = X**2 + Y**2
    growth = P + 2 * square - square**2
    system = System((X, Y), (growth * X - Y, growth * Y + X), (P,))
    motion = motion_of(system, (-1.0, 1.0))
    cycle: Any = SimpleNamespace(states=np.array([[0.0, 1.2, 0.1], [0.5, 0.1, -0.1]]), period=2 * np.pi)
    assert orbit_endings._survives(motion, cycle, np.array([0.1, 0.0]), -0.5)
    assert not orbit_endings._survives(motion, cycle, np.array([1.2, 0.1]), -0.5)


@dataclass(frozen=True)
class Orbit:
    parameter: float
    period: float
    kind: str = ""


def end_of(
    monkeypatch: pytest.MonkeyPatch, orbits: list[Orbit], *, met: Any = None, fold: float | None = None, survives: bool = False,
    way: int = 1,
) -> tuple[str, float, float, list[float]]:  # fmt: skip
    """Kind and value of the end, the last orbit's period, and the periods at which an end was looked for."""
    start, *others = orbits
    backwards, looked = replace(start), list[float]()

    class Walk:
        end = "it is lost"

        def __iter__(self) -> Any:
            return iter(others)

    cycles = SimpleNamespace(
        walk=lambda first: Walk() if first is (start if way > 0 else backwards) else 1 / 0, backwards=lambda _: backwards
    )

    def slow_places(_: Any, cycle: Orbit) -> list[int]:
        looked.append(cycle.period)
        return [1, 2]

    def ahead(_m: Any, cycle: Orbit, place: int, way_: int) -> Any:
        assert way_ == way
        return (np.array([place]), fold) if fold is not None and place == 2 else None

    def branch_end(_: Any, values: np.ndarray, periods: np.ndarray, last: list[Orbit], why: str) -> Any:
        assert why == "it is lost" and len(last) == min(3, len(values)) and not any(o.kind for o in last)
        assert values.tolist() == [o.parameter for o in orbits if not o.kind][: len(values)]
        return SimpleNamespace(kind="other", parameter=float(values[-1]), sentence="", equilibrium=np.empty(0))

    monkeypatch.setattr(orbit_endings, "cycles_through", lambda *_, **__: (cycles, start))
    monkeypatch.setattr(orbit_endings, "_slow_places", slow_places)
    monkeypatch.setattr(orbit_endings, "_connection", lambda _m, _c, cycle, place, stays: met and met(cycle, place, stays))
    monkeypatch.setattr(orbit_endings, "_fold_ahead", ahead)
    monkeypatch.setattr(orbit_endings, "branch_end", branch_end)

    def survive(_m: Any, _c: Any, place: np.ndarray, value: float) -> bool:
        assert fold is not None and value == pytest.approx(fold + way * 1e-4) and place.tolist() == [2]
        return survives

    monkeypatch.setattr(orbit_endings, "_survives", survive)
    motion: Any = SimpleNamespace(subject=Subject())
    seed: Any = None
    monkeypatch.setattr(SeedOrbit, "from_cycle", lambda _cycles, last, _begun, both_ways: last)
    end = branch_to_end(motion, seed, way, lambda: None).end
    assert end.last is not None
    return end.kind, end.value, end.last.period, looked


def test_an_end_is_looked_for_where_the_period_has_grown(monkeypatch: pytest.MonkeyPatch) -> None:
    """To 2.5 times the least, then by a quarter more each time; special orbits do not count."""
    periods = [2.0, 1.0, 2.0, 2.6, 3.0, 3.2, 3.3, 4.2, 4.0, 5.5]
    orbits = [Orbit(0.1 * k, period) for k, period in enumerate(periods)]
    orbits.insert(5, Orbit(0.45, 50.0, "fold"))
    assert end_of(monkeypatch, orbits) == ("other", 0.9, 5.5, [2.6, 3.3, 4.2, 5.5])


def test_the_first_saddle_that_it_runs_into_is_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    orbits = [Orbit(0.1 * k, period) for k, period in enumerate([1.0, 2.6, 4.0, 6.0])]
    met = lambda cycle, place, stays: (0.77, np.zeros(1)) if cycle.period == 4.0 and place == 2 and not stays else None  # noqa: E731
    assert end_of(monkeypatch, orbits, met=met) == (SADDLE_CONNECTION, 0.77, 4.0, [2.6, 4.0])
    assert end_of(monkeypatch, orbits, met=met, way=-1)[0] == SADDLE_CONNECTION


def test_a_parameter_that_stays_while_the_period_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nine times: then an end is looked for at once, and if there is none it is not followed on."""
    still = [Orbit(0.5, 1.0 + 0.01 * k) for k in range(12)]
    assert end_of(monkeypatch, still) == ("other", 0.5, pytest.approx(1.09), pytest.approx([1.09]))
    met = lambda cycle, place, stays: (0.5, np.zeros(1)) if stays else None  # noqa: E731
    assert end_of(monkeypatch, still, met=met)[:2] == (SADDLE_CONNECTION, 0.5)
    twice = [Orbit(0.5 + 0.1 * (k > 6), 1.0 + 0.01 * k) for k in range(15)]
    assert end_of(monkeypatch, twice)[3] == []
    shrinking = [Orbit(0.5, 1.0 - 0.01 * k) for k in range(12)]
    assert end_of(monkeypatch, shrinking)[3] == []
    moving = [Orbit(0.5 + 2e-10 * k, 1.0 + 0.01 * k) for k in range(12)]
    assert end_of(monkeypatch, moving)[3] == []


def law(factor: list[float], periods: list[float], fold: float = 0.9) -> list[Orbit]:
    """Orbits of these periods, factor/sqrt(fold - p)."""
    return [Orbit(0.2, 1.0), *[Orbit(fold - (c / t) ** 2, t) for c, t in zip(factor, periods, strict=True)]]


def test_a_period_that_grows_as_at_a_saddle_node_is_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """T sqrt|p - p*| the same within 2 %, at more than four times the least period, if the motion is gone beyond p*."""
    orbits = law([0.5, 0.5, 0.5, 0.5], [3.0, 3.9, 5.0, 7.0])
    assert end_of(monkeypatch, orbits, fold=0.9) == (SADDLE_NODE_ON_ORBIT, 0.9, 5.0, [3.0, 3.9, 5.0])
    assert end_of(monkeypatch, orbits, fold=0.9, survives=True)[0] == "other"
    drifting = law([0.5, 0.515, 0.531, 0.547], [3.0, 3.9, 5.0, 7.0])
    found = end_of(monkeypatch, drifting, fold=0.9)  # by 3 %: only at its last orbit, roughly
    assert found == (SADDLE_NODE_ON_ORBIT, 0.9, 7.0, [3.0, 3.9, 5.0, 7.0])
    assert end_of(monkeypatch, drifting, fold=0.9, survives=True)[0] == "other"
    coarse = law([0.5, 0.62, 0.77, 0.95], [3.0, 3.9, 5.0, 7.0])
    assert end_of(monkeypatch, coarse, fold=0.9)[0] == "other"
    short = law([0.5, 0.5], [3.0, 3.9])
    assert end_of(monkeypatch, short, fold=0.9)[2] == 3.9


def test_a_fold_that_is_met_but_once_is_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """The parameter stays, and it is not known how the period grows towards the fold."""
    still = [Orbit(0.5, 1.0 + 0.01 * k) for k in range(12)]
    assert end_of(monkeypatch, still, fold=0.51)[:2] == ("other", 0.5)


def test_how_far_a_saddle_or_a_fold_is_from_where_an_orbit_is_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the slow place, wherever that lies, in units of the orbit's extent 1 and 2."""
    slow = np.array([3.0, -5.0])
    cycle: Any = SimpleNamespace(states=slow[:, None] + [[0.0, 1.0], [0.0, 2.0]], parameter=0.5, period=7.0)
    motion: Any = SimpleNamespace(subject=Subject(), equilibria=SimpleNamespace(equations=None))
    for away, near in (([0.19, 0.0], True), ([0.21, 0.0], False), ([0.0, 0.39], True), ([0.0, 0.41], False)):
        monkeypatch.setattr(orbit_endings, "fold_at", lambda *_, x=slow + away: (x, np.array([0.51])))
        assert (orbit_endings._fold_ahead(motion, cycle, slow, 1) is not None) is near


def test_the_time_of_a_connection_allows_for_both_ends() -> None:
    """Five e-folds of the leaving and of the slowest reaching disturbance, in whatever order they are given."""
    values = np.array([-9.0, 0.5, -0.25 + 3j, -0.25 - 3j])
    assert orbit_endings.connection_time(7.0, values) == pytest.approx(7.0 + 5.0 * (1 / 0.5 + 1 / 0.25))


def test_places_where_an_orbit_is_slow_the_slowest_first() -> None:
    """Minima of the speed, in units of scale, below 0.3 of the largest; four at most; around the end of the period too."""
    speed = np.array([0.5, 9.0, 2.0, 9.0, 1.0, 9.0, 2.9, 9.0, 10.0, 1.5, 9.0, 2.5, 9.0, 3.1])

    def values(points: np.ndarray) -> Any:
        assert points.shape == (4, 14) and (points[2:] == [[1.0], [0.25]]).all()
        return np.array([2 * speed, 0 * speed]), None

    cycles: Any = SimpleNamespace(equations=SimpleNamespace(values=values, scale=np.array([2.0, 5.0, 1.0, 1.0])))
    states = np.array([np.arange(15.0), np.zeros(15)])
    cycle: Any = SimpleNamespace(states=states, parameter=0.25, problem=SimpleNamespace(n=2))
    assert [x[0] for x in orbit_endings._slow_places(cycles, cycle)] == [0.0, 4.0, 9.0, 2.0]
    speed[:] = [0.5, 9.0, 3.01, 9.0, 1.0, 9.0, 2.9, 9.0, 10.0, 9.5, 9.0, 9.1, 9.0, 0.4]
    assert [x[0] for x in orbit_endings._slow_places(cycles, cycle)] == [13.0, 4.0, 6.0]
