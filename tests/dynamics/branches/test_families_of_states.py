"""Families of compensating states of three equal pendulums: as far as the force polygon closes; which members are stable."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.branches import family_curve
from wucht.dynamics.branches.averaged_equilibria import AveragedEquilibria
from wucht.dynamics.branches.bifurcation_diagram import BranchCase, BranchFindings, follow_branches
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.family_curve import FamilyCurve
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

MEMBERS = 24


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer members than 512 are looked at, here alone."""
    monkeypatch.setattr(family_curve, "SAMPLED_MEMBERS", MEMBERS)


def balanced(**drive: Any) -> Machine:
    pendulum = {"kind": "pendulum", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.05}
    return machine_from({
        "carrier": {"mass": 1.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03, "bearing_damping": 1e-4},
            *({"name": f"b{i}"} | pendulum for i in range(3)),
        ],
        "drive": {"on": "drum", "kind": "linear", "slope": 0.01, "no_load_speed": 180.0} | drive,
    })  # fmt: skip


@cache
def diagram(path: str, low: float, high: float) -> tuple[BranchCase, BranchFindings, list[tuple[int, int]]]:
    """With how many values are searched and how many branches are there, stage by stage."""
    case = BranchCase.of(balanced(), path, (low, high), points=2, only=("compensating",))
    stages = list(follow_branches(case, Work()))
    return case, stages[-1], [(len(s.searches), len(s.branches)) for s in stages]


def family_of(path: str, low: float, high: float) -> tuple[FamilyCurve, EquilibriumBranch]:
    case, findings, _ = diagram(path, low, high)
    (branch,) = findings.branches
    assert isinstance(case.steady_states, AveragedEquilibria)
    return FamilyCurve(case.steady_states), branch


SLOPE, ECCENTRICITY = ("drive.slope", 1e-4, 0.05), ("drum.eccentricity", 0.002, 0.006)


def speed_at(slope: np.ndarray) -> np.ndarray:
    """Without vibration the drive holds the bearing's damping alone."""
    return np.asarray(180.0 * slope / (slope + 1e-4))


def test_it_is_followed_at_the_speed_without_vibration() -> None:
    """Once, though it is met at each value that is searched; with the dimension 1."""
    _, branch = family_of(*SLOPE)
    assert (branch.kind.name, branch.dimension, branch.ends) == ("compensating", 1, ("the range ends",) * 2)
    assert branch.parameter_values[[0, -1]] == pytest.approx([1e-4, 0.05]) and (np.diff(branch.parameter_values) > 0).all()
    np.testing.assert_allclose(
        branch.unknowns[3:-1], np.broadcast_to(speed_at(branch.parameter_values), (4, len(branch.parameter_values))), rtol=1e-9
    )
    stages = diagram(*SLOPE)[2]
    assert [count for _, count in stages][-1] == 1 and stages[0] == (1, 0)
    # 0.009 + 0.01 (e^ia + e^ib + e^ic) = 0, the drum's phase being zero.
    np.testing.assert_allclose(0.009 + 0.01 * np.exp(1j * branch.unknowns[:3]).sum(axis=0), 0.0, atol=1e-9)


def test_its_members_gain_their_stability_one_after_another() -> None:
    """Where the first does, and where the last, a pair of its exponents is imaginary; between them a point with some."""
    _, branch = family_of(*SLOPE)
    assert branch.stable_share is not None
    some, all_ = (branch.kinds.index(kind) for kind in ("some-stable", "all-stable"))
    assert all_ == some + 2 and set(branch.kinds) == {"", "some-stable", "all-stable"}
    share = np.array(branch.stable_share)
    assert (share[:some] == 0).all() and share[some] == pytest.approx(1 / MEMBERS) and 0 < share[some + 1] < 1
    assert (share[all_:] == 1).all()
    for k in (some, all_):
        exponents = branch.exponents[:, k]
        assert np.isnan(exponents[-1]) and np.isfinite(exponents[:-1]).all()  # one less than states: across the family
        assert exponents[0].real == pytest.approx(0.0, abs=1e-6) and 5.0 < abs(exponents[0].imag) < 20.0
        assert exponents[1] == pytest.approx(exponents[0].conjugate(), abs=1e-9)
    natural = (1e5 / 10.3) ** 0.5
    assert 0.99 < branch.unknowns[3, some] / natural < branch.unknowns[3, all_] / natural < 1.1


def test_the_states_at_its_nominal_value() -> None:
    _, findings, _ = diagram(*SLOPE)
    (own,) = findings.nominal
    assert (own.branch, own.share) == (0, 1.0) and own.unknowns[-1] == 0.01
    assert own.unknowns[3] == pytest.approx(180.0 / 1.01, rel=1e-12)
    assert (own.exponents.real < 0).all() and len(own.exponents) == 6


def test_at_a_value_the_family_is_recognised_by_speed_and_dimension() -> None:
    family, branch = family_of(*SLOPE)
    speed = float(speed_at(np.array(0.02)))
    for given, dimension, same in ((speed, 1, True), (speed * (1 + 1e-4), 1, False), (speed, 2, False)):
        assert family.is_same_family(branch, State(given, np.zeros(4), dimension), 0.02) == same
    ((unknowns, exponents, share),) = family.states_at(branch, 0.02)
    assert (unknowns[3], unknowns[-1], share) == (pytest.approx(speed, rel=1e-12), 0.02, 1.0) and len(exponents) == 6
    assert family.states_at(branch, 0.06) == []


def test_it_ends_where_the_polygon_does_not_close() -> None:
    """Three times 0.01 kg m compensate 9 kg up to e = 1/300 m."""
    family, branch = family_of(*ECCENTRICITY)
    assert branch.parameter_values[[0, -1]] == pytest.approx([0.002, 0.03 / 9], rel=1e-8)
    assert branch.ends == ("the range ends", "beyond, the unbalances cannot compensate each other")
    assert branch.unknowns[3] == pytest.approx(
        np.full(len(branch.parameter_values), float(speed_at(np.array(0.01)))), rel=1e-12
    )
    # Beyond, no state is of its kind: neither at a value nor among those that are the same.
    assert family.states_at(branch, 0.005) == [] and not family.is_same_family(branch, State(178.2, np.zeros(4), 1), 0.005)
