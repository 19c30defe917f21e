"""Ends and special orbits of branches are what they are said to be: peers' numbers, closed forms, integrated multipliers.

Peers: E. J. Doedel et al., AUTO-07P manual, 2007 (demos plp, tor, ab), continued to the digits given with their equations.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy as sp
from tests.refusals import rejected

from auto_demos import AB, PLP, TOR
from known_orbits import P, X, Y, Z, planar
from wucht.numerics.continuation.curve import CURVE_IS_CLOSED, Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.periodic.branch_ends import BranchEnd, branch_end
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import crossing_branch, cycle_at, cycle_at_hopf, cycle_near, cycles_with
from wucht.numerics.periodic.cycles import STEPS, Cycles
from wucht.numerics.periodic.floquet import integrated_maps, logarithms, transverse_maps
from wucht.numerics.periodic.hopf_ends import VANISHES
from wucht.numerics.recurrence import recurrence
from wucht.system import System

FOLDS_OF_PLP = [2.9862948102, 4.7221252364]
V, A, B, FORCE = sp.symbols("v a b force", real=True)
DUFFING = System((X, V, A, B), (V, -V / 5 - X**3 + FORCE * A, A - B - A * (A**2 + B**2), A + B - B * (A**2 + B**2)), (FORCE,))
"""x'' + 0.2 x' + x^3 = force cos t, as an autonomous System: symmetric under -(x, v, a, b)."""


def settled_on(cycles: Cycles, system: System, values: dict[str, float], state: list[float], time: float) -> Cycle:
    """The orbit on which a run settles."""
    compiled, parameters = compile_system(system, 1e-11), system.values(values)
    run = integrate(compiled, np.array(state), parameters, np.linspace(0, time, 20001)).reraise_interrupt()
    repeats = recurrence(run.time, run.states, np.zeros(len(state), bool))
    assert repeats is not None
    period = np.linspace(0, repeats.period, 4001)
    once = integrate(compiled, run.states[:, -1], parameters, period).reraise_interrupt()
    return cycle_near(cycles, once.time, once.states, values[cycles.equations.parameter_names[-1]])


def isola(most: float = STEPS.most) -> tuple[Cycles, Cycle]:
    scale = {"s": 30.0, "a": 100.0, "rho": 1.0, "S0": 10.0}
    steps = replace(STEPS, most=most)
    cycles = Cycles.of(PLP, "rho", {"S0": 111.0}, (2.0, 6.0), scale=scale, accuracy=1e-9, steps=steps)
    return cycles, settled_on(cycles, PLP, {"rho": 4.0, "S0": 111.0}, [100.0, 300.0], 300.0)


@pytest.mark.parametrize("most", [0.5])
def test_an_isola_is_no_hopf_point(most: float) -> None:
    """With long steps Newton's method finds the equilibrium, which satisfies the equations of orbits."""
    cycles, first = isola(most)
    for start in (first, cycles.backwards(first)):
        points = list(walk := cycles.walk(start))
        assert walk.end == CURVE_IS_CLOSED
        assert sorted(p.parameter for p in points if p.kind) == pytest.approx(FOLDS_OF_PLP, abs=1e-10)
        assert points[-1].parameter == pytest.approx(4.0, abs=1e-3)
        assert points[-1].period == pytest.approx(first.period, abs=1e-3)


def test_orbits_that_shrink_without_a_hopf_point_are_not_said_to_end_at_one() -> None:
    """r^2 = p^2: the eigenvalues p^2 +- i touch the imaginary axis at p = 0, and do not cross it."""
    system = planar(P**2 - X**2 - Y**2, P)
    cycles = Cycles.of(system, "p", {"speed": 1.0}, (-1.0, 1.0))
    tau = np.linspace(0, 1, 41)
    circle = 0.5 * np.array([np.cos(2 * np.pi * tau), np.sin(2 * np.pi * tau)])
    first = cycle_near(cycles, 2 * np.pi * tau, circle, 0.5)
    walk = cycles.walk(first if first.point.tangent[-1] < 0 else cycles.backwards(first))
    points = list(walk)
    assert walk.end == VANISHES
    end = branch_end(cycles, *np.array([(p.parameter, p.period) for p in points]).T, points[-3:], walk.end)
    assert end.kind == "not-identified"


@cache
def torus_type() -> tuple[Cycles, list[Cycle]]:
    """The symmetric orbits of tor, from their Hopf point."""
    equilibria = EquilibriumContinuation(EquilibriumEquations.from_system(TOR, ["nu"], {"be": 0.5}), (-0.9, -0.4))
    branch = equilibria.follow_branch(equilibria.start(np.zeros(3), -0.6))
    hopf = next(p for p in branch.special if p.kind == "hopf" and np.allclose(p.x, 0))
    cycles = Cycles.of(TOR, "nu", {"be": 0.5}, (-0.9, -0.4), periods=(0.0, 25.0))
    first = cycle_at_hopf(cycles, hopf)
    return cycles, list(cycles.walk(first))


def test_branch_points_beside_folds_are_located() -> None:
    _, points = torus_type()
    special = [(p.kind, p.parameter, p.period) for p in points if p.kind]
    assert special[:4] == [
        ("fold", pytest.approx(-0.58433477187, abs=1e-10), pytest.approx(8.42647, rel=1e-6)),
        ("branch-point", pytest.approx(-0.58702897436, abs=1e-10), pytest.approx(8.68966962, abs=1e-8)),
        ("fold", pytest.approx(-0.83251414538, abs=1e-10), pytest.approx(19.415681, rel=1e-6)),
        ("branch-point", pytest.approx(-0.83243793127, abs=1e-10), pytest.approx(19.63664544, abs=1e-7)),
    ]


def test_at_a_branch_point_a_second_multiplier_is_one_and_both_branches_leave() -> None:
    cycles, points = torus_type()
    for at in (p for p in points if p.kind == "branch-point"):
        maps, flow = integrated_maps(TOR, {"nu": at.parameter, "be": 0.5}, at.problem.mesh.edges * at.period, at.states[:, ::6])
        assert np.abs(logarithms(transverse_maps(maps, flow)[0])[0]).min() < 1e-7
        one, other = crossing_branch(cycles, at, amplitude=0.05)
        # The symmetry maps one to the other: the same period and parameter, and no orbit is its own mirror image.
        assert (one.period, one.parameter) == pytest.approx((other.period, other.parameter), abs=1e-6)
        assert abs((one.states @ one.problem.mesh.shares)[0]) > 1e-4


@pytest.mark.parametrize("most", [0.5])
def test_the_symmetry_of_a_duffing_oscillator_breaks(most: float) -> None:
    cycles = Cycles.of(DUFFING, "force", {}, (0.05, 8.0), steps=replace(STEPS, most=most), accuracy=1e-9)
    first = settled_on(cycles, DUFFING, {"force": 0.1}, [0.1, 0.0, 1.0, 0.0], 400.0)
    special = [(p.kind, p.parameter) for p in cycles.walk(first) if p.kind]
    assert special == [
        ("fold", pytest.approx(0.461391155241, abs=1e-11)),
        ("fold", pytest.approx(0.228323272866, abs=1e-11)),
        ("branch-point", pytest.approx(2.40337711606, abs=1e-10)),
    ]


@cache
def tank() -> tuple[list[Cycle], BranchEnd]:
    """AUTO's demo ab at p2 = 17, from p1 = 0.175 down to its saddle connection."""
    steps = Steps(most=0.3, turn=0.3, corrections=4, tolerance=1e-8)
    scale = {"u1": 0.46, "u2": 7.7, "p1": 0.03}
    cycles = Cycles.of(AB, "p1", {"p2": 17.0}, (0.1, 0.25), scale=scale, periods=(0.0, 50.0), steps=steps)
    first = settled_on(cycles, AB, {"p1": 0.175, "p2": 17.0}, [0.5, 2.0], 200.0)
    walk = cycles.walk(first if first.point.tangent[-1] < 0 else cycles.backwards(first))
    points = [first, *walk]
    values, periods = np.array([(p.parameter, p.period) for p in points if not p.kind]).T
    return points, branch_end(cycles, values, periods, points[-3:], walk.end)


def test_the_only_multiplier_of_a_plane_is_known_however_small() -> None:
    """Against the variational equations, integrated; near the saddle ln mu grows with the time spent there at its rate."""
    points, end = tank()
    assert all(p.logarithms[0].imag == 0 for p in points)
    assert not any(p.kind for p in points)
    for p in (points[0], points[7]):
        edges, degree = p.problem.mesh.edges, p.problem.mesh.degree
        maps, flow = integrated_maps(AB, {"p1": p.parameter, "p2": 17.0}, edges * p.period, p.states[:, ::degree])
        exact = logarithms(transverse_maps(maps, flow)[0])[0]
        assert p.logarithms[0].real == pytest.approx(exact[0].real, rel=1e-5)
        assert exact[0].real < -100
    periods, values = np.array([(p.period, p.logarithms[0].real) for p in points if p.period > 30.0]).T
    np.testing.assert_allclose(np.diff(values) / np.diff(periods), end.eigenvalues.real.sum(), rtol=0.1)
    assert (values[periods < 40] < 0).all()


def test_a_saddle_connection_is_recognised_where_the_law_of_the_period_is_not() -> None:
    points, end = tank()
    assert end.kind == "saddle-connection"
    assert end.parameter == pytest.approx(0.1194548240, abs=1e-9)
    assert end.equilibrium == pytest.approx([0.499268, 2.121889], abs=1e-6)
    assert end.eigenvalues.real.min() < 0 < end.eigenvalues.real.max()
    near = np.linalg.norm((points[-1].states - end.equilibrium[:, None]) / [[0.46], [7.7]], axis=0) < 0.1
    assert points[-1].problem.mesh.shares @ near > 0.7


def test_multipliers_of_three_states_have_the_product_that_liouville_demands() -> None:
    """The tank with a third state that decays as exp(-t): of the others one is e^-117, which no mesh for the orbit resolves."""
    system = System((*AB.states, Z), (*AB.derivatives, -Z + AB.states[0] ** 2), AB.parameters)
    cycles = Cycles.of(system, "p1", {"p2": 17.0}, (0.1, 0.25), scale={"u1": 0.46, "u2": 7.7, "p1": 0.03})
    first = settled_on(cycles, system, {"p1": 0.175, "p2": 17.0}, [0.5, 2.0, 0.0], 200.0)
    assert first.logarithms.real == pytest.approx([-first.period, -117.2800415], abs=1e-3)
    assert abs(first.product_error) < 1e-3


def test_cycles_at_a_wanted_value() -> None:
    """rho = 3.7 is passed twice; the periods are those of runs there, and of the other branch those of Newton's method."""
    cycles, first = isola()
    branch = [first, *cycles.walk(first)]
    wanted = cycles_with(cycles, branch, 3.7)
    assert [c.parameter for c in wanted] == pytest.approx([3.7, 3.7], abs=1e-12)
    stable = settled_on(cycles, PLP, {"rho": 3.7, "S0": 111.0}, [100.0, 300.0], 300.0)
    assert sorted(c.unstable for c in wanted) == [0, 1]
    assert next(c.period for c in wanted if not c.unstable) == pytest.approx(stable.period, rel=1e-9)
    assert cycles_with(cycles, branch, 5.0) == ()
    assert len(cycles_with(cycles, branch[:3], first.parameter)) == 1


def test_an_orbit_of_other_states_or_out_of_bounds_begins_no_branch() -> None:
    cycles, first = isola()
    with rejected("out-of-range"):
        cycle_at(cycles, first, 7.0)
    torus_cycles, _ = torus_type()
    with rejected("shape", "3"):
        cycle_at(torus_cycles, first, -0.6)
