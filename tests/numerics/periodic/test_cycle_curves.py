from __future__ import annotations

import math

import numpy as np
import pytest
from tests.refusals import rejected

from known_orbits import BAUTIN, EVEN, MOEBIUS, PITCHFORK, PLANE, SPACE, TORUS_BIRTH, W, X, Y, Z, placed
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


def test_period_doublings_and_broken_symmetries_lie_on_their_parabola() -> None:
    samples = placed(EVEN, WAVE | {Z: 0 * TAU})
    for point in (points := curve("branch-point", PITCHFORK, samples, math.pi, -0.3)):
        p, q = point.parameter_values
        assert p == pytest.approx(q**2, abs=1e-8) and abs(point.extra[1]) < 1e-8
        np.testing.assert_allclose(point.states[2], 0, atol=1e-9)
    assert {p.parameter_values[1] for p in points} >= {-0.7, 0.9}
    samples = placed(SPACE, WAVE | {Z: 0 * TAU, W: 0 * TAU})
    for point in curve("period-doubling", MOEBIUS, samples, math.pi, -0.3, frequency=0.0):
        p, q = point.parameter_values
        assert p == pytest.approx(q**2, abs=1e-8) and point.period == pytest.approx(math.pi, abs=1e-8)


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
