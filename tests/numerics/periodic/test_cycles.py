from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest
import sympy as sp
from tests.refusals import rejected

from known_orbits import (
    BAUTIN,
    EVEN,
    HOPF_TO_HOPF,
    ISOLA,
    MOEBIUS,
    PITCHFORK,
    PLANE,
    SPACE,
    SQUARE,
    TORUS_BIRTH,
    P,
    W,
    X,
    Y,
    Z,
    placed,
    planar,
)
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations
from wucht.numerics.continuation.equilibria import Equilibrium, EquilibriumContinuation
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import crossing_branch, cycle_at_hopf, cycle_near, doubled_branch
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.orbit_prediction import predicted_orbit
from wucht.system import System

TAU = np.linspace(0, 1, 41)
WAVE = {X: np.cos(2 * np.pi * TAU), Y: np.sin(2 * np.pi * TAU)}
NONE = {Z: 0 * TAU, W: 0 * TAU}


def on_circle(cycles: Cycles, period: float, value: float, radius: float = 1.0) -> Cycle:
    """The planar orbit of a radius."""
    return cycle_near(cycles, period * TAU, placed(PLANE, {s: radius * v for s, v in WAVE.items()}), value)


def special(points: Sequence[Cycle]) -> list[tuple[str, float]]:
    return [(p.kind, p.parameter) for p in points if p.kind]


def four(
    system: System, *, value: float = -0.3, bounds: tuple[float, float] = (-0.5, 0.5), **more: float
) -> tuple[Cycles, Cycle]:
    cycles = Cycles.of(system, "p", {"q": 0.5, "speed": 2.0} | more, bounds)
    return cycles, cycle_near(cycles, math.pi * TAU, placed(SPACE, WAVE | NONE), value)


def rising(cycles: Cycles, cycle: Cycle) -> Cycle:
    return cycle if cycle.point.tangent[-1] > 0 else cycles.backwards(cycle)


def hopf(system: System, parameter: str, fixed: dict[str, float], bounds: tuple[float, float], at: float) -> Equilibrium:
    equilibria = EquilibriumContinuation(EquilibriumEquations.from_system(system, [parameter], fixed), bounds)
    branch = equilibria.follow_branch(equilibria.start(np.zeros(len(system.states)), at))
    return next(p for p in branch.special if p.kind == "hopf")


def test_folds_of_a_generalised_hopf_point() -> None:
    """Orbits r^2 = q/2 +- sqrt(q^2/4 + p), T = 2 pi/(speed + r^2/4): the fold, both branches, their multipliers."""
    cycles = Cycles.of(BAUTIN, "p", {"q": 1.0, "speed": 1.0}, (-1.0, 0.5))
    points = list(cycles.walk(cycles.backwards(rising(cycles, on_circle(cycles, 2 * math.pi / 1.25, 0.0)))))
    assert special(points) == [("fold", pytest.approx(-0.25, abs=1e-12))]
    for p in points[:-1]:
        # Of a branch given by r the parameter is p = r^4 - r^2; dr'/dr = 2 r^2 - 4 r^4 is the exponent.
        square = (2 * math.pi / p.period - 1) * 4
        assert p.parameter == pytest.approx(square**2 - square, abs=1e-7)
        assert p.logarithms[0].real == pytest.approx(p.period * (2 * square - 4 * square**2), abs=1e-5)


def test_from_hopf_to_hopf_the_branch_ends_and_is_not_retraced() -> None:
    """r^2 = 1 - p^2 and T = 2 pi: the amplitude grows as a square root."""
    fixed = {"speed": 1.0}
    cycles = Cycles.of(HOPF_TO_HOPF, "p", fixed, (-3.0, 3.0))
    begin = hopf(HOPF_TO_HOPF, "p", fixed, (-2.0, 0.0), -2.0)
    assert begin.parameter == pytest.approx(-1.0, abs=1e-10)
    first = cycle_at_hopf(cycles, begin)
    walk = cycles.walk(first)
    points = [first, *walk]
    assert walk.end == "it shrinks to an equilibrium: a Hopf point"
    assert not special(points)
    values = np.array([p.parameter for p in points])
    assert (np.diff(values) > 0).all() and values[-1] == pytest.approx(1.0, abs=1e-3)
    for p in points:
        np.testing.assert_allclose(_radius_squared(p), 1 - p.parameter**2, atol=2e-7)
        assert p.period == pytest.approx(2 * math.pi, abs=1e-7)


def _radius_squared(p: Cycle) -> np.ndarray:
    """Of the states, put back into straight coordinates: of ``PLANE`` the last change first."""
    x, y = p.states
    y = y - x**2 / 10
    return (x - y**2 / 5) ** 2 + y**2


def test_the_equilibrium_beyond_a_hopf_point_is_no_orbit() -> None:
    """r^2 = p from 0.1 down: with long steps Newton's method finds the equilibrium, which satisfies the same equations."""
    system = planar(P - SQUARE, P)
    for most in (0.05, 0.2, 0.5):
        cycles = Cycles.of(system, "p", {"speed": 1.0}, (-0.04, 0.11), steps=Steps(most=most, turn=1.0, corrections=6))
        first = on_circle(cycles, 2 * math.pi, 0.1, math.sqrt(0.1))
        walk = cycles.walk(first if first.point.tangent[-1] < 0 else cycles.backwards(first))
        points = list(walk)
        assert walk.end == "it shrinks to an equilibrium: a Hopf point"
        assert all(np.ptp(p.states, axis=1).max() > 1e-3 for p in points) and points[-1].parameter > -1e-9


def test_an_isola_is_closed() -> None:
    """(r^2 - 1)^2 + p^2 = 0.3^2."""
    cycles = Cycles.of(ISOLA, "p", {"speed": 1.0}, (-1.0, 1.0))
    walk = cycles.walk(on_circle(cycles, 2 * math.pi, 0.0, math.sqrt(1.3)))
    points = list(walk)
    assert walk.end == "it is closed"
    assert sorted(special(points)) == [("fold", pytest.approx(-0.3, abs=1e-11)), ("fold", pytest.approx(0.3, abs=1e-11))]


def test_a_torus_is_born_where_the_pair_crosses_the_circle() -> None:
    cycles, first = four(TORUS_BIRTH, frequency=math.sqrt(2))
    points = list(cycles.walk(rising(cycles, first)))
    assert special(points) == [("torus", pytest.approx(0.25, abs=1e-9))]
    assert [p.unstable for p in points if p.kind] == [0], "a pair on the circle is not outside of it"
    turned = math.sqrt(2) * math.pi - 2 * math.pi
    for p in points:
        T, grown = p.period, (p.parameter - 0.25) * p.period
        assert pytest.approx(math.pi, abs=1e-9) == T
        expected = np.sort_complex(np.array([grown + 1j * turned, grown - 1j * turned, -2 * T]))
        np.testing.assert_allclose(np.sort_complex(p.logarithms), expected, atol=2e-6)
        assert abs(p.along) < 1e-6


def test_the_period_doubles_on_a_moebius_band() -> None:
    """Multipliers -exp((p - q^2) T), -exp(-T), exp(-2 T); the doubled orbit has |z| = sqrt(p - q^2)."""
    cycles, first = four(MOEBIUS, frequency=0.0)
    points = list(cycles.walk(rising(cycles, first)))
    assert special(points) == [("period-doubling", pytest.approx(0.25, abs=1e-9))]
    assert [p.unstable for p in points if p.kind] == [0]
    p = points[-1]
    expected = np.array([(p.parameter - 0.25) * math.pi + 1j * math.pi, -math.pi + 1j * math.pi, -2 * math.pi])
    np.testing.assert_allclose(p.logarithms, expected, atol=1e-5)
    more, twice = doubled_branch(cycles, next(p for p in points if p.kind))
    branch = list(more.walk(rising(more, twice)))
    assert not special(branch)
    for cycle in branch[::5]:
        x, _, z, w = cycle.states
        np.testing.assert_allclose((z - x**2 / 5) ** 2 + w**2, cycle.parameter - 0.25, atol=1e-6)
        assert cycle.period == pytest.approx(2 * math.pi, abs=1e-8)
        assert (cycle.logarithms.real < 1e-6).all()


def test_a_symmetry_breaks_and_both_other_branches_are_found() -> None:
    cycles = Cycles.of(PITCHFORK, "p", {"q": 0.5, "speed": 2.0}, (-0.5, 0.6))
    samples = placed(EVEN, WAVE | {Z: 0 * TAU})
    points = list(cycles.walk(rising(cycles, cycle_near(cycles, math.pi * TAU, samples, -0.3))))
    assert special(points) == [("branch-point", pytest.approx(0.25, abs=1e-9))]
    signs = []
    for first in crossing_branch(cycles, next(p for p in points if p.kind)):
        branch = list(cycles.walk(first))
        assert branch[-1].parameter == 0.6 and not special(branch)
        for p in branch[::4]:
            np.testing.assert_allclose(p.states[2] ** 2, p.parameter - 0.25, atol=1e-6)
        signs.append(float(np.sign(branch[-1].states[2].mean())))
    assert sorted(signs) == [-1, 1]


def test_points_come_one_by_one_and_a_walk_that_is_left_breaks_nothing() -> None:
    cycles = Cycles.of(HOPF_TO_HOPF, "p", {"speed": 1.0}, (-0.5, 0.5))
    first = on_circle(cycles, 2 * math.pi, 0.0)
    walk = cycles.walk(first)
    three = list(itertools.islice(walk, 3))
    assert walk.end == "" and len(three) == 3
    rest = list(walk)
    again = list(cycles.walk(first))
    assert [p.parameter for p in again] == [p.parameter for p in (*three, *rest)]

    interrupted = cycles.walk(first)
    next(interrupted)
    with pytest.raises(KeyboardInterrupt):
        interrupted._points.throw(KeyboardInterrupt())
    assert [p.parameter for p in cycles.walk(first)] == [p.parameter for p in again]


def test_bounds_and_number_of_points_end_a_branch() -> None:
    cycles = Cycles.of(HOPF_TO_HOPF, "p", {"speed": 1.0}, (-0.5, 0.5), steps=Steps(points=3))
    walk = cycles.walk(on_circle(cycles, 2 * math.pi, 0.0))
    assert len(list(walk)) == 3 and walk.end == "it has reached the maximum number of points, 3"
    cycles = Cycles.of(BAUTIN, "p", {"q": 1.0, "speed": 1.0}, (-1.0, 9.0), periods=(4.0, 6.0))
    walk = cycles.walk(rising(cycles, on_circle(cycles, 2 * math.pi / 1.25, 0.0)))
    assert list(walk)[-1].period == 4.0 and walk.end == "it leaves the range at 4"


def test_bad_input_is_told() -> None:
    fixed = {"speed": 1.0}
    with rejected("no-angle", "x"):
        Cycles.of(ISOLA, "p", fixed, (-1, 1), winding={"x": 1})
    with rejected("order", "p"):
        Cycles.of(ISOLA, "p", fixed, (1, 1))
    with rejected("order"):
        Cycles.of(ISOLA, "p", fixed, (-1, 1), periods=(2, 1))
    with rejected("no-value"):
        Cycles.of(ISOLA, "p", {}, (-1, 1))
    with rejected("no-parameter"):
        Cycles.of(ISOLA, "r", fixed, (-1, 1))
    with rejected("time-dependent"):
        Cycles.of(System((X,), (sp.Symbol("t", real=True) - X,), ()), "p", {}, (-1, 1))


MESH = Mesh.even(60, 6)


def problem_of(system: System, winding: dict[str, int] | None = None) -> BoundaryValueProblem:
    return Cycles.of(system, "p", {}, (-1.0, 1.0), winding=winding).problem(MESH, 1.0)


def point(states: np.ndarray, change: np.ndarray, parameters: tuple[float, float], by: tuple[float, float]) -> CurvePoint:
    return CurvePoint(np.append(states.ravel(), parameters), np.append(change.ravel(), by), None, 0.0, 0)


def test_a_front_moves_as_far_as_the_tangent_says_and_keeps_its_shape() -> None:
    """A turn within a fiftieth of the period, moved by that width: along the tangent it would not be monotone any more."""
    problem = problem_of(System((X,), (P + sp.cos(X),), (P,), angles=frozenset({X})), {"x": 1})
    tau, width = MESH.nodes, 0.02

    def front(at: float) -> np.ndarray:
        return np.pi * (1 + np.tanh((tau - at) / width))[:, None]

    here, step = front(0.5), 0.01
    change = -MESH.slopes(here)  # by one unit of the curve's length the front moves by one period
    here[-1] = here[0] + 2 * np.pi
    unknowns = predicted_orbit(problem, point(here, change, (7.0, 0.1), (2.0, -1.0)), step)
    states, parameters = problem.split(unknowns)
    assert parameters == pytest.approx([7.02, 0.09], abs=1e-14)
    assert states[-1] - states[0] == pytest.approx(2 * np.pi, abs=1e-12)
    off, off_tangent = (float(np.abs(guess - front(0.51)).max()) for guess in (states, here + step * change))
    assert off < off_tangent / 5
