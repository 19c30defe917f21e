"""Branches of orbits of normal forms: both sides of a fold, branches that cross, and orbits at a value."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from wucht.dynamics.branches.orbit_branches import StoredOrbit
from wucht.dynamics.branches.orbit_diagram import (
    OrbitCase,
    OrbitFindings,
    follow_orbits,
    reported_orbit,
)
from wucht.dynamics.work import Work
from wucht.errors import RunError
from wucht.numerics.periodic.branch_ends import CLOSED_BRANCH, RANGE, significant_value
from wucht.system import System

X, Y, P, S = sp.symbols("x y p s", real=True)
SQUARE = X**2 + Y**2
GROWTH = P + S * SQUARE - SQUARE**2
# Orbits r^2 = s/2 +- sqrt(s^2/4 + p), of the period 2 pi/(1 + r^2), from the Hopf point p = 0 to the fold p = -s^2/4 and on.
FORM = System((X, Y), (X * GROWTH - Y * (1 + SQUARE), Y * GROWTH + X * (1 + SQUARE)), (P, S))
EQUATIONS = wucht.UserSystem(FORM, {"p": 0.1, "s": 1.0})
BOUNDS = (-0.6, 0.5)


def case_of(**settings: Any) -> OrbitCase:
    return OrbitCase.of(EQUATIONS, "p", BOUNDS, {"x": 1.0}, run_values=(0.3,), values=(-0.2,), **settings)


@cache
def followed() -> OrbitFindings:
    return list(follow_orbits(case_of(), Work()))[-1]


def square(p: float, side: int) -> float:
    return 0.5 + side * (0.25 + p) ** 0.5


def test_the_orbits_at_a_value_on_both_sides_of_the_fold() -> None:
    """With their periods, extents, and exponents r dG/dr = 2 r^2 (s - 2 r^2)."""
    orbits = {round(o.period, 6): o for _, o in followed().orbits if not o.kind}
    assert len(orbits) == 2
    for side in (-1, 1):
        r2 = square(-0.2, side)
        orbit = orbits[round(2 * np.pi / (1 + r2), 6)]
        assert orbit.value == -0.2 and (orbit.high, orbit.low) == pytest.approx((r2**0.5, -(r2**0.5)), rel=1e-6)
        assert orbit.exponents.real == pytest.approx([2 * r2 * (1 - 2 * r2)], rel=1e-6)
    (fold,) = [o for _, o in followed().orbits if o.kind]
    assert (fold.kind, fold.value) == ("fold", pytest.approx(-0.25, abs=1e-8))


Z, W = sp.symbols("z w", real=True)
TURN = X * (1 - SQUARE) - Y, Y * (1 - SQUARE) + X  # to the circle r = 1, once round in 2 pi


def crossing(*rates: sp.Expr) -> OrbitFindings:
    """Branches over p from -0.4 to 0.4, with those that cross; rates: of z - x^2/5, w - y^2/5, which are zero on the first."""
    waves = (2 * X * TURN[0] / 5, 2 * Y * TURN[1] / 5)[: len(rates)]
    system = System((X, Y, Z, W)[: 2 + len(rates)], (*TURN, *(a + b for a, b in zip(rates, waves, strict=True))), (P,))
    equations, start = wucht.UserSystem(system, {"p": -0.3}), {"x": 1.0, "z": 0.2}
    case = OrbitCase.of(equations, "p", (-0.4, 0.4), start, run_values=(-0.3,), values=(0.2,), switch=True, show="z")
    *_, findings = follow_orbits(case, Work())
    assert findings.omissions == () and len(findings.branches) == 2
    assert findings.branches[0].stable_ranges == [(-0.4, pytest.approx(0.0, abs=1e-9))]
    assert findings.branches[1].stable_ranges == [(pytest.approx(0.0, abs=1e-4), 0.4)]
    return findings


def test_a_branch_of_mirror_images_that_crosses() -> None:
    """s' = s (p - s^2): s = sqrt(p) branches off at 0, of which one image is followed; there disturbances decay with -2 p."""
    s = Z - X**2 / 5
    findings = crossing(s * (P - s**2))
    assert findings.branches[1].seed.origin.startswith("the branch point at p = ")
    flat, raised = (o for _, o in findings.orbits if not o.kind)
    assert flat.exponents.real == pytest.approx([0.2, -2.0], abs=1e-6)
    assert raised.exponents.real == pytest.approx([-0.4, -2.0], abs=1e-6)
    assert (raised.low + raised.high, flat.period, raised.period) == (
        pytest.approx(flat.low + flat.high + 2 * np.sign(raised.low) * 0.2**0.5, abs=1e-6), *[pytest.approx(2 * np.pi)] * 2
    )  # fmt: skip


def test_a_branch_of_twice_the_period() -> None:
    """Disturbances turn by half a turn in a period, along one direction s' = s (p - s^2), across it they decay with -2."""
    u, v, mean, half = Z - X**2 / 5, W - Y**2 / 5, (P - 2) / 2, (P + 2) / 2
    growth = mean - u**2 - v**2
    findings = crossing(growth * u + half * (X * u + Y * v) - v / 2, growth * v + half * (Y * u - X * v) + u / 2)
    assert findings.branches[1].seed.origin.startswith("the period doubling at p = ")
    once, twice = (o for _, o in findings.orbits if not o.kind)
    assert (once.period, twice.period) == pytest.approx((2 * np.pi, 4 * np.pi))
    assert twice.exponents.real == pytest.approx([-0.4, -2.0, -2.2], abs=1e-5)


def stable_ranges(stable: list[int], special: str = "", closed: bool = False, backward: bool = True, last: float = 6.0) -> Any:
    """Of a branch over 3, 1, 2, 5, 4, which ends at 0.5 before its first orbit and at ``last`` behind its last."""
    (known,) = followed().branches
    values, unstable, special = np.array([3.0, 1.0, 2.0, 5.0, 4.0]), 1 - np.array(stable), special or "0" * len(stable)
    kinds = tuple("torus" if mark == "1" else "" for mark in special)
    end = replace(known.ends[-1], parameter=last, kind=CLOSED_BRANCH if closed else RANGE)
    ends = (replace(end, parameter=0.5), end) if backward else (end,)
    return replace(known, values=values, unstable=unstable, kinds=kinds, ends=ends).stable_ranges


def test_ranges_of_stable_orbits_go_to_the_ends_of_the_branch() -> None:
    assert stable_ranges([1, 1, 0, 1, 1]) == [(0.5, 3.0), (4.0, 6.0)]
    assert stable_ranges([0, 1, 1, 1, 0]) == [(1.0, 5.0)]
    assert stable_ranges([1, 0, 0, 0, 0], backward=False) == [(3.0, 3.0)]
    assert stable_ranges([0, 0, 0, 0, 0]) == []


def test_ranges_of_stable_orbits_reach_to_special_orbits() -> None:
    assert stable_ranges([0, 0, 1, 0, 0], "01010") == [(1.0, 5.0)], "with the special orbits at its ends"
    assert stable_ranges([0, 0, 0, 1, 0], "01000") == [(5.0, 5.0)], "a special orbit alone is none"
    assert stable_ranges([0, 1, 0, 0, 0], "01000") == []


def test_a_closed_branch_is_stable_on_either_side_of_its_first_orbit() -> None:
    """The larger of both sides, whichever it is."""
    closed: dict[str, Any] = {"closed": True, "backward": False}
    assert stable_ranges([1, 1, 0, 1, 1], **closed) == [(1.0, 6.0)]
    assert stable_ranges([1, 1, 0, 1, 1], **closed, last=0.25) == [(0.25, 5.0)]
    assert stable_ranges([1, 0, 1, 1, 0], **closed) == [(3.0, 3.0), (2.0, 5.0)]
    assert stable_ranges([0, 1, 0, 1, 1], **closed) == [(1.0, 1.0), (4.0, 6.0)]


def test_a_rounding_error_is_no_value_of_the_parameter() -> None:
    """0, where it is below 1e-12 of the range; a greater number is a value."""
    values = [significant_value(value, (-9.0, 4.0)) for value in (-8e-55, -8e-12, 1e-11, -8.76543)]
    assert values == [0.0, 0.0, 1e-11, -8.76543]
    assert significant_value(-8e-55, (-np.inf, np.inf)) == -8e-55, "without a range no number is small"


def kept_at(p: float) -> StoredOrbit:
    (branch,) = followed().branches
    regular = [o for o in branch.stored_orbits if not o.kind and o.period < 2 * np.pi / 1.5]
    return min(regular, key=lambda o: abs(o.value - p))


@pytest.mark.parametrize(("begin", "value"), [(0.4, -0.1), (-0.1, 0.4)])
def test_an_orbit_far_from_the_one_beside_it(begin: float, value: float) -> None:
    """Upwards or downwards the branch leads to the very value; below the fold, at -0.25, there is none."""
    problem, (branch,) = case_of().problem, followed().branches
    orbit = reported_orbit(problem, branch.seed, [kept_at(begin)], value)
    assert orbit.value == value
    assert orbit.period == pytest.approx(2 * np.pi / (1 + square(value, 1)), rel=1e-9)
    with pytest.raises(RunError, match="the branch does not lead to it"):
        reported_orbit(problem, branch.seed, [kept_at(begin)], -0.3)


@pytest.mark.slow
@pytest.mark.parametrize("value", [-0.2499999, -0.2499, -0.245, -0.01, -0.001])
def test_both_orbits_beside_a_fold_and_a_hopf_point(value: float) -> None:
    """Each side once, as near as 1e-7 to the fold at -0.25, where Newton's method leads to either; 0 is the Hopf point."""
    case = replace(case_of(), values=(value,))
    *_, findings = follow_orbits(case, Work())
    orbits = sorted((o for _, o in findings.orbits if not o.kind), key=lambda o: o.high)
    assert findings.omissions == () and [o.value for o in orbits] == [value, value]
    for orbit, side in zip(orbits, (-1, 1), strict=True):
        assert orbit.high == pytest.approx(square(value, side) ** 0.5, abs=1e-9)
        assert orbit.period == pytest.approx(2 * np.pi / (1 + square(value, side)), rel=1e-9)
