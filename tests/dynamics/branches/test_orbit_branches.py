"""Branches of orbits of the normal form of a generalised Hopf point: which are the same, what is lost, orbits at a value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from wucht.dynamics.branches import bifurcation_diagram, orbit_branches, orbit_diagram
from wucht.dynamics.branches.bifurcation_diagram import BranchCase, BranchFindings, follow_branches
from wucht.dynamics.branches.orbit_branches import PeriodicBranch, StoredOrbit
from wucht.dynamics.branches.orbit_diagram import (
    OrbitCase,
    OrbitFindings,
    follow_orbits,
    orbits_beside,
    reported_orbit,
)
from wucht.dynamics.branches.steady_states import SystemEquilibria
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.numerics.periodic.branch_ends import CLOSED_BRANCH, RANGE, significant_value
from wucht.numerics.periodic.cycle import BRANCH_POINT, DOUBLING
from wucht.system import System

X, Y, P, S = sp.symbols("x y p s", real=True)
SQUARE = X**2 + Y**2
GROWTH = P + S * SQUARE - SQUARE**2
# Orbits r^2 = s/2 +- sqrt(s^2/4 + p), of the period 2 pi/(1 + r^2), from the Hopf point p = 0 to the fold p = -s^2/4 and on.
FORM = System((X, Y), (X * GROWTH - Y * (1 + SQUARE), Y * GROWTH + X * (1 + SQUARE)), (P, S))
EQUATIONS = wucht.UserSystem(FORM, {"p": 0.1, "s": 1.0})
RANGES = {"x": (-2.0, 2.0), "y": (-2.0, 2.0)}
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


def test_a_branch_passes_an_orbit_by_value_and_period() -> None:
    (branch,) = followed().branches
    values, periods = branch.values, branch.periods
    for k in (3, -4):
        value, period = float(values[k] + values[k + 1]) / 2, float(periods[k] + periods[k + 1]) / 2
        assert branch.passes(value, period) and branch.passes(value, 1.009 * period) and branch.passes(value, 0.991 * period)
        assert not branch.passes(value, 1.012 * period) and not branch.passes(value, 0.988 * period)
    assert not branch.passes(-0.3, 2 * np.pi / 1.5)


def small(*, values: list[float], periods: list[float], low: list[float], high: list[float]) -> PeriodicBranch:
    arrays = {"values": values, "periods": periods, "low": low, "high": high}
    return replace(followed().branches[0], **{name: np.array(row) for name, row in arrays.items()})  # type: ignore[arg-type]


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


def test_a_branch_from_another_of_its_special_points_is_known() -> None:
    """By the orbit in its middle: its period between neighbours, and its range at the nearest orbit, within a hundredth."""
    whole = small(values=[0, 1, 2, 3], periods=[4, 5, 6, 7], low=[-1, -2, -3, -4], high=[1, 2, 3, 4])
    part: dict[str, Any] = {"values": [1, 2.05, 3], "periods": [5, 6.05, 7], "low": [-2, -3, -4], "high": [2, 3, 4]}
    assert whole.is_same_branch(small(**part))
    for other in (
        part | {"periods": [5, 6.2, 7]}, part | {"low": [-2, -3.07, -4]}, part | {"high": [2, 3.07, 4]},
        part | {"values": [1, 3.05, 3]}, part | {"low": [-2, -2.93, -4], "high": [2, 2.93, 4]},
    ):  # fmt: skip
        assert not whole.is_same_branch(small(**other))
    assert whole.is_same_branch(small(**(part | {"low": [9, -3.02, 9], "high": [9, 3.02, 9]})))


def test_a_first_orbit_on_a_known_branch_is_not_followed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """But one that crosses a branch is, unless it leads to a known one."""
    (known,) = followed().branches
    case, findings, calls = case_of(), OrbitFindings(branches=(known,)), list[bool]()

    def half(_c: Any, _s: Any, onward: bool, _w: Any) -> Any:
        calls.append(onward)
        return known

    monkeypatch.setattr(orbit_diagram, "_half_branch", half)
    beside = replace(known.seed, value=float(known.values[4]), period=float(known.periods[4]))
    assert _finished(case, beside, findings).branches == (known,) and calls == []
    other = replace(known.seed, value=-0.2, period=9.0)
    made = _finished(case, other, findings)
    assert len(made.branches) == 2 and calls == [True, False]
    calls.clear()
    crossing = replace(beside, towards=np.ones(3))
    assert _finished(case, crossing, findings).branches == (known,) and calls == [True]


def test_branches_that_cross_either_half_of_one_are_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """One at an orbit onward and one backward, and one of which the reason why it is not followed is known."""
    (known,) = followed().branches
    first = replace(known.seed, value=-0.2, period=9.0)
    crossing = [replace(first, origin=f"crossing {k}", towards=np.ones(3)) for k in (1, 2)]
    offshoots = {("first", True): (crossing[0],), ("first", False): ("no orbit there", crossing[1])}
    calls = list[tuple[str, bool]]()

    def half(_c: Any, seed: Any, onward: bool, _w: Any) -> Any:
        calls.append((seed.origin, onward))
        away = 10.0 * len(calls)  # another branch each time
        return replace(known, seed=seed, values=known.values + away, offshoots=offshoots.get((seed.origin, onward), ()))

    monkeypatch.setattr(orbit_diagram, "_half_branch", half)
    made = _finished(case_of(), replace(first, origin="first"), OrbitFindings())
    assert calls == [("first", True), ("first", False), ("crossing 1", True), ("crossing 2", True)]
    assert [b.seed.origin for b in made.branches] == ["first", "crossing 1", "crossing 2"]
    assert made.omissions == ("no orbit there",)


def _finished(case: OrbitCase, seed: Any, findings: OrbitFindings) -> OrbitFindings:
    generator = orbit_diagram._follow_branch(case, seed, findings, Work())
    while True:
        try:
            next(generator)
        except StopIteration as stop:
            return stop.value


def test_a_branch_that_is_not_followed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*_: Any) -> None:
        raise RunError("no orbit")

    seed = followed().branches[0].seed
    monkeypatch.setattr(orbit_diagram, "half_branch", lost)
    found = _finished(case_of(), seed, OrbitFindings())
    assert found.branches == () and found.omissions == (f"the branch from {seed.origin} is not followed: no orbit",)


def test_steady_states_that_are_refused() -> None:
    """Of equations the refusal is that of the study: the table of ranges may be wrong."""
    with pytest.raises(InputError) as refused:
        case_of(ranges={"x": (-2.0, 2.0)})
    assert refused.value.location == "study.ranges"


def test_orbits_that_cannot_be_reported_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    case, (branch,) = case_of(), followed().branches
    last = [o for o in branch.stored_orbits if not o.kind]
    with pytest.raises(RunError, match="the branch does not lead to it"):
        reported_orbit(case.problem, branch.seed, [last[0]], -0.5)
    monkeypatch.setattr(orbit_diagram, "reported_orbit", lambda *_: "not there")
    *_, findings = follow_orbits(case, Work())
    assert (
        all(sentence.endswith(" is not reported: not there") for sentence in findings.omissions)
        and findings.omissions
        and findings.orbits == ()
    )


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


def test_orbits_beside_a_value_the_nearest_first() -> None:
    """Special ones are no beginning: the next one is, but for that beyond a fold."""

    def orbits(*values: float, kinds: Sequence[str]) -> Any:
        return [SimpleNamespace(value=v, kind=kind) for v, kind in zip(values, kinds, strict=True)]

    a, b, c = row = orbits(0.0, 1.0, 0.4, kinds=("", "", ""))
    assert (
        orbits_beside(row, 0.8) == [(b, a), (b, c)]
        and orbits_beside(row, 0.3) == [(a, b)]
        and orbits_beside(row, 1.0) == [(b,)]
    )
    a, _, b, _, c = row = orbits(0.0, 0.5, 0.9, 1.0, 0.4, kinds=("", "torus", "", "fold", ""))
    assert orbits_beside(row, 0.2) == orbits_beside(row, 0.3) == [(a, b)]
    assert orbits_beside(row, 0.95) == [(b,), (c,)]


@pytest.mark.parametrize(("ratio", "count"), [(1.0, 1), (1 + 1e-5, 2)])
def test_of_mirror_images_beside_a_branch_point_one_is_followed(
    monkeypatch: pytest.MonkeyPatch, ratio: float, count: int
) -> None:
    cycles: Any = SimpleNamespace(equations=SimpleNamespace(parameter_names=("T", "p")))
    sides = [SimpleNamespace(period=4.0, parameter=1.0), SimpleNamespace(period=4.0 * ratio, parameter=1.0)]
    monkeypatch.setattr(orbit_branches, "crossing_branch", lambda *_: sides)
    monkeypatch.setattr(orbit_branches, "doubled_branch", lambda *_: ("doubled", "first"))
    monkeypatch.setattr(orbit_branches.SeedOrbit, "from_cycle", lambda *given, **more: (*given, more))
    at: Any = SimpleNamespace(kind=BRANCH_POINT, parameter=0.25)
    found: Any = orbit_branches._offshoots(cycles, at)
    assert [f[1] for f in found] == sides[:count] and found[0][2] == "the branch point at p = 0.25"
    (twice,) = orbit_branches._offshoots(cycles, SimpleNamespace(kind=DOUBLING, parameter=0.25))  # type: ignore[arg-type]
    assert twice[:3] == ("doubled", "first", "the period doubling at p = 0.25")  # type: ignore[index]


def diagram() -> BranchCase:
    return BranchCase.of(EQUATIONS, "p", BOUNDS, points=1, ranges=RANGES)


def test_states_that_are_not_followed_are_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*_: Any) -> None:
        raise RunError("singular")

    monkeypatch.setattr(bifurcation_diagram, "branch_through", lost)
    *_, found = follow_branches(diagram(), Work())
    assert found.branches == () and set(found.omissions) == {
        f"a state at p = {value:.6g} is not followed: singular" for value in diagram().values
    }
    again = BranchFindings(omissions=found.omissions).with_branch("singular", f"p = {diagram().values[0]:.6g}", None)
    assert again.omissions == found.omissions


def test_a_search_that_is_impossible_is_recorded_with_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*_: Any) -> None:
        raise RunError("singular everywhere")

    monkeypatch.setattr(SystemEquilibria, "find_equilibria", lost)
    *_, found = follow_branches(diagram(), Work())
    assert [(s.value, s.failure, s.points, s.complete) for s in found.searches] == [
        (value, "singular everywhere", (), False) for value in diagram().values
    ]
    assert found.branches == found.omissions == () and not found.knows_all_states


def test_curves_that_are_not_followed_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    *_, found = follow_branches(diagram(), Work())
    second: Any = SimpleNamespace(path="s")
    monkeypatch.setattr(bifurcation_diagram, "curve_through", lambda *_: "no curve")
    shares = list[float]()
    work: Any = SimpleNamespace(report=lambda share, _: shares.append(share), unit=lambda _, make: make())
    stages = list(bifurcation_diagram._curves(diagram().steady_states, second, found, work))
    assert shares == [0.5 + 0.5 * k / len(shares) for k in range(len(shares))] and len(shares) == len(stages) > 0
    (sentence,) = stages[-1].omissions
    assert sentence.startswith("the hopf at p = ") and sentence.endswith(" is not followed as s changes: no curve")
    assert stages[-1].curves == ()


def test_a_whole_branch_has_its_first_orbit_once() -> None:
    """Backwards in reverse, without it."""

    def half(*values: Any) -> PeriodicBranch:
        return replace(
            followed().branches[0], values=np.array(values), logarithms=np.array([values, values]),
            kinds=tuple(map(str, values)), hidden_points=values, stored_orbits=values, ends=values[-1:], offshoots=values[-1:],
        )  # fmt: skip

    branch: Any = half(0.0, 1.0).with_backward(half(0.0, -1.0, -2.0))
    assert branch.values.tolist() == [-2.0, -1.0, 0.0, 1.0]
    assert branch.logarithms.tolist() == [[-2.0, -1.0, 0.0, 1.0]] * 2
    assert branch.kinds == ("-2.0", "-1.0", "0.0", "1.0")
    assert branch.hidden_points == branch.stored_orbits == (-2.0, -1.0, 0.0, 1.0)
    assert (branch.ends, branch.offshoots, branch.seed) == ((-2.0, 1.0), (1.0, -2.0), half(0.0).seed)


def test_the_share_of_the_work_of_each_second_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """Equal parts, of the first half where curves follow."""
    parts = list[tuple[str, float, float]]()

    def follow(_case: Any, findings: Any, _second: Any, _states: Any, part: Any) -> Any:
        parts.append(part)
        yield findings
        return findings

    def curves(_states: Any, _plane: Any, findings: Any, _work: Any) -> Any:
        yield findings
        return findings

    monkeypatch.setattr(bifurcation_diagram, "_follow_at_second", follow)
    monkeypatch.setattr(bifurcation_diagram, "_curves", curves)
    work: Any = SimpleNamespace(part=lambda *given: given, report=lambda _: None)
    for plane, half in ((None, 1.0), ("plane", 0.5)):
        parts.clear()
        case: Any = SimpleNamespace(states_by_second_value={1.0: "a", 2.0: "b"}, plane=plane, steady_states="a")
        assert list(follow_branches(case, work))[-1].complete
        assert parts == [("1.0", 0.0, half / 2), ("2.0", half / 2, half)]
