"""How far a family is followed: as far as the unbalances compensate each other, either way."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.branches import family_curve
from wucht.dynamics.branches.equilibrium_branches import ALL_STABLE, SOME_STABLE, EquilibriumBranch
from wucht.dynamics.branches.family_curve import FamilyCurve, _Members

OPEN = "beyond, the unbalances cannot compensate each other"


def point(value: float, speed: float = 50.0) -> Any:
    return SimpleNamespace(unknowns=np.array([speed, value]), x=np.array([speed]), parameter=value, kind="")


def followed(monkeypatch: pytest.MonkeyPatch, low: float, high: float, at: float) -> EquilibriumBranch:
    """From a state at a value, on a branch of speeds over 0, 1, ... 9; the unbalances compensate from low to high."""
    equilibria = SimpleNamespace(
        equations=SimpleNamespace(scale=np.array([100.0, 9.0])),
        follow_branch=lambda _: SimpleNamespace(points=[point(float(value)) for value in range(10)]),
        start=lambda x, value: point(value, float(x[0])),
        evaluate=lambda start: start,
    )
    members = SimpleNamespace(phases=np.zeros((3, 1)), exponents=np.full((1, 2), -1.0 + 0j), share=1.0, first=0, last=0)
    monkeypatch.setattr(FamilyCurve, "_closes", lambda _, value: low <= value <= high)
    monkeypatch.setattr(FamilyCurve, "_members", lambda _, value, speed: members)
    monkeypatch.setattr(family_curve, "describe_ends", lambda *_: ("the low end", "the high end"))
    slow: Any = SimpleNamespace(
        path="p", names=("w", "a", "b"), point=lambda state, value: np.array([state.speed, *state.phases, value])
    )
    curve = FamilyCurve(slow)
    curve.__dict__["equilibria"] = equilibria
    return curve.follow_branch(State(50.0, np.zeros(3), 1), at)


@pytest.mark.parametrize("at", [3.0, 4.2, 6.0])
def test_it_ends_where_they_cannot_either_way(monkeypatch: pytest.MonkeyPatch, at: float) -> None:
    branch = followed(monkeypatch, 2.25, 6.625, at)
    assert branch.parameter_values == pytest.approx([2.25, 3, 4, 5, 6, 6.625], abs=1e-12)
    assert branch.ends == (OPEN, OPEN)


@pytest.mark.parametrize("at", [0.0, 5.0, 9.0])
def test_it_has_all_of_a_branch_on_which_they_always_can(monkeypatch: pytest.MonkeyPatch, at: float) -> None:
    branch = followed(monkeypatch, -1.0, 10.0, at)
    assert branch.parameter_values.tolist() == list(range(10))
    assert branch.ends == ("the low end", "the high end")


def test_one_side_may_be_open_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    below = followed(monkeypatch, -1.0, 1.5, 0.0)
    assert below.parameter_values == pytest.approx([0, 1, 1.5], abs=1e-12) and below.ends == ("the low end", OPEN)
    above = followed(monkeypatch, 7.5, 10.0, 9.0)
    assert above.parameter_values == pytest.approx([7.5, 8, 9], abs=1e-12) and above.ends == (OPEN, "the high end")


def test_a_limit_of_stability_is_shown_by_the_member_that_changes_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first member to be stable is member 1, the last is member 2; elsewhere member 0 represents the family."""
    sample = _Members(np.arange(9.0).reshape(3, 3), np.array([[-1.0, -9.0], [-5.0, -9.0], [-0.5, -9.0]]) + 0j)
    limits = [(45.0, 4.25, sample, SOME_STABLE), (46.0, 4.5, sample, ""), (47.0, 4.75, sample, ALL_STABLE)]
    monkeypatch.setattr(FamilyCurve, "_changes", lambda _, a, b: limits if a.parameter == 4.0 else [])
    branch = followed(monkeypatch, -1.0, 10.0, 5.0)
    assert branch.kinds[4:9] == ("", SOME_STABLE, "", ALL_STABLE, "")
    columns = [[45.0, 1.0, 4.0, 7.0, 4.25], [46.0, 0.0, 3.0, 6.0, 4.5], [47.0, 2.0, 5.0, 8.0, 4.75]]
    assert branch.unknowns[:, 5:8].T.tolist() == columns
    assert branch.exponents[0, 5:8].tolist() == [-5.0, -1.0, -0.5]


def test_the_members_that_decay_fastest_and_most_slowly() -> None:
    """By the largest exponent of each, the first; and the share that is stable."""
    exponents = np.array([[-2.0, -3.0], [-5.0 + 1j, -5.0 - 1j], [0.5, -9.0], [-1.0, -1.0]])
    sample = _Members(np.zeros((3, 4)), exponents)
    assert (sample.first, sample.last, sample.share) == (1, 2, 0.75)


def test_states_of_a_family_where_its_branch_passes_a_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the speed to which the equations lead from the branch's; a branch is the same family at that speed and dimension."""
    branch = EquilibriumBranch(np.array([[40.0, 60.0], [0.0, 2.0]]), np.zeros((1, 2)), ("", ""), ("", ""), dimension=1)
    sample = SimpleNamespace(phases=np.array([[0.25, 9.0], [0.5, 9.0]]), exponents=np.array([[-1.0], [-9.0]]), share=0.5)
    slow: Any = SimpleNamespace(
        fastest=100.0, state=lambda u: SimpleNamespace(speed=u[0]), point=lambda s, v: np.array([s.speed, *s.phases, v])
    )
    curve = FamilyCurve(slow)
    curve.__dict__["equilibria"] = SimpleNamespace(
        start=lambda x, value: SimpleNamespace(unknowns=np.array([x[0] + value, value]))
    )
    monkeypatch.setattr(FamilyCurve, "_members", lambda _, value, speed: sample)
    ((u, exponents, share),) = curve.states_at(branch, 1.0)
    assert (u.tolist(), exponents.tolist(), share) == ([51.0, 0.25, 0.5, 1.0], [-1.0], 0.5)
    for speed, dimension, same in ((51.00009, 1, True), (51.0002, 1, False), (50.99991, 1, True), (51.0, 2, False)):
        assert curve.is_same_family(branch, State(speed, np.zeros(2), dimension), 1.0) is same
    assert not curve.is_same_family(branch, State(51.0, np.zeros(2), 1), 3.0)
