"""How far a family is followed: as far as the unbalances compensate each other, either way."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.branches import family_curve
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.family_curve import FamilyCurve

OPEN = "beyond, the unbalances cannot compensate each other"


def point(value: float, speed: float = 50.0) -> Any:
    return SimpleNamespace(unknowns=np.array([speed, value]), x=np.array([speed]), parameter=value, kind="")


def followed(monkeypatch: pytest.MonkeyPatch, low: float, high: float, at: float) -> EquilibriumBranch:
    """From a state at a value, on a branch of speeds over 0, 1, ... 9; the unbalances compensate from low to high."""
    equilibria = SimpleNamespace(
        equations=SimpleNamespace(scale=np.array([100.0, 9.0])),
        branch=lambda _: SimpleNamespace(points=[point(float(value)) for value in range(10)]),
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
    return curve.branch(State(50.0, np.zeros(3), 1), at)


@pytest.mark.parametrize("at", [3.0, 4.2, 6.0])
def test_it_ends_where_they_cannot_either_way(monkeypatch: pytest.MonkeyPatch, at: float) -> None:
    branch = followed(monkeypatch, 2.25, 6.625, at)
    assert branch.values == pytest.approx([2.25, 3, 4, 5, 6, 6.625], abs=1e-12)
    assert branch.ends == (OPEN, OPEN)


@pytest.mark.parametrize("at", [0.0, 5.0, 9.0])
def test_it_has_all_of_a_branch_on_which_they_always_can(monkeypatch: pytest.MonkeyPatch, at: float) -> None:
    branch = followed(monkeypatch, -1.0, 10.0, at)
    assert branch.values.tolist() == list(range(10))
    assert branch.ends == ("the low end", "the high end")


def test_one_side_may_be_open_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    below = followed(monkeypatch, -1.0, 1.5, 0.0)
    assert below.values == pytest.approx([0, 1, 1.5], abs=1e-12) and below.ends == ("the low end", OPEN)
    above = followed(monkeypatch, 7.5, 10.0, 9.0)
    assert above.values == pytest.approx([7.5, 8, 9], abs=1e-12) and above.ends == (OPEN, "the high end")
