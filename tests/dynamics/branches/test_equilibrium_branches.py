"""Stretches of stability of branches of steady states."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.branches.bifurcation_diagram import BranchFindings, NominalState, _searched_values
from wucht.dynamics.branches.equilibrium_branches import (
    EquilibriumBranch,
    StabilityLevel,
    _kind,
    _turns_at_a_branch_point,
    describe_end,
    is_duplicate,
    lies_on,
    points_with_value,
)
from wucht.dynamics.branches.plane_regions import PlanePoint
from wucht.dynamics.branches.second_parameter import (
    BifurcationCurve,
    SecondParameter,
    _describe_curve_end,
    curve_starts,
    curve_through,
    fold_crossings,
    lies_on_curve,
)
from wucht.dynamics.branches.steady_states import Kind
from wucht.errors import RunError


def branch(growth: list[float], kinds: list[str], share: tuple[float, ...] = ()) -> EquilibriumBranch:
    """Points at 0, 1, 2, ... with one exponent each, beside a fast one that decays."""
    n = len(growth)
    exponents = np.array([growth, [-1.0] * n], complex)
    return EquilibriumBranch(np.array([[0.0] * n, np.arange(n)]), exponents, tuple(kinds), ("", ""), stable_share=share)


def test_where_stability_changes_without_a_point_is_told() -> None:
    located = branch([-0.1, 0.0, 0.1], ["", "fold", ""])
    assert located.intervals(StabilityLevel.STABLE) == [(0, 1)] and located.unlocated_changes == []
    missed = branch([-0.1, -0.1, 0.1, 0.1], [""] * 4)
    assert missed.intervals(StabilityLevel.STABLE) == [(0, 1)] and missed.unlocated_changes == [(1, 2)]
    unresolved = branch([-0.1, 0.0, 0.1], ["", "unresolved", ""])
    assert unresolved.intervals(StabilityLevel.STABLE) == [(0, 1)] and unresolved.unlocated_changes == [(0, 2)]
    neutral = branch([0.1, 0.0, 1e-12, -1e-12, -0.1], ["", "branch-point", "", "", ""])
    assert neutral.intervals(StabilityLevel.STABLE) == [(1, 4)] and neutral.unlocated_changes == []
    assert branch([-0.1, 1e-12, -0.1], [""] * 3).intervals(StabilityLevel.STABLE) == [(0, 2)]
    assert branch([0.0, 0.0], [""] * 2).intervals(StabilityLevel.STABLE) == []


def test_a_family_is_stable_where_all_of_its_members_are() -> None:
    """Whatever the exponents of the one that stands for all."""
    kinds = ["", "some-stable", "", "all-stable", ""]
    family = branch([0.1, 0.1, -0.1, 0.1, -0.1], kinds, (0.0, 0.1, 0.5, 1.0, 1.0))
    assert family.intervals(StabilityLevel.STABLE) == [(3, 4)] and family.intervals(StabilityLevel.PARTLY_STABLE) == [(1, 3)]
    assert family.unlocated_changes == []


def test_the_length_of_a_branch_and_the_points_at_a_value() -> None:
    """Pieces (3, 4) and (0, 2) in units of (2, 4): sqrt(1.5^2 + 1) and 0.5."""
    zigzag = EquilibriumBranch(np.array([[0.0, 3.0, 3.0], [0.0, 4.0, 2.0]]), np.zeros((1, 3)), ("",) * 3, ("", ""))
    assert zigzag.length(np.array([2.0, 4.0])) == pytest.approx(3.25**0.5 + 0.5)
    assert [u.tolist() for u in zigzag.crossings(3.0)] == [[2.25, 3.0], [3.0, 3.0]]
    assert list(zigzag.crossings(4.5)) == []


@pytest.mark.parametrize(
    ("x", "value", "expected"),
    [
        (0.5, 2.0, "the range ends"), (0.5, -2.0, "the range ends"), (0.5, 2 - 3e-9, "the range ends"),
        (0.5, 2 - 5e-9, "near"), (0.5, -2 + 3.9e-3, "near"), (0.5, -2 + 4.1e-3, "at here: why"),
        (1 - 9e-9, 0.0, "limit"), (-1 + 9e-9, 2.0, "limit"), (1 - 1.1e-8, 0.0, "at here: why"),
    ],
)  # fmt: skip
def test_why_a_branch_ends(x: float, value: float, expected: str) -> None:
    """Of a state of size 10 within -1 to 1 and a parameter of size 4 within -2 to 2: 1e-9 of the size is on a bound."""
    equations = SimpleNamespace(scale=np.array([10.0, 4.0]))
    equilibria: Any = SimpleNamespace(equations=equations, bounds=(-2.0, 2.0), limits={0: (-1.0, 1.0)})
    sentence = describe_end(equilibria, "here", lambda _: "limit", np.array([x, value]), "why")
    near = "it is followed to here: nearer to the end of the range the equations are singular"
    assert sentence == (near if expected == "near" else expected)


def test_a_fold_beside_a_branch_point_is_a_pitchfork() -> None:
    """Within 1e-4 of the scale in every unknown."""
    scale = np.array([2.0, 1.0])
    crossing = SimpleNamespace(kind="branch-point", unknowns=np.array([1.0, 1.0]))
    hopf = SimpleNamespace(kind="hopf", unknowns=np.array([3.0, 3.0]))
    along: Any = SimpleNamespace(equations=SimpleNamespace(scale=scale), special=[crossing, hopf])

    def turns(kind: str, *u: float) -> bool:
        return _turns_at_a_branch_point(along, SimpleNamespace(kind=kind, unknowns=np.array(u)))  # type: ignore[arg-type]

    assert turns("fold", 1 - 1.9e-4, 1 + 9e-5) and not turns("fold", 1 - 2.1e-4, 1.0) and not turns("fold", 1.0, 1 + 1.1e-4)
    assert not turns("hopf", 1.0, 1.0) and not turns("fold", 3.0, 3.0)


def along(values: list[float], x: list[float], kinds: list[str] | None = None, **more: Any) -> EquilibriumBranch:
    n = len(values)
    return EquilibriumBranch(np.array([x, values]), np.full((1, n), -1.0 + 0j), tuple(kinds or [""] * n), ("", ""), **more)


def exactly(size: float = 1.0) -> Any:
    """States whose Newton's method does not move a guess, and fails beyond x = 8; the same within 1e-6."""

    def start(x: np.ndarray, value: float) -> Any:
        if x[0] > 8:
            raise RunError("none")
        return SimpleNamespace(unknowns=np.append(x, value))

    equilibria = SimpleNamespace(start=start, equations=SimpleNamespace(scale=np.array([size, 1.0])))
    return SimpleNamespace(equilibria=equilibria, is_same=lambda u, v: bool(np.abs(u - v).max() < 1e-6))


def test_points_of_a_branch_at_a_value() -> None:
    """Twice through the same state counts once; where Newton's method fails there is none."""
    back = along([0.0, 2.0, 0.0, 2.0], [0.0, 2.0, 4.0, 2.0])
    assert [p.unknowns.tolist() for p in points_with_value(exactly(), back, 1.0)] == [[1.0, 1.0], [3.0, 1.0]]
    assert points_with_value(exactly(), along([0.0, 2.0], [8.5, 9.0]), 1.0) == []


def test_a_state_lies_on_a_branch_of_isolated_states() -> None:
    line, family = along([0.0, 2.0], [0.0, 4.0]), along([0.0, 2.0], [1.0, 1.0], dimension=1)
    assert lies_on(exactly(), [family, line], np.array([2.0, 1.0])) and lies_on(exactly(), [line], np.array([4.0, 2.0]))
    assert not lies_on(exactly(), [line], np.array([2.1, 1.0])) and not lies_on(exactly(), [family], np.array([1.0, 1.0]))
    assert not lies_on(exactly(), [line], np.array([4.2, 2.1])) and not lies_on(exactly(), [], np.array([2.0, 1.0]))


def test_a_branch_that_is_known_or_only_a_point() -> None:
    """At 0.12, 0.3, 0.7, 0.88 of its regular points all must lie on known ones: 2, 7, 16, 21 of 0 to 24."""
    known, p = [along([0.0, 30.0], [0.0, 3.0])], np.arange(25.0)
    x = 0.1 * p
    assert is_duplicate(exactly(), known, along(p.tolist(), x.tolist()))
    for k in range(25):
        other = x.copy()
        other[k] += 0.5
        assert is_duplicate(exactly(), known, along(p.tolist(), other.tolist())) is (k not in (2, 7, 16, 21))
    assert is_duplicate(exactly(), [], along([1.0, 1.0], [0.0, 9e-7])) and not is_duplicate(
        exactly(), [], along([1.0, 1.0], [0, 2e-6])
    )
    assert not is_duplicate(exactly(0.5), [], along([1.0, 1.0], [0.0, 9e-7]))
    assert is_duplicate(exactly(), [], along([0.0, 1.0], [0.0, 1.0], ["fold", "fold"]))


def test_the_name_of_a_branch_is_that_of_all_its_states() -> None:
    """At nine regular points at most, the first and the last among them; the larger number of equal states counts."""

    def named(of: list[Kind], kinds: list[str] | None = None) -> Kind:
        states: Any = SimpleNamespace(kind=lambda u: of[int(u[-1])])
        return _kind(states, along(list(range(len(of))), [0.0] * len(of), kinds))

    a, b = Kind("in line", "x", (1, 2), 3), Kind("in line", "x", (2, 1), 6)
    assert named([a] * 4) == a and named([a, a, b]) == Kind("in line", "x", None, 6) == named([b, a, a])
    assert named([a, Kind("together", "x", (1, 2), 1)]) == Kind(None, None, (1, 2), 3)
    assert named([a, a, b], ["", "", "fold"]) == a
    many = [a] * 33
    for k, same in ((0, False), (32, False), (4, False), (3, True), (5, True)):
        assert (named([*many[:k], b, *many[k + 1 :]]) == a) is same


def test_searched_values_are_the_middles_of_parts_and_one_near_each_end() -> None:
    """Evenly; over more than a decade of positive values in a constant ratio."""
    assert _searched_values((0.0, 4.0), 2) == pytest.approx((0.004, 1.0, 3.0, 3.996))
    assert _searched_values((1.0, 100.0), 2) == pytest.approx((1.099, 100**0.25, 100**0.75, 99.901))
    assert _searched_values((1.0, 10.0), 1) == pytest.approx((1.009, 5.5, 9.991))
    assert _searched_values((-1.0, 100.0), 1)[1] == pytest.approx(49.5)


def test_the_stability_of_a_state_or_of_the_members_of_a_family() -> None:
    growing, u = np.array([0.1, -1.0], complex), np.zeros(2)
    assert NominalState(u, growing, 0).stability == StabilityLevel.UNSTABLE
    assert NominalState(u, -growing[:1], 0).stability == StabilityLevel.STABLE
    assert NominalState(u, growing, 0, 1.0).stability == StabilityLevel.STABLE
    assert NominalState(u, -growing[:1], 0, 0.5).stability == StabilityLevel.PARTLY_STABLE


def test_no_more_than_a_hundred_branches_at_one_second_value() -> None:
    """Those of another value do not count; the last one that fits brings the sentence."""
    line = along([0.0, 1.0], [0.0, 1.0])
    findings = BranchFindings(branches=tuple([replace(line, second=1.0)] * 98 + [replace(line, second=2.0)] * 5))
    assert len(findings.branches_at(1.0)) == 98 and len(findings.branches_at(2.0)) == 5 and findings.branches_at(None) == []
    more = findings.with_branch(line, "", 1.0)
    assert not more.is_full(1.0) and more.omissions == () and more.branches[-1].second == 1.0
    full = more.with_branch(line, "", 1.0)
    assert full.is_full(1.0) and not full.is_full(2.0) and len(full.omissions) == 1


def test_curves_start_at_folds_and_hopf_points_of_isolated_states() -> None:
    line = along([0.0, 1.0, 2.0, 3.0], [5.0, 6.0, 7.0, 8.0], ["", "fold", "hopf", "branch-point"], kind=Kind("together"))
    family = along([0.0, 1.0], [5.0, 6.0], ["fold", ""], dimension=1)
    starts = curve_starts([family, line])
    assert [(special, kind.name, u.tolist()) for special, kind, u in starts] == [
        ("fold", "together", [6.0, 1.0]), ("hopf", "together", [7.0, 2.0]),
    ]  # fmt: skip


SECOND = SecondParameter("q", (0.0, 4.0), 1.0)


def two_parameters() -> Any:
    """A state of size 10 and p of size 2, whose ordinate is ten times the state, of size 100."""
    equations = SimpleNamespace(scale=np.array([10.0, 2.0]), n=1, parameter_names=("p", "q"))
    return SimpleNamespace(
        path="p", bounds=(0.0, 2.0), ordinate_size=100.0, end_reason=lambda _: "limit", equations_with=lambda *_: equations,
        equilibria=SimpleNamespace(equations=equations, bounds=(0.0, 2.0), limits={}),
        ordinate=lambda u: 10 * u[0],
    )  # fmt: skip


def curve(x: list[float], p: list[float], q: list[float], bifurcation: str = "fold", name: str = "a") -> BifurcationCurve:
    n = len(x)
    return BifurcationCurve(bifurcation, Kind(name), np.array([x, p, q]), ("",) * n, ({},) * n, ("", ""))


def test_a_special_point_lies_on_a_curve() -> None:
    """At the second parameter's value, within a tenth of the piece there: its length is 1/4 in q alone, (1/4, 1/2) with p."""
    straight, steep = curve([3.0, 3.0], [1.0, 1.0], [0.5, 1.5]), curve([3.0, 3.0], [0.5, 1.5], [0.5, 1.5])
    states = two_parameters()
    for away, on in ((0.049, True), (0.051, False), (-0.049, True), (-0.051, False)):
        assert lies_on_curve(states, SECOND, straight, "fold", np.array([3.0, 1 + away])) is on
    for away, on in ((0.11, True), (-0.11, True), (0.114, False)):
        assert lies_on_curve(states, SECOND, steep, "fold", np.array([3.0, 1 + away])) is on
    for away, on in ((0.24, True), (0.26, False), (-0.24, True), (-0.26, False)):
        assert lies_on_curve(states, SECOND, straight, "fold", np.array([3 + away, 1.0])) is on
    assert not lies_on_curve(states, SECOND, straight, "hopf", np.array([3.0, 1.0]))
    assert not lies_on_curve(states, SECOND, curve([3.0, 3.0], [1.0, 1.0], [1.5, 2.5]), "fold", np.array([3.0, 1.0]))
    near = curve([3.0, 3.0], [1.0, 1.0], [1.0, 1.0])
    assert lies_on_curve(states, SECOND, near, "fold", np.array([3.0, 1 + 1.9e-5]))
    assert not lies_on_curve(states, SECOND, near, "fold", np.array([3.0, 1 + 2.1e-5]))


def test_why_a_curve_ends() -> None:
    """At either end of the second range, of the first one, or for a reason of its continuation."""
    states = two_parameters()
    for q in (0.0, 4.0, 3.9e-9, 4 - 3.9e-9):
        assert _describe_curve_end(states, SECOND, "why", np.array([0.0, 1.0, q])) == "the range ends"
    assert _describe_curve_end(states, SECOND, "why", np.array([0.0, 1.25, 4.5e-9])) == "at p = 1.25, q = 4.5e-09: why"
    assert _describe_curve_end(states, SECOND, "why", np.array([0.0, 2.0, 1.5])) == "the range ends"


def test_where_folds_of_one_name_cross(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each crossing once, begun from the middle of the pieces that cross; not those of other names, nor of Hopf points."""
    given = list[tuple[float, float, list[float]]]()

    class Pairs:
        def __init__(self, _equations: Any, bounds: Any) -> None:
            assert bounds == ((0.0, 2.0), (0.0, 4.0))

        def nearest_pair(self, first: np.ndarray, second: np.ndarray, at: np.ndarray) -> np.ndarray:
            given.append((float(first[0]), float(second[0]), at.tolist()))
            if first[0] > 50:
                raise RunError("far")
            return np.array([first[0], second[0], 0.5, 0.75])

    monkeypatch.setattr("wucht.dynamics.branches.second_parameter.FoldPairs", Pairs)
    rising, falling = curve([1.0, 2.0], [0.0, 1.0], [0.0, 1.0]), curve([5.0, 6.0], [0.0, 1.0], [1.0, 0.5])
    others = [curve([1.0, 2.0], [0.0, 1.0], [1.0, 0.5], name="b"), curve([1.0, 2.0], [0.0, 1.0], [1.0, 0.5], "hopf")]
    found = fold_crossings(two_parameters(), SECOND, [rising, *others, falling])
    assert given == [(1.0, 5.0, [0.0, 0.5])]
    (point,) = found
    assert isinstance(point, PlanePoint) and (point.x, point.y) == (0.5, 0.75) and np.isnan(point.value)
    lost = fold_crossings(
        two_parameters(), SECOND, [replace(rising, unknowns=rising.unknowns + np.array([[60.0], [0.0], [0.0]])), falling]
    )
    assert len(lost) == 1 and isinstance(lost[0], str) and "p = 0, q = 0.5" in lost[0]


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize(("bifurcation", "solver"), [("fold", "Folds"), ("hopf", "HopfPoints")])
def test_a_curve_through_a_special_point(monkeypatch: pytest.MonkeyPatch, bifurcation: str, solver: str, closed: bool) -> None:
    """Begun at the second parameter's value; coefficients of special points alone; each end in words unless it is closed."""
    u = np.array([[1.0, 2.0, 3.0], [0.5, 1.0, 1.5], [0.0, 2.0, 3.0]])
    points = [SimpleNamespace(kind=kind, coefficients={"a": number}) for kind, number in (("", 1.0), ("cusp", 2.0), ("", 3.0))]
    ends = ("it is closed", "it is closed") if closed else ("first", "last")

    class Solver:
        def __init__(self, equations: Any, bounds: Any, steps: Any, limits: Any) -> None:
            assert (equations, bounds, steps, limits) == (("q", 4.0), ((0.0, 2.0), (0.0, 4.0)), "steps", {0: (-9.0, 9.0)})

        def start(self, x: np.ndarray, parameters: tuple[float, float]) -> str:
            assert x.tolist() == [7.0] and parameters == (0.25, 1.0)
            return "start"

        def follow_curve(self, start: str) -> Any:
            assert start == "start"
            return SimpleNamespace(points=points, unknowns=u, ends=ends, is_closed=closed)

    monkeypatch.setattr(f"wucht.dynamics.branches.second_parameter.{solver}", Solver)
    states = two_parameters()
    states.equations_with = lambda path, width: (path, width)
    states.equilibria = SimpleNamespace(
        equations=states.equilibria.equations, bounds=(0.0, 2.0), limits={0: (-9.0, 9.0)}, steps="steps"
    )
    made = curve_through(states, SECOND, bifurcation, Kind("a"), np.array([7.0, 0.25]))
    assert (made.bifurcation, made.kind, made.kinds) == (bifurcation, Kind("a"), ("", "cusp", ""))
    assert made.coefficients == ({}, {"a": 2.0}, {}) and made.unknowns is u
    assert made.ends == (ends if closed else ("the range ends", "at p = 1.5, q = 3: last"))
