"""Branches of steady states with numbers by hand: special points, growing disturbances, what searches show, labels."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, BranchFindings, NominalState
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.special_states import special_states
from wucht.dynamics.branches.steady_states import Kind, StatesAtValue
from wucht.files.user_system import UserSystem

PAIRS = [-3.0 + 5j, -3.0 - 5j, 0.001 + 7j, 0.001 - 7j]


@cache
def case() -> BranchCase:
    line = UserSystem.from_formulas({"x": "mu - x"}, {"mu": 5.0})
    return BranchCase.of(line, "mu", (1.0, 10.0), points=1, ranges={"x": (-2.0, 22.0)})


def branch(low: float, high: float, exponents: Any = None, **other: Any) -> EquilibriumBranch:
    """Ten points; x is twice the parameter."""
    values = np.linspace(low, high, 10)
    rates = np.full((4, 10), -1.0, complex) if exponents is None else exponents
    return EquilibriumBranch(np.stack([2 * values, values]), rates, **{"kinds": ("",) * 10, "ends": ("",) * 2} | other)


def test_special_points_of_several_branches_count_once_with_their_frequency() -> None:
    """That of a Hopf point is of the pair nearest to the imaginary axis, of those that oscillate."""
    exponents = np.full((4, 10), -1.0, complex)
    exponents[:, 4] = PAIRS
    exponents[0, 6] = np.nan
    hopf = branch(1, 10, exponents, kinds=("",) * 4 + ("hopf", "", "branch-point") + ("",) * 3)
    crossing = branch(7, 16, kinds=("branch-point",) + ("",) * 9)
    elsewhere = replace(crossing, unknowns=crossing.unknowns + np.array([[1.0], [0.0]]))
    points = special_states(case(), (hopf, crossing, elsewhere))
    assert [(p.kind, p.unknowns.tolist(), p.speed, p.branch, p.frequency) for p in points] == [
        ("hopf", [10.0, 5.0], 10.0, 0, 7.0), ("branch-point", [14.0, 7.0], 14.0, 0, None),
        ("branch-point", [15.0, 7.0], 15.0, 2, None),
    ]  # fmt: skip


def test_limits_of_stable_members_have_a_frequency_if_what_grows_there_oscillates() -> None:
    exponents = np.full((4, 10), -1.0, complex)
    exponents[:, 4], exponents[:, 6] = PAIRS, [*PAIRS[:2], 0.001, -1.0]
    kinds = ("",) * 4 + ("some-stable", "", "all-stable") + ("",) * 3
    points = special_states(case(), (branch(1, 10, exponents, kinds=kinds, dimension=1, stable_share=(0.5,) * 10),))
    assert [(p.kind, p.frequency) for p in points] == [("some-stable", 7.0), ("all-stable", None)]


def test_growing_disturbances_are_counted_against_the_fastest_of_the_branch() -> None:
    exponents = np.array([[1.0] * 5 + [-1.0] * 5, [2.0] * 3 + [1e-12] * 4 + [-1.0] * 3], complex)
    assert branch(1, 10, exponents).unstable.tolist() == [2] * 3 + [1] * 2 + [0] * 5


def test_exponents_from_the_fastest_growth_on() -> None:
    exponents = np.array([-3.0, -1.0 + 2j, np.nan, -1.0 - 2j, 0.5])
    assert NominalState(np.array([4.0, 5.0]), exponents, 0).fastest_exponents.tolist() == [0.5, -1 + 2j, -1 - 2j, -3]


def test_searches_show_what_is_known_at_all_values() -> None:
    low = StatesAtValue(1.0, complete=True, evidence="first", speeds=(2.0, 8.0))
    high = StatesAtValue(3.0, complete=True, evidence="second", speeds=(1.0, 7.0))
    failing = StatesAtValue(2.0, failure="why")
    whole = BranchFindings((low, high))
    assert whole.knows_all_states and whole.evidence("rad/s") == "first; over all of them speeds from 1 to 8 rad/s"
    doubtful = BranchFindings((low, replace(high, complete=False)))
    assert not doubtful.knows_all_states and doubtful.evidence("").startswith("second;")
    assert not BranchFindings((low, failing)).knows_all_states
    assert not BranchFindings().knows_all_states and BranchFindings().evidence("") == ""


@pytest.mark.parametrize(
    ("kind", "label"),
    [
        ((None, "II", (3, 1)), "steady states"), (("opposed", None, (3, 1)), "opposed 3 : 1"),
        (("opposed", None, (1, 1)), "opposed"), (("together", None, (3, 1)), "together"),
        (("opposed", "III", (2, 1)), "type III: opposed"),
    ],
)  # fmt: skip
def test_labels_of_states(kind: Any, label: str) -> None:
    assert Kind(*kind).label == label
