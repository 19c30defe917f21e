"""Random systems whose orbits can have special points of some kinds only, and those where they are known.

In the plane an orbit has one multiplier, the exponential of an integral (Liouville): positive, so that no period doubles and no
torus is born. Where a system is symmetric under z -> -z, an orbit in z = 0 loses its symmetry where the mean over a period of
the rate at which z grows vanishes.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from known_orbits import SQUARE, P, X, Y, Z, bent
from wucht.errors import RunError
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.periodic.cycle import DOUBLING, TORUS, Cycle
from wucht.numerics.periodic.cycle_starts import cycle_at_hopf, cycle_near
from wucht.numerics.periodic.cycles import STEPS, Cycles
from wucht.system import System

COEFFICIENT = st.integers(-10, 10).map(lambda k: sp.Rational(k, 10))
LONG = st.sampled_from([0.05, 0.2, 0.5])


@st.composite
def planes(draw: st.DrawFn) -> System:
    """A cubic field with a Hopf point at the origin for p = 0, which orbits leave for p > 0."""
    monomials = [X**i * Y ** (k - i) for k in (2, 3) for i in range(k + 1)]
    quadratic = [sum(draw(COEFFICIENT) * m for m in monomials) for _ in range(2)]
    damped = -(X**2 + Y**2) * 2
    return System((X, Y), (P * X - Y + quadratic[0] + damped * X, X + P * Y + quadratic[1] + damped * Y), (P,))


@settings(max_examples=6, deadline=None)
@given(planes(), LONG)
def test_no_period_doubles_in_a_plane(system: System, most: float) -> None:
    assert_no_multiplier_is_negative(system, most)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(planes(), LONG)
def test_no_period_doubles_in_many_planes(system: System, most: float) -> None:
    assert_no_multiplier_is_negative(system, most)


def assert_no_multiplier_is_negative(system: System, most: float) -> None:
    equilibria = EquilibriumContinuation(EquilibriumEquations.from_system(system, ["p"], {}), (-0.5, 0.5), Steps(most=0.05))
    hopf = next(p for p in equilibria.follow_branch(equilibria.start([0.0, 0.0], -0.3)).special if p.kind == "hopf")
    cycles = Cycles.of(
        system, "p", {}, (-1.0, 1.0), periods=(0.0, 60.0), steps=Steps(**(vars(STEPS) | {"most": most, "points": 60}))
    )
    try:
        first = cycle_at_hopf(cycles, hopf)
    except RunError:  # where the Hopf point is degenerate
        return
    points: list[Cycle] = [first, *cycles.walk(first)]
    assert not {DOUBLING, TORUS} & {p.kind for p in points}
    assert not any(p.hidden_point is not None and p.hidden_point.kind in (DOUBLING, TORUS) for p in points)
    assert all(p.logarithms[0].imag == 0 for p in points)


Drawn = tuple[list[sp.Rational], int, int, sp.Rational, sp.Rational]
WAVES = (1, X, Y, X * Y, X**2)
MEANS = (1.0, 0.0, 0.0, 0.0, 0.5)  # of these over the circle


SYMMETRIC = st.tuples(
    st.lists(COEFFICIENT, min_size=5, max_size=5), st.integers(5, 20), st.integers(3, 30), COEFFICIENT, COEFFICIENT
)


@settings(max_examples=6, deadline=None)
@given(SYMMETRIC, st.sampled_from([0.02, 0.1, 0.5]))
def test_where_a_symmetry_breaks_two_branches_cross(drawn: Drawn, most: float) -> None:
    assert_its_symmetry_breaks(drawn, most)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(SYMMETRIC, st.sampled_from([0.02, 0.1, 0.5]))
def test_where_many_symmetries_break_two_branches_cross(drawn: Drawn, most: float) -> None:
    assert_its_symmetry_breaks(drawn, most)


def assert_its_symmetry_breaks(drawn: Drawn, most: float) -> None:
    """The orbit r = 1 in z = 0, in coordinates bent evenly in z; z' = z (b(x, y) + g p - z^2) grows on the mean from p* on."""
    rates, gain, speed, even, odd = drawn
    growth = sum(c * w for c, w in zip(rates, WAVES, strict=True)) + sp.Rational(gain, 10) * P
    critical = -sum(float(c) * m for c, m in zip(rates, MEANS, strict=True)) * 10 / gain
    changes = {X: even * Z**2 + odd * Y**2 / 3}
    states = (X, Y, Z)
    turn = sp.Rational(speed, 10)
    straight = ((1 - SQUARE) * X - turn * Y, turn * X + (1 - SQUARE) * Y, (growth - Z**2) * Z)
    system = System(states, bent(states, straight, changes), (P,))
    steps = Steps(**(vars(STEPS) | {"most": most}))
    cycles = Cycles.of(system, "p", {}, (critical - 0.35, critical + 0.45), accuracy=1e-9, steps=steps)
    tau = np.linspace(0, 1, 61)
    x, y = np.cos(2 * np.pi * tau), np.sin(2 * np.pi * tau)
    samples = np.array([x + float(odd) * y**2 / 3, y, 0 * y])
    first = cycle_near(cycles, 2 * math.pi / float(turn) * tau, samples, critical - 0.3)
    points = list(cycles.walk(first if first.point.tangent[-1] > 0 else cycles.backwards(first)))
    special = [(p.kind, p.parameter) for p in points if p.kind]
    assert special == [("branch-point", pytest.approx(critical, abs=1e-8))]
