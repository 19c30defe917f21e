"""Orbits against AUTO-07p's demos lrz, pp2, pen and cir, and those of the dissertation's averaged equations."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from auto_demos import CIR, LORENZ, PEN, PP2
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.catalogue import load_machine
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import Equilibrium, EquilibriumContinuation
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.jacobian import Jacobian
from wucht.numerics.periodic.connection_starts import connection_from_excursion
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_curves import CycleCurve
from wucht.numerics.periodic.cycle_starts import cycle_at_hopf, cycle_from_nodes, cycle_near, doubled_branch
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.floquet import integrated_maps, logarithms, transverse_maps
from wucht.numerics.periodic.saddle_connections import Connections
from wucht.system import System


def hopf(system: System, parameter: str, bounds: tuple[float, float], state: list[float], value: float) -> Equilibrium:
    equilibria = EquilibriumContinuation(EquilibriumEquations.from_system(system, [parameter], {}), bounds, Steps(most=1.0))
    return next(p for p in equilibria.follow_branch(equilibria.start(state, value)).special if p.kind == "hopf")


def at(cycles: Cycles, points: list[Cycle], value: float) -> Cycle:
    """The orbit at a value of the parameter, from the nearest of a branch."""
    near = min(points, key=lambda p: abs(p.parameter - value))
    return cycle_from_nodes(cycles, near.problem.mesh, near.states.T, near.period, value)


def exact_multipliers(system: System, values: dict[str, float], cycle: Cycle) -> tuple[np.ndarray, float]:
    """ln mu by integration of the variational equations, and that of the trivial one."""
    edges = cycle.problem.mesh.edges
    across, along = transverse_maps(*integrated_maps(system, values, edges * cycle.period, cycle.states_at(edges)))
    return logarithms(across)[0], along


@pytest.mark.slow
def test_lorenz_orbits_from_the_hopf_point_to_the_homoclinic_one() -> None:
    begin = hopf(LORENZ, "rho", (1.5, 30.0), [math.sqrt(24), math.sqrt(24), 9.0], 10.0)
    scale = {"x": 5.0, "y": 5.0, "z": 10.0, "rho": 5.0}
    cycles = Cycles.of(LORENZ, "rho", {}, (0.0, 30.0), scale=scale, periods=(0.0, 60.0))
    walk = cycles.walk(cycle_at_hopf(cycles, begin))
    points = list(walk)
    assert [p.kind for p in points if p.kind] == []
    assert walk.end.endswith("while rho stays near 13.9266")
    assert points[-1].parameter == pytest.approx(13.926557, abs=5e-7)
    cycle = at(cycles, points, 20.0)
    assert cycle.period == pytest.approx(0.87655225349, rel=1e-10)
    values, along = exact_multipliers(LORENZ, {"rho": 20.0}, cycle)
    assert math.exp(values[0].real) == pytest.approx(1.40207, abs=5e-6)
    np.testing.assert_allclose(cycle.logarithms, values, atol=1e-5)
    assert abs(along) < 1e-8
    # Liouville: the trace is -10 - 1 - 8/3 everywhere.
    assert values.sum().real == pytest.approx(-(11 + 8 / 3) * cycle.period, abs=1e-8)


def test_pp2_orbits_from_the_hopf_point_to_the_saddle() -> None:
    begin = hopf(PP2, "q", (0.0, 1.0), [1 / 3, 0.4], 0.68)
    cycles = Cycles.of(PP2, "q", {}, (0.0, 1.0), periods=(0.0, 1000.0))
    walk = cycles.walk(cycle_at_hopf(cycles, begin))
    points = list(walk)
    assert [p.kind for p in points if p.kind] == []
    assert walk.end.endswith("while q stays near 0.708073") and points[-1].period > 20 * points[0].period
    cycle = at(cycles, points, 0.69)
    assert cycle.period == pytest.approx(13.4387056, rel=1e-8)
    assert math.exp(cycle.logarithms[0].real) == pytest.approx(0.667816, abs=5e-7)


@pytest.mark.parametrize("way", [1, -1])
def test_cir_the_homoclinic_orbit_of_the_circuit(way: int) -> None:
    """AUTO begins the demo at nu = -0.721309, be = 0.6, ga = 0, r = 0.6: six digits, and a truncated orbit.

    Two of them: the equations do not change with the sign of all states.
    """
    connections = Connections.of(CIR, ["nu"], {"be": 0.6, "r": 0.6, "ga": 0.0}, [(-1.0, -0.5)], 60.0)
    orbit = connection_from_excursion(connections, [0.0, 0.0, 0.0], [-0.73], way)
    assert orbit.parameter_values[0] == pytest.approx(-0.721309, abs=2e-6)
    assert np.abs(orbit.states[:, [0, -1]]).max() < 1e-5
    assert way * orbit.states[0][np.abs(orbit.states[0]).argmax()] > 0.4


PENDULA = {"gamma": 0.175, "eps": 0.1}
BOTH = {"phi1": 1, "phi2": 1}


@lru_cache(maxsize=1)
def rotations() -> tuple[Cycles, Cycle, tuple[Cycle, ...]]:
    """Both pendula turning together at I = 0.4, and the branch towards less torque."""
    rates = sp.lambdify([PEN.states, PEN.parameters], PEN.derivatives)
    period = 1.5738797
    run = solve_ivp(
        lambda t, x: rates(x, (0.4, 0.175, 0.1)), (0, 150 + period), [0, 0, 4, 4], rtol=1e-8, atol=1e-8, dense_output=True
    )
    times = 150 + np.linspace(0, period, 60)
    cycles = Cycles.of(PEN, "current", PENDULA, (0.15, 0.6), winding=BOTH)
    first = cycle_near(cycles, times, run.sol(times), 0.4)
    return cycles, first, tuple(cycles.walk(first if first.point.tangent[-1] < 0 else cycles.backwards(first)))


def test_pen_rotation_and_its_multipliers() -> None:
    """AUTO's period is 1.5e-8 too long and its pair 1.6e-5 off: both as shooting for the two pendula in phase has them.

    There T = 1.573879695895 and the pair of the difference, y'' + eps y' + (cos phi + 2 gamma) y = 0, is 0.55124475 +-
    0.74195805 i (SciPy, DOP853 at 1e-13).
    """
    _, first, _ = rotations()
    assert first.period == pytest.approx(1.5738797188, rel=1e-6)
    assert first.period == pytest.approx(1.573879695895, rel=1e-10)
    values, along = exact_multipliers(PEN, PENDULA | {"current": 0.4}, first)
    expected = [0.55124475 + 0.74195805j, 0.55124475 - 0.74195805j, 0.85437252]
    for found in (first.logarithms, values):
        np.testing.assert_allclose(np.sort_complex(np.exp(found)), np.sort_complex(np.array(expected)), atol=1e-8)
    np.testing.assert_allclose(np.exp(values), [0.551229 + 0.741969j, 0.551229 - 0.741969j, 0.854372], atol=2e-5)
    assert abs(along) < 1e-10 and values.sum().real == pytest.approx(-0.2 * first.period, abs=1e-10)


def test_pen_period_doubling_and_the_rotation_of_twice_the_period() -> None:
    """After one turn of each the pendula have changed places."""
    cycles, _, points = rotations()
    (point,) = [p for p in points if p.kind]
    assert point.kind == "period-doubling"
    assert point.parameter == pytest.approx(0.17916377811, rel=2e-8)
    assert point.period == pytest.approx(3.7052721214, rel=1e-8)
    more, first = doubled_branch(cycles, point)
    assert first.period == pytest.approx(2 * point.period, rel=1e-5)
    np.testing.assert_array_equal(more.winding, [2, 2, 0, 0])
    walk = more.walk(first)
    cycle = [next(walk) for _ in range(8)][-1]
    half, later = (cycle.states_at(np.linspace(0, 0.5, 40) + begin) for begin in (0.0, 0.5))
    np.testing.assert_allclose(later, half[[1, 0, 3, 2]] + 2 * np.pi * np.array([[1], [1], [0], [0]]), atol=1e-6)
    assert np.abs(half[0] - half[1]).max() > 0.05


def test_pen_period_doublings_over_two_parameters_are_those_of_branches_in_one() -> None:
    _, _, points = rotations()
    point = next(p for p in points if p.kind)
    curve = CycleCurve.of("period-doubling", PEN, ("current", "gamma"), {"eps": 0.1}, ((0.15, 0.6), (0.1, 0.25)), winding=BOTH)
    start = curve.start(point, 0.175)
    ends = [list(curve.walk(way))[-1] for way in (start, curve.backwards(start))]
    (end,) = [e for e in ends if e.parameter_values[1] == 0.25]
    there = Cycles.of(PEN, "current", PENDULA | {"gamma": 0.25}, (0.15, 0.6), winding=BOTH)
    near = min(points, key=lambda p: abs(p.parameter - 0.3))
    first = cycle_from_nodes(there, near.problem.mesh, near.states.T, near.period, 0.3)  # in phase, whatever the coupling
    (found,) = [p for p in there.walk(first if first.point.tangent[-1] < 0 else there.backwards(first)) if p.kind]
    assert found.kind == "period-doubling" and end.parameter_values[0] == pytest.approx(found.parameter, abs=1e-8)
    assert end.period == pytest.approx(found.period, rel=1e-8)


WINDING = {"p1.phase": -1, "p2.phase": -1}


@lru_cache(maxsize=1)
def dissertation() -> tuple[System, dict[str, float], Cycles, tuple[Cycle, ...]]:
    """The rotating orbit of table 5.1, from u* to u*."""
    machine = load_machine("drozdetskaya-2020/table-5.1")
    system = replace(averaged_equations_of(machine, inertia=False).system, outputs=(), quadratures=())
    values = dict(machine.values) | {"u": 2.5}
    run = integrate(compile_system(system, 1e-10), [0.0, 0.0, 0.3], system.values(values), np.linspace(0, 4000, 20001))
    turned = run.states[0]
    begin = int(np.argmax(turned <= turned[-1] + 2 * math.pi))
    times, states = run.time[begin:], run.states[:, begin:].copy()
    states[1] = states[0]  # the phases' difference decays only slowly
    fixed = {k: v for k, v in values.items() if k != "u"}
    cycles = Cycles.of(system, "u", fixed, (0.5, 8.0), winding=WINDING, periods=(0.0, 6000.0))
    first = cycle_near(cycles, times[::5], states[:, ::5], 2.5)
    both = [list(cycles.walk(way)) for way in (first, cycles.backwards(first))]
    return system, fixed, cycles, (*both[0][::-1], first, *both[1])


def speed_of(cycles: Cycles, points: tuple[Cycle, ...], u: float) -> tuple[Cycle, np.ndarray, float]:
    """The orbit at u, the rotor's speed at its nodes, and the period in phi."""
    cycle = at(cycles, list(points), u)
    speed = cycle.states[2]
    return cycle, speed, cycle.integral(speed)


@pytest.mark.slow
def test_dissertation_periods_and_speeds_of_the_rotating_orbit() -> None:
    _, _, cycles, points = dissertation()
    for u, expected in {2.0: 1665.34645, 3.0: 630.30303, 4.0: 721.60711, 5.0: 1199.31590}.items():
        assert speed_of(cycles, points, u)[2] == pytest.approx(expected, rel=1e-8)
    for u, low, high in ((2.0, 0.77291, 1.42312), (3.0, 0.81310, 1.56264)):
        cycle, _, _ = speed_of(cycles, points, u)
        fine = cycle.states_at(np.linspace(0, 1, 40_001))[2]  # its peak is sharp
        assert (fine.min(), fine.max()) == pytest.approx((low, high), abs=6e-6)


@pytest.mark.slow
def test_dissertation_stability_of_the_rotating_orbit() -> None:
    """ln mu down to -400: by integration, with the sum that Liouville's theorem gives, and the trivial one."""
    system, fixed, cycles, points = dissertation()
    trace_of = Jacobian.of(system)
    for u, expected in ((2.0, -0.01969), (3.5, 0.00839)):
        cycle, _, turned = speed_of(replace(cycles, accuracy=1e-10), points, u)
        values, along = exact_multipliers(system, fixed | {"u": u}, cycle)
        # The phases' difference decays or grows by itself; the other multiplier is that of the motion together.
        assert abs(along) < 1e-10
        assert values[0].real / turned == pytest.approx(expected, abs=6e-6)
        f_x = trace_of(cycle.states, system.values(fixed | {"u": u}))[1]
        assert values.sum().real == pytest.approx(cycle.integral(np.trace(f_x)), abs=1e-8)
        assert values[1].real < -100
    (lost,) = [p for p in points if p.kind]
    assert lost.kind == "branch-point" and lost.parameter == pytest.approx(3.0800128, abs=5e-8)


@pytest.mark.slow
def test_dissertation_the_orbit_lives_between_both_folds() -> None:
    """u1* = 1.8331080, u2* = 5.8710372: the period grows as one over a square root of what is left."""
    _, _, cycles, points = dissertation()
    for end, near in ((points[0], points[3]), (points[-1], points[-4])):
        a, b = end.period**-2, near.period**-2
        limit = (end.parameter * b - near.parameter * a) / (b - a)
        assert min(abs(limit - 1.8331080), abs(limit - 5.8710372)) < 2e-3
    further = replace(cycles, periods=(0.0, 2e4))
    up = at(further, list(points), 5.0)
    walk = further.walk(up if up.point.tangent[-1] > 0 else further.backwards(up))
    list(walk)
    assert walk.end.endswith("while u stays near 5.86891")


def test_dissertation_stability_is_lost_over_sigma_as_over_u() -> None:
    """The curve in (u, sigma) of u = 3.0800128 at sigma = 0.1, against the branch in u at sigma = 0.11."""
    system, fixed, cycles, points = dissertation()
    lost = next(p for p in points if p.kind)
    others = {k: v for k, v in fixed.items() if k != "sigma"}
    bounds = ((0.5, 8.0), (0.099, 0.11))
    curve = CycleCurve.of("branch-point", system, ("u", "sigma"), others, bounds, winding=WINDING, accuracy=1e-9)
    start = curve.start(lost, 0.1)
    ends = [list(curve.walk(way))[-1] for way in (start, curve.backwards(start))]
    (end,) = [e for e in ends if e.parameter_values[1] == 0.11]

    middle = at(cycles, list(points), 2.5)
    over_sigma = Cycles.of(system, "sigma", others | {"u": 2.5}, (0.05, 0.11), winding=WINDING)
    first = cycle_from_nodes(over_sigma, middle.problem.mesh, middle.states.T, middle.period, 0.1)
    there = list(over_sigma.walk(first if first.point.tangent[-1] > 0 else over_sigma.backwards(first)))[-1]
    over_u = Cycles.of(system, "u", fixed | {"sigma": 0.11}, (0.5, 3.3), winding=WINDING)
    first = cycle_from_nodes(over_u, there.problem.mesh, there.states.T, there.period, 2.5)
    branch = over_u.walk(first if first.point.tangent[-1] > 0 else over_u.backwards(first))
    found = next(p for p in branch if p.kind)
    assert found.kind == "branch-point" and end.parameter_values[0] == pytest.approx(found.parameter, abs=1e-8)
    assert end.period == pytest.approx(found.period, rel=1e-8)
