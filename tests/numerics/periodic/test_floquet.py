from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from tests.refusals import failed

from known_orbits import EVEN, PITCHFORK, X, Y, Z, placed
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.jacobian import Jacobian, variational_system
from wucht.numerics.orbits import periodic_orbit
from wucht.numerics.periodic import floquet
from wucht.numerics.periodic.cycle_starts import cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.floquet import halve_legs, integrated_legs, integrated_maps, logarithms, transverse_maps
from wucht.system import System

RNG = np.random.default_rng(11)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_against_eigenvalues_of_the_product_where_it_can_be_multiplied(n: int) -> None:
    for _ in range(5):
        maps = RNG.normal(size=(7, n, n))
        expected = np.log(np.linalg.eigvals(np.linalg.multi_dot(maps[::-1])).astype(complex))
        values, basis = logarithms(maps)
        # -pi and pi are one angle
        off = np.exp(values)[:, None] / np.exp(expected) - 1
        assert np.abs(off).min(axis=1).max() < 1e-8
        np.testing.assert_allclose(basis.T @ basis, np.eye(n), atol=1e-13)


def test_multipliers_that_are_tiny_or_huge_beside_one() -> None:
    """ln mu = 300, 0, -400; and the same with a negative one."""
    frames = np.array([np.linalg.qr(RNG.normal(size=(3, 3)))[0] for _ in range(200)])
    rates = np.diag(np.exp(np.array([300.0, 0.0, -400.0]) / 200))
    maps = frames[(np.arange(200) + 1) % 200] @ rates @ frames.transpose(0, 2, 1)
    np.testing.assert_allclose(logarithms(maps)[0], [300, 0, -400], atol=1e-9)
    maps[5] = maps[5] @ frames[5] @ np.diag([1.0, -1.0, 1.0]) @ frames[5].T
    np.testing.assert_allclose(logarithms(maps)[0], [300, 1j * math.pi, -400], atol=1e-9)


def test_a_complex_pair_and_a_double_one() -> None:
    turn, frames = 0.7, np.array([np.linalg.qr(RNG.normal(size=(3, 3)))[0] for _ in range(20)])
    block = np.zeros((3, 3))
    block[:2, :2] = math.exp(-0.1) * np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    block[2, 2] = math.exp(-4.0)
    maps = frames[(np.arange(20) + 1) % 20] @ block @ frames.transpose(0, 2, 1)
    angle = 20 * turn - 4 * math.pi
    expected = [-2 + 1j * abs(angle), -2 - 1j * abs(angle), -80]
    np.testing.assert_allclose(logarithms(maps)[0], expected, atol=1e-9)
    np.testing.assert_allclose(logarithms(np.tile(0.5 * np.eye(2), (4, 1, 1)))[0], 4 * math.log(0.5), atol=1e-12)


def test_of_a_known_orbit_by_integration_collocation_and_shooting() -> None:
    """ln mu = (p - q^2) T and -2 T; their sum is the integral of the trace (Liouville)."""
    tau, fixed = np.linspace(0, 1, 61), {"q": 0.5, "speed": 2.0}
    samples = placed(EVEN, {X: np.cos(2 * np.pi * tau), Y: np.sin(2 * np.pi * tau), Z: 0 * tau})
    cycles = Cycles.of(PITCHFORK, "p", fixed, (-1, 1))
    cycle = cycle_near(cycles, math.pi * tau, samples, 0.1)
    expected = np.array([-0.15 * math.pi, -2 * math.pi])
    np.testing.assert_allclose(cycle.logarithms, expected, atol=1e-7)

    values, edges = fixed | {"p": 0.1}, cycle.problem.mesh.edges
    maps, flow = integrated_maps(PITCHFORK, values, edges * cycle.period, cycle.states_at(edges))
    across, along = transverse_maps(maps, flow)
    exact, _ = logarithms(across)
    assert abs(along) < 1e-10
    np.testing.assert_allclose(exact, expected, atol=1e-10)
    f_x = Jacobian.of(PITCHFORK)(cycle.states, PITCHFORK.values(values))[1]
    assert exact.sum().real == pytest.approx(cycle.integral(np.trace(f_x)), abs=1e-8)

    compiled, guess = compile_system(PITCHFORK, 1e-14), samples[:, 0]
    shot = periodic_orbit(compiled, PITCHFORK.values(values), guess, math.pi, np.zeros(3), phase_state=1)
    np.testing.assert_allclose(shot.nontrivial(1), np.exp(exact), atol=1e-10)
    assert shot.period == pytest.approx(cycle.period, abs=1e-10)


def test_places_are_added_where_changes_grow_too_differently() -> None:
    """x' = 0, y' = -60 y over one unit of time: a map whose condition is exp(60)."""
    x, y = sp.symbols("x y", real=True)
    system = System((x, y), (sp.Integer(1), -60 * y))
    maps, flow = integrated_maps(system, {}, np.array([0.0, 1.0]), np.array([[0.0, 1.0], [0.0, 0.0]]))
    assert len(maps) > 1 and len(flow) == len(maps) and np.linalg.cond(maps).max() <= 1e4
    np.testing.assert_allclose(logarithms(maps)[0], [0.0, -60.0], atol=1e-10)


def test_legs_are_judged_in_the_states_sizes_and_not_halved_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """x' = 1e3 y, y' = -1e-3 x turns x and 1e3 y, and z' = -30 z is to be told from it."""
    x, y, z = sp.symbols("x y z", real=True)
    linear = compile_system(variational_system(System((x, y, z), (1e3 * y, -1e-3 * x, -30 * z)), 3), 1e-15)
    times, states, sizes = np.linspace(0, 1, 4), np.zeros((3, 3)), np.array([1e3, 1.0, 1e-3])
    none = np.empty(0)
    maps = integrated_legs(linear, none, times[:-1], times[1:], states)[1] * sizes / sizes[:, None]
    given = maps.copy()
    at, x_at, finer = halve_legs(linear, none, times, states, maps, sizes)
    np.testing.assert_array_equal(maps, given)
    assert len(finer) == 6 and x_at.shape == (3, 6)
    np.testing.assert_allclose(at, np.linspace(0, 1, 7), atol=1e-15)
    np.testing.assert_allclose(logarithms(finer)[0], [1j, -1j, -30], rtol=0, atol=1e-11)
    monkeypatch.setattr(floquet, "_MOST_LEGS", 5)
    with failed("too-different", "5"):
        halve_legs(linear, none, times, states, maps, sizes)


@pytest.mark.parametrize("angle", [0.0, 0.5 * math.pi])
@pytest.mark.parametrize("off", [-1e-15, 0.0, 1e-15])
def test_rounding_at_the_end_of_the_period_does_not_mirror_it(angle: float, off: float) -> None:
    """A circle with mu = exp(-pi), from where one of dx/dt passes zero: its sign at either end is that of rounding."""
    x, y = sp.symbols("x y", real=True)
    grow = (1 - x**2 - y**2) / 4
    times = np.linspace(0, 2 * math.pi, 9)
    states = np.array([np.cos(times + angle), np.sin(times + angle)])
    states[:, 0], states[:, -1] = np.round(states[:, 0]) - off, np.round(states[:, 0]) + off
    maps, flow = integrated_maps(System((x, y), (-y + x * grow, x + y * grow)), {}, times, states)
    np.testing.assert_allclose(logarithms(transverse_maps(maps, flow)[0])[0], [-math.pi], rtol=0, atol=1e-12)
