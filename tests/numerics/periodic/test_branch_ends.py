"""How branches of orbits end: laws of the period with an exact p*, peers' numbers, and where an end is not identified.

Peers: E. J. Doedel et al., AUTO-07P manual, 2007 (demos lrz, pp2). Exact: theta' = p - sin theta has
T = 2 pi/sqrt(p^2 - 1).
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import sympy as sp

from auto_demos import LORENZ, PP2
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.periodic.branch_ends import BranchEnd, branch_end
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import cycle_at_hopf, cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.period_laws import CONNECTION, SADDLE_NODE, better_law, laws_of_growth
from wucht.system import System

THETA, R, P = sp.symbols("theta r p", real=True)
ROTATION = System((THETA, R), (P - sp.sin(THETA), -R), (P,), angles=frozenset({THETA}))


def followed(cycles: Cycles, start: Cycle) -> BranchEnd:
    walk = cycles.walk(start)
    orbits = [start, *walk]
    values, periods = (np.array([getattr(o, name) for o in orbits]) for name in ("parameter", "period"))
    return branch_end(cycles, values, periods, orbits[-3:], walk.end)


def rotation(bounds: tuple[float, float], longest: float) -> tuple[Cycles, Cycle]:
    """Beginning at p = 2."""
    cycles = Cycles.of(ROTATION, "p", {}, bounds, winding={"theta": 1}, periods=(0.0, longest))
    period, theta = 2 * np.pi / np.sqrt(3), np.linspace(0, 2 * np.pi, 200)
    times = 2 / np.sqrt(3) * (np.arctan((2 * np.tan(theta / 2) - 1) / np.sqrt(3)) + np.pi / 6)
    times[theta > np.pi] += period
    return cycles, cycle_near(cycles, times, np.array([theta, 0 * theta]), 2.0)


def test_a_saddle_node_on_the_orbit() -> None:
    """p* = 1, theta = pi/2, C = 2 pi/sqrt 2."""
    cycles, start = rotation((-3.0, 3.0), 300.0)
    end = followed(cycles, cycles.backwards(start))
    assert end.kind == "saddle-node-on-orbit"
    assert end.parameter == pytest.approx(1.0, abs=1e-10)
    assert end.equilibrium == pytest.approx([np.pi / 2, 0.0], abs=1e-5)
    assert np.abs(end.eigenvalues).min() < 1e-8
    assert end.saddle_node is not None
    assert end.connection is not None
    assert end.saddle_node.critical == pytest.approx(1.0, abs=3 * end.saddle_node.error)
    assert end.saddle_node.factor == pytest.approx(2 * np.pi / np.sqrt(2), rel=1e-2)
    assert end.saddle_node.residual < end.connection.residual / 30


def test_where_the_range_or_the_longest_period_come_first() -> None:
    """At p = 1.5 and at a period of 4 nothing is said of a law that the orbits do not show."""
    cycles, start = rotation((1.5, 3.0), 300.0)
    for way, bound in ((start, 3.0), (cycles.backwards(start), 1.5)):
        end = followed(cycles, way)
        assert (end.kind, end.parameter) == ("range", bound)
    cycles, start = rotation((-3.0, 3.0), 4.0)
    assert followed(cycles, cycles.backwards(start)).kind == "period-limit"


@cache
def ends_of_lorenz() -> tuple[BranchEnd, BranchEnd]:
    equilibria = EquilibriumContinuation(EquilibriumEquations.from_system(LORENZ, ["rho"], {}), (1.5, 30.0), Steps(most=1.0))
    branch = equilibria.follow_branch(equilibria.start([np.sqrt(24.0), np.sqrt(24.0), 9.0], 10.0))
    sizes = {"x": 5.0, "y": 5.0, "z": 10.0, "rho": 5.0}
    cycles = Cycles.of(LORENZ, "rho", {}, (0.0, 30.0), periods=(0.0, 9.0), scale=sizes)
    start = cycle_at_hopf(cycles, branch.special[0])
    return followed(cycles, start), followed(cycles, cycles.backwards(start))


def test_the_homoclinic_orbit_of_lorenz() -> None:
    """rho = 13.926557; the orbits are unstable: lambda is the stable eigenvalue next to zero, 8/3."""
    end = ends_of_lorenz()[0]
    assert end.kind == "saddle-connection"
    assert end.parameter == pytest.approx(13.926557407, abs=1e-7)
    assert end.equilibrium == pytest.approx(np.zeros(3), abs=1e-6)
    assert end.connection is not None
    assert end.saddle_node is not None
    assert 1 / end.connection.factor == pytest.approx(8 / 3, rel=1e-3)
    assert end.connection.residual < end.saddle_node.residual / 30


def test_a_hopf_point_is_an_end() -> None:
    """470/19."""
    end = ends_of_lorenz()[1]
    assert end.kind == "hopf"
    assert end.parameter == pytest.approx(470 / 19, rel=1e-8)
    assert np.abs(end.eigenvalues.real).min() < 1e-6


def test_two_saddles_in_a_loop() -> None:
    """pp2: both on u2 = 0; the time past them is as their eigenvalues say. The other end is a Hopf point."""
    equilibria = EquilibriumContinuation(EquilibriumEquations.from_system(PP2, ["q"], {}), (0.0, 1.0))
    hopf = next(p for p in equilibria.follow_branch(equilibria.start([1 / 3, 0.4], 0.68)).special if p.kind == "hopf")
    cycles = Cycles.of(PP2, "q", {}, (0.0, 1.0), periods=(0.0, 90.0))
    start = cycle_at_hopf(cycles, hopf)
    end = followed(cycles, start)
    assert end.kind == "saddle-connection"
    assert end.parameter == pytest.approx(0.7080728, abs=1e-7)
    assert end.equilibrium[1] == pytest.approx(0.0, abs=1e-9)
    assert "2 saddles" in end.sentence
    other = followed(cycles, cycles.backwards(start))
    assert (other.kind, other.parameter) == ("hopf", pytest.approx(0.67159384754, abs=1e-9))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_laws_are_told_apart(sense: float) -> None:
    """Exact data of both, with the next term; four orbits are too few."""
    mu = np.geomspace(1e-1, 1e-5, 60)
    values = 2.0 + sense * mu
    for periods, name, factor, rel in (
        (3.0 * mu**-0.5 + 4.0 + mu**0.5, SADDLE_NODE, 3.0, 1e-3),
        (-np.log(mu) / 0.25 + 4.0 + mu, CONNECTION, 4.0, 1e-2),
    ):
        laws = laws_of_growth(values, periods)
        assert laws is not None and [law.name for law in laws] == [SADDLE_NODE, CONNECTION]
        better = better_law(laws)
        assert (better.name, better.factor) == (name, pytest.approx(factor, rel=rel))
        assert better.critical == pytest.approx(2.0, abs=3 * better.error)
    assert laws_of_growth(values[:4], mu[:4] ** -0.5) is None


def test_neither_law() -> None:
    """A period that grows as the power -1 of the distance fits neither."""
    mu = np.geomspace(1.0, 1e-4, 60)
    laws = laws_of_growth(2.0 + mu, 1 / mu)
    assert laws is not None
    assert better_law(laws).residual > 2e-3
