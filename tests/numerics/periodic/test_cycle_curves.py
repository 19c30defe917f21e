from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.refusals import rejected

from known_orbits import BAUTIN, EVEN, MOEBIUS, PITCHFORK, PLANE, SPACE, TORUS_BIRTH, W, X, Y, Z, placed
from wucht.numerics.collocation.boundary_values import Reference
from wucht.numerics.periodic import cycle_curves
from wucht.numerics.periodic.cycle_curves import CurveCycle, CycleCurve
from wucht.numerics.periodic.cycle_starts import cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.system import System

TAU = np.linspace(0, 1, 41)
WAVE = {X: np.cos(2 * np.pi * TAU), Y: np.sin(2 * np.pi * TAU)}
BOUNDS = ((-0.6, 0.9), (-0.7, 0.9))


def curve(kind: str, system: System, samples: np.ndarray, period: float, low: float, **more: float) -> list[CurveCycle]:
    """The whole curve in (p, q) through the first point of a kind at q = 0.5, from both sides of p = low."""
    fixed = {"speed": 2.0} | more
    cycles = Cycles.of(system, "p", fixed | {"q": 0.5}, (-0.6, 0.9))
    first = cycle_near(cycles, period * TAU, samples, low)
    at = next(p for start in (first, cycles.backwards(first)) for p in cycles.walk(start) if p.kind == kind)
    followed = CycleCurve.of(kind, system, ("p", "q"), fixed, BOUNDS)
    start = followed.start(at, 0.5)
    assert start.parameter_values == pytest.approx((at.parameter, 0.5), abs=1e-9)
    found = [start]
    for way in (start, followed.backwards(start)):
        walk = followed.walk(way)
        found += list(walk)
        assert walk.end.startswith("it leaves the range at")
    return found


@pytest.mark.slow
def test_folds_of_a_generalised_hopf_point() -> None:
    """p = -q^2/4 at r^2 = q/2, down to small orbits: T = 2 pi/(speed + r^2/4)."""
    fixed = {"speed": 2.0}
    cycles = Cycles.of(BAUTIN, "p", fixed | {"q": 0.5}, (-0.6, 0.9))
    samples = placed(PLANE, {s: math.sqrt(0.5) * v for s, v in WAVE.items()})
    first = cycle_near(cycles, 2 * math.pi / 2.125 * TAU, samples, 0.0)
    fold = next(p for start in (first, cycles.backwards(first)) for p in cycles.walk(start) if p.kind == "fold")
    followed = CycleCurve.of("fold", BAUTIN, ("p", "q"), fixed, ((-0.6, 0.9), (0.1, 0.9)))
    start = followed.start(fold, 0.5)
    for way in (start, followed.backwards(start)):
        points = list(followed.walk(way))
        assert points[-1].parameter_values[1] in (0.1, 0.9)
        for point in points:
            p, q = point.parameter_values
            assert p == pytest.approx(-(q**2) / 4, abs=1e-8)
            assert point.period == pytest.approx(2 * math.pi / (2 + q / 8), rel=1e-7)


def test_folds_end_at_the_generalised_hopf_point_and_are_not_retraced() -> None:
    """r^2 = q/2 shrinks to zero at q = 0."""
    cycles = Cycles.of(BAUTIN, "p", {"q": 0.5, "speed": 2.0}, (-0.6, 0.9))
    samples = placed(PLANE, {s: math.sqrt(0.5) * v for s, v in WAVE.items()})
    first = cycle_near(cycles, 2 * math.pi / 2.125 * TAU, samples, 0.0)
    fold = next(p for start in (first, cycles.backwards(first)) for p in cycles.walk(start) if p.kind == "fold")
    followed = CycleCurve.of("fold", BAUTIN, ("p", "q"), {"speed": 2.0}, ((-0.6, 0.9), (-0.9, 0.9)))
    start = followed.start(fold, 0.5)
    walks = [followed.walk(way) for way in (start, followed.backwards(start))]
    second = np.concatenate([[p.parameter_values[1] for p in walk] for walk in walks])
    assert "it shrinks to an equilibrium: a generalised Hopf point" in [walk.end for walk in walks]
    assert -1e-6 < second.min() < 0.05 and second.max() == 0.9


@pytest.mark.parametrize("name", [None, "p", "q"])
def test_an_orbit_of_a_curve_leads_back_to_its_branch(name: str | None) -> None:
    """Through a fold p = -q^2/4 both ways: orbits r^2 = q/2 +- sqrt(q^2/4 + p), by their periods 2 pi/(speed + r^2/4)."""
    fixed = {"speed": 2.0}
    cycles = Cycles.of(BAUTIN, "p", fixed | {"q": 0.5}, (-0.6, 0.9))
    samples = placed(PLANE, {s: math.sqrt(0.5) * v for s, v in WAVE.items()})
    first = cycle_near(cycles, 2 * math.pi / 2.125 * TAU, samples, 0.0)
    fold = next(p for start in (first, cycles.backwards(first)) for p in cycles.walk(start) if p.kind == "fold")
    followed = CycleCurve.of("fold", BAUTIN, ("p", "q"), fixed, ((-0.3, 0.3), (0.2, 0.8)))
    *_, on_curve = zip(followed.walk(followed.start(fold, 0.5)), range(3), strict=False)
    orbit = on_curve[0]
    branches, begin = followed.branch_through(orbit, name)
    assert branches.bounds == ((0.2, 0.8) if name == "q" else (-0.3, 0.3))
    assert begin.parameter == pytest.approx(orbit.parameter_values[name == "q"], abs=1e-9)
    assert begin.period == pytest.approx(orbit.period, rel=1e-9) and begin.point.tangent[-1] == pytest.approx(0.0, abs=1e-6)
    sides = set[int]()
    for way in (begin, branches.backwards(begin)):
        for there in list(branches.walk(way))[1:]:
            p, q = (orbit.parameter_values[0], there.parameter) if name == "q" else (there.parameter, orbit.parameter_values[1])
            square = 4 * (2 * math.pi / there.period - 2)
            assert (square - q / 2) ** 2 == pytest.approx(q**2 / 4 + p, abs=1e-7)
            sides.add(1 if square > q / 2 else -1)
    assert sides == {1, -1}
    with rejected("no-parameter", "speed"):
        followed.branch_through(orbit, "speed")


@pytest.mark.slow
def test_period_doublings_lie_on_their_parabola() -> None:
    samples = placed(SPACE, WAVE | {Z: 0 * TAU, W: 0 * TAU})
    points = curve("period-doubling", MOEBIUS, samples, math.pi, -0.3, frequency=0.0)
    assert {p.parameter_values[1] for p in points} >= {-0.7, 0.9}
    for point in points:
        p, q = point.parameter_values
        assert p == pytest.approx(q**2, abs=1e-8) and point.period == pytest.approx(math.pi, abs=1e-8)


@pytest.mark.slow
def test_births_of_a_torus_lie_on_their_parabola() -> None:
    """With the angle by which the pair turns in a period."""
    samples = placed(SPACE, WAVE | {Z: 0 * TAU, W: 0 * TAU})
    points = curve("torus", TORUS_BIRTH, samples, math.pi, -0.3, frequency=math.sqrt(2))
    assert {p.parameter_values[1] for p in points} >= {-0.7, 0.9}
    for point in points:
        p, q = point.parameter_values
        assert p == pytest.approx(q**2, abs=1e-8)
        assert math.cos(point.extra[0]) == pytest.approx(math.cos(math.sqrt(2) * math.pi), abs=1e-8)


def test_a_few_births_of_a_torus_beside_one_another() -> None:
    """p = q^2 from q = 0.5 to 0.6, with the angle sqrt(2) pi; the changes v turn by it and have the size 1."""
    samples = placed(SPACE, WAVE | {Z: 0 * TAU, W: 0 * TAU})
    fixed = {"speed": 2.0, "frequency": math.sqrt(2)}
    cycles = Cycles.of(TORUS_BIRTH, "p", fixed | {"q": 0.5}, (0.1, 0.4))
    first = cycle_near(cycles, math.pi * TAU, samples, 0.15)
    at = next(p for start in (first, cycles.backwards(first)) for p in cycles.walk(start) if p.kind == "torus")
    followed = CycleCurve.of("torus", TORUS_BIRTH, ("p", "q"), fixed, ((-0.6, 0.9), (0.4, 0.6)))
    walk = followed.walk(followed.start(at, 0.5))
    points = list(walk)
    assert walk.end == "it leaves the range at 0.6" and points[-1].parameter_values == pytest.approx((0.36, 0.6), abs=1e-8)
    for point in points:
        p, q = point.parameter_values
        assert p == pytest.approx(q**2, abs=1e-8) and point.period == pytest.approx(math.pi, abs=1e-8)
        (angle,) = point.extra
        assert math.cos(angle) == pytest.approx(math.cos(math.sqrt(2) * math.pi), abs=1e-8)
        y = point.problem.split(point.point.unknowns)[0]
        begin, end = (y[k, 4:8] + 1j * y[k, 8:] for k in (0, -1))
        np.testing.assert_allclose(end, np.exp(1j * angle) * begin, atol=1e-8)
        assert point.problem.mesh.shares @ (y[:, 4:] ** 2).sum(axis=1) == pytest.approx(1.0, abs=1e-6)


def test_the_change_of_the_conditions_of_a_torus_with_its_angle() -> None:
    """Against differences, v turning by 0.7."""
    ends, _ = cycle_curves._conditions("torus", 2, np.array([2 * np.pi, 0.0]), np.ones(11))
    first, last = np.arange(6.0), np.array([3.0, 1.0, 4.0, 1.0, 5.0, 9.0])
    given = np.array([4.0, 0.7, 0.1, 0.2])
    value, begin, end, by_parameters = ends(first, last, given)
    assert value[:2] == pytest.approx(last[:2] - first[:2] - [2 * np.pi, 0.0])
    assert value[2:4] + 1j * value[4:] == pytest.approx(
        last[2:4] + 1j * last[4:] - np.exp(0.7j) * (first[2:4] + 1j * first[4:])
    )
    for k in range(4):
        step = 1e-6 * np.eye(4)[k]
        slope = (ends(first, last, given + step)[0] - ends(first, last, given - step)[0]) / 2e-6
        np.testing.assert_allclose(by_parameters[:, k], slope, atol=1e-8)
    np.testing.assert_allclose(begin @ first + end @ last - [2 * np.pi, 0, 0, 0, 0, 0], value)


def test_a_torus_is_begun_with_the_pair_next_to_the_unit_circle(monkeypatch: pytest.MonkeyPatch) -> None:
    given = list[complex]()

    def wave(_: object, turn: complex) -> np.ndarray:
        given.append(turn)
        return np.array([[1 + 2j, 3 - 1j]])

    monkeypatch.setattr(cycle_curves, "propagated_change", wave)
    at: Any = SimpleNamespace(logarithms=np.array([-0.5 + 2j, -0.5 - 2j, 0.01 + 1j, 0.01 - 1j, 0.0]))
    changes, extra = cycle_curves._changes(at, "torus")
    assert extra == [1.0] and given == [pytest.approx(np.exp(1j))] and changes.tolist() == [[1.0, 3.0, 2.0, -1.0]]


def test_a_symmetry_that_is_lost_ends_the_curve_on_which_it_breaks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the added rate d is larger than 1e-3."""
    samples = placed(EVEN, WAVE | {Z: 0 * TAU})
    cycles = Cycles.of(PITCHFORK, "p", {"speed": 2.0, "q": 0.5}, (0.1, 0.4))
    first = cycle_near(cycles, math.pi * TAU, samples, 0.15)
    at = next(p for start in (first, cycles.backwards(first)) for p in cycles.walk(start) if p.kind == "branch-point")
    followed = CycleCurve.of("branch-point", PITCHFORK, ("p", "q"), {"speed": 2.0}, BOUNDS)
    start = followed.start(at, 0.5)
    strength = iter([0.9e-3, -0.9e-3, -1.1e-3])
    monkeypatch.setattr(CurveCycle, "extra", property(lambda _: [0.0, next(strength)]))
    walk = followed.walk(start)
    assert len(list(walk)) == 2 and walk.end == "the orbit loses the symmetry that was broken"


def test_broken_symmetries_lie_on_their_parabola() -> None:
    samples = placed(EVEN, WAVE | {Z: 0 * TAU})
    points = curve("branch-point", PITCHFORK, samples, math.pi, -0.3)
    assert {p.parameter_values[1] for p in points} >= {-0.7, 0.9}
    for point in points:
        p, q = point.parameter_values
        assert p == pytest.approx(q**2, abs=1e-8)
        np.testing.assert_allclose(point.states[2], 0, atol=1e-9)
        assert abs(point.extra[1]) < 1e-8


def test_bad_input_is_told() -> None:
    fixed = {"speed": 2.0}
    with rejected("unknown-kind"):
        CycleCurve.of("hopf", BAUTIN, ("p", "q"), fixed, BOUNDS)
    with rejected("given-twice", "p"):
        CycleCurve.of("fold", BAUTIN, ("p", "p"), fixed, BOUNDS)
    with rejected("order", "q"):
        CycleCurve.of("fold", BAUTIN, ("p", "q"), fixed, ((0, 1), (1, 0)))
    with rejected("no-value"):
        CycleCurve.of("fold", BAUTIN, ("p", "q"), {}, BOUNDS)
    with rejected("no-angle", "x"):
        CycleCurve.of("fold", BAUTIN, ("p", "q"), fixed, BOUNDS, winding={"x": 1})


@pytest.mark.parametrize("kind", ["fold", "period-doubling"])
def test_the_integrals_are_taken_in_terms_of_the_sizes(kind: str) -> None:
    """Of a state of two: int (y - y_ref).y_ref' = 0 and int v.v (+ (c/T)^2) = 1, each by the square of its size."""
    sizes = np.array([2.0, 10.0, 2.0, 10.0, 7.0, 7.0, 1.0, 1.0])
    _, integrand = cycle_curves._conditions(kind, 2, np.zeros(2), sizes)
    y, reference = np.array([[3.0], [5.0], [4.0], [20.0]]), np.array([[1.0], [1.0], [0.0], [0.0]])
    slope = np.array([[8.0], [50.0], [0.0], [0.0]])
    rows, by_states, _ = integrand(y, np.array([7.0, 3.5, 0.0, 0.0]), Reference(reference, slope))
    across = (3.0 - 1.0) * 8.0 / 2**2 + (5.0 - 1.0) * 50.0 / 10**2
    square = (4.0 / 2) ** 2 + (20.0 / 10) ** 2 - 1 + (0.5**2 if kind == "fold" else 0.0)
    assert rows[:2, 0] == pytest.approx([across, square])
    assert by_states[:2, :, 0] == pytest.approx(np.array([[2.0, 0.5, 0.0, 0.0], [0.0, 0.0, 2.0, 0.4]]))


@pytest.mark.parametrize(
    ("kind", "columns", "q"), [("fold", 1, 4), ("period-doubling", 1, 3), ("torus", 2, 4), ("branch-point", 1, 5)]
)
def test_the_changes_of_the_integrals_are_those_of_differences(kind: str, columns: int, q: int) -> None:
    n = 2 * (1 + columns)
    rng = np.random.default_rng(0)
    sizes = rng.uniform(1.0, 3.0, n + q)
    _, integrand = cycle_curves._conditions(kind, 2, np.zeros(2), sizes)
    reference = Reference(rng.normal(size=(n, 3)), rng.normal(size=(n, 3)))
    y, parameters = rng.normal(size=(n, 3)), rng.normal(size=q)
    rows, by_states, by_parameters = integrand(y, parameters, reference)
    assert rows.shape == (q - 1, 3)
    for k in range(n):
        h = 1e-6 * np.eye(n)[k][:, None]
        up, down = (integrand(y + s * h, parameters, reference)[0] for s in (1, -1))
        np.testing.assert_allclose(by_states[:, k], (up - down) / 2e-6, atol=1e-8)
    for k in range(q):
        h = 1e-6 * np.eye(q)[k]
        up, down = (integrand(y, parameters + s * h, reference)[0] for s in (1, -1))
        np.testing.assert_allclose(by_parameters[:, k], (up - down) / 2e-6, atol=1e-8)
