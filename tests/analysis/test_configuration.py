"""Names, types, order and verdicts of steady phase configurations, of torques and stabilities made by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations import averaged_stability, configuration
from wucht.analysis.configurations.averaged_stability import AveragedStability, Regions, Stability, regions
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.configuration import (
    Configuration,
    ConfigurationDescriber,
    name_of,
    residual_unbalance,
    type_of,
)

NO_RATES = np.empty(0, complex)
STABLE, UNSTABLE, OPEN = (Stability(stable, NO_RATES) for stable in (True, False, None))


def described(slow: Stability = OPEN, full: Stability = OPEN, **more: Any) -> Configuration:
    keys: dict[str, Any] = {
        "state": State(1.0, np.zeros(2)), "name": None, "type": None, "speed": 1.0, "phases": {}, "residual": None,
        "share": None, "amplitude": 0.0, "overlapping": False, "stable_share": None, "throw": None,
    }  # fmt: skip
    return Configuration(**keys | more, slow=slow, full=full)


@pytest.mark.parametrize(
    ("slow", "full", "verdict"),
    [
        (UNSTABLE, STABLE, "stable"),
        (STABLE, UNSTABLE, "unstable"),
        (STABLE, OPEN, "stable in the averaged equations only"),
        (UNSTABLE, OPEN, "unstable in the averaged equations only"),
        (OPEN, OPEN, "undecided"),
        (OPEN, STABLE, "stable"),
    ],
)
def test_the_full_equations_decide(slow: Stability, full: Stability, verdict: str) -> None:
    assert described(slow, full).verdict == verdict


def test_reasons_come_in_an_order() -> None:
    slow, full = Stability(None, NO_RATES, "slow"), Stability(None, NO_RATES, "full")
    assert described().reason is None
    assert described(full=full).reason == "full" and described(slow, full).reason == "slow"
    assert described(slow, full, disagreement="both").reason == "both"
    indifferent = described(slow, state=State(1.0, np.zeros(2), is_indifferent=True)).reason
    assert indifferent is not None and indifferent.endswith("; slow") and len(indifferent) > 40


def test_configurations_are_sorted_by_name_residual_and_speed() -> None:
    order = [
        described(name="compensating", residual=0.0, speed=2.0),
        described(name="together", residual=None, speed=9.0),
        described(name="together", residual=0.5, speed=1.0),
        described(name="together", residual=0.5, speed=2.0),
        described(name="together", residual=0.75, speed=1.0),
        described(name="opposed", residual=0.0, speed=0.0),
        described(name=None, residual=0.0, speed=0.0),
    ]
    mixed = [order[k] for k in (6, 2, 4, 0, 5, 3, 1)]
    assert sorted(mixed, key=lambda c: c.rank) == order


def torques(**more: Any) -> Any:
    given = {
        "size": 3,
        "heads": (0, 0, 0),
        "coefficients": None,
        "senses": np.ones(3),
        "is_coaxial": True,
        "classes": ((1, 2),),
    }
    return SimpleNamespace(**given | more)


TWO = {"size": 2, "heads": (0, 1), "senses": np.ones(2), "is_coaxial": False}


@pytest.mark.parametrize(
    ("given", "phases", "sides", "residual", "name"),
    [
        ({}, (0.0, 2.0, 4.0), (), 0.0, "compensating"),
        ({}, (0.0, 2.0, 4.0), (), 1e-30, None),
        (TWO, (0.0, math.pi), (), 0.0, "opposed"),
        (TWO | {"heads": (0, 0)}, (0.0, math.pi), (), 0.0, "compensating"),
        ({}, (0.0, 0.0, 0.0), (1, 1), 0.5, "together"),
        ({}, (0.0, 0.0, math.pi), (0, 1), 0.5, "opposed"),
        (TWO, (0.0, 0.78), (), None, "together"),
        (TWO, (0.0, 0.79), (), None, None),
        (TWO, (0.0, 2.35), (), None, None),
        (TWO, (0.0, 2.36), (), None, "opposed"),
        (TWO | {"senses": np.array([1.0, -1.0])}, (0.0, 0.1), (), None, None),
        (TWO | {"senses": np.array([1.0, -1.0]), "coefficients": np.ones(2)}, (0.0, 0.1), (), None, "together"),
        ({}, (0.0, 0.78, 0.1), (), 0.5, "together"),  # the chord of an eighth of a turn
        ({}, (0.0, 0.79, 0.1), (), 0.5, None),
        ({"is_coaxial": False}, (0.0, 0.1, 0.1), (), None, None),
    ],
)
def test_names(given: dict[str, Any], phases: Any, sides: Any, residual: float | None, name: str | None) -> None:
    assert name_of(torques(**given), State(1.0, np.array(phases), sides=sides), residual) == name


def test_types_are_those_of_a_rotor_with_two_equal_bodies() -> None:
    assert [type_of(torques(), n) for n in ("compensating", "together", "opposed", None)] == ["I", "II", "III", None]
    for other in ({"is_coaxial": False}, {"size": 4}, {"classes": ((1,), (2,))}):
        assert type_of(torques(**other), "together") is None


def test_the_residual_unbalance() -> None:
    unbalances = np.array([3.0, -2.0, 1.0])
    assert residual_unbalance(torques(), unbalances, np.array([0.0, 0.0, math.pi / 2])) == pytest.approx(math.sqrt(2.0))
    assert residual_unbalance(torques(), unbalances, np.array([0.0, 0.0, math.pi])) == 0.0
    assert residual_unbalance(torques(), np.array([1.0, 1.0 + 1e-8, 0.0]), np.array([0.0, math.pi, 0.0])) == pytest.approx(1e-8)
    assert residual_unbalance(torques(is_coaxial=False), unbalances, np.zeros(3)) is None


def of_family(monkeypatch: pytest.MonkeyPatch, rates: list[float], stable: bool | None) -> tuple[Stability, float | None, Any]:
    """The state itself and further members, by their fastest rates."""
    monkeypatch.setattr(configuration, "family_members", lambda _, count: np.full((2, len(rates) - 1), 5.0))
    given = list[np.ndarray]()
    averaged_stability = SimpleNamespace(
        stability=lambda state: Stability(stable, np.array([-1.0 + 0j])),
        exponents=lambda state, at: (given.append(at), np.array([rates, rates], complex).T * np.array([1.0, -1.0]))[1],
    )
    describer = object.__new__(ConfigurationDescriber)
    describer.averaged_stability, describer.torques = averaged_stability, torques()  # type: ignore[assignment]
    stability, share = describer._stability(State(1.0, np.array([0.0, 2.0]), dimension=1))
    return stability, share, given


def test_a_family_is_as_stable_as_its_members_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    stability, share, ((at,)) = of_family(monkeypatch, [-1.0, -2.0, -3.0, 4.0], True)
    assert (stability.stable, share) == (None, 0.75) and "75 %" in stability.reason
    assert at.shape == (2, 4) and at[:, 0].tolist() == [0.0, 2.0]
    for rates, stable, expected in (([-1.0, -2.0], True, 1.0), ([1.0, 2.0], False, 0.0)):
        stability, share, _ = of_family(monkeypatch, rates, stable)
        assert (stability.stable, share) == (stable, expected)
    stability, share, _ = of_family(monkeypatch, [-1.0, 2.0], None)
    assert (stability.stable, share, stability.reason) == (None, 0.5, "")


def test_phases_of_balancing_bodies_are_counter_clockwise_from_their_rotor() -> None:
    """A clockwise rotor's own angle is in its sense; that of a body about it is turned round."""
    describer = object.__new__(ConfigurationDescriber)
    bodies = [SimpleNamespace(name=n, about=a) for n, a in (("b", "second"), ("main", None), ("second", None), ("a", "main"))]
    describer.machine, describer.order = SimpleNamespace(bodies=bodies), [3, 0, 1, 2]  # type: ignore[assignment]
    describer.torques = torques(size=4, heads=(0, 1, 0, 1), senses=np.array([1.0, -1.0, 1.0, -1.0]))
    phases = describer._phases(State(1.0, np.array([0.0, 0.5, 4.0, 0.75])))
    assert phases == pytest.approx({"b": 2 * math.pi - 0.25, "second": 0.5, "a": 4.0})


@pytest.mark.parametrize(
    ("exponents", "neutral", "stable"),
    [
        ([-1.0, -2.0], 0.5, True), ([1.0, -2.0], 0.5, False), ([-0.5, -2.0], 0.5, None), ([0.5, -2.0], 0.5, None),
        ([-0.6 + 3j, -2.0], 0.5, True), ([], 0.5, True), ([np.nan, -1.0], 0.5, None),
    ],
)  # fmt: skip
def test_stability_by_the_fastest_growth(exponents: list[complex], neutral: float, stable: bool | None) -> None:
    found = Stability.from_exponents(np.array(exponents, complex), neutral, "near zero")
    assert found.stable is stable and (found.reason == "") is (stable is not None)
    assert found.leading == (exponents[0] if exponents else None) or np.isnan(exponents[0])


def test_regions_of_speed_and_ratio(monkeypatch: pytest.MonkeyPatch) -> None:
    """A state of each region at a ratio; which speeds it exists and is stable at."""
    speeds, given = np.array([10.0, 20.0, 30.0]), list[tuple[float, float]]()

    def with_ratio(speed: float, ratio: float) -> float:
        given.append((speed, ratio))
        return ratio

    base: Any = SimpleNamespace(
        with_fixed_speed=lambda speed: SimpleNamespace(with_ratio=lambda ratio: with_ratio(speed, float(ratio)))
    )
    exists = np.array([True, True, False])
    monkeypatch.setattr(
        averaged_stability,
        "_states",
        lambda ratio, at: iter([(0, np.zeros((2, 3)), np.ones(3, bool), 1), (2, np.full((2, 3), ratio), exists, 0)]),
    )
    monkeypatch.setattr(
        averaged_stability,
        "transverse_stability",
        lambda ratio, at, phases, dimension: (at > 15) if dimension else (phases[0] > 1),
    )
    made = regions(base, speeds, np.array([0.5, 2.0]))
    assert given == [(10.0, 0.5), (10.0, 2.0)]
    assert made.stable.shape == made.exists.shape == (4, 2, 3)
    assert made.exists[0].all() and made.exists[2].tolist() == [[True, True, False]] * 2 and not made.exists[[1, 3]].any()
    assert made.stable[0].tolist() == [[False, True, True]] * 2
    assert made.stable[2].tolist() == [[False] * 3, [True, True, False]]
    joined = Regions.from_tiles([made, Regions(speeds, np.array([3.0]), made.stable[:, :1], ~made.exists[:, :1])])
    assert joined.ratio.tolist() == [0.5, 2.0, 3.0] and joined.speed is speeds
    assert joined.exists[1].tolist() == [[False] * 3, [False] * 3, [True] * 3] and joined.stable.shape == (4, 3, 3)


def test_regions_of_branches(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is in line on one side adds to the rotor's unbalance or reduces it; on both it is opposed."""
    speeds = np.array([10.0, 20.0])
    phases = {(1, 1): np.array([[0.0, 0.0], [0.5, math.pi]]), (0, 1): np.array([[0.0, np.nan], [1.0, np.nan]])}
    branches = [SimpleNamespace(sides=sides, phases=lambda _, p=p: p) for sides, p in phases.items()]
    monkeypatch.setattr(averaged_stability, "branches", lambda torques, at: branches)
    monkeypatch.setattr(
        averaged_stability, "compensating_phases", lambda torques, spread: [(np.array([0.0, 3.0]), 2, None)] * 2
    )
    of: Any = SimpleNamespace(coefficients=np.array([1.0, 0.5]))
    made = list(averaged_stability._states(of, speeds))
    assert [(region, valid.tolist(), dimension) for region, _, valid, dimension in made] == [
        (0, [True, True], 2), (1, [True, False], 0), (2, [False, True], 0), (3, [True, False], 0),
    ]  # fmt: skip
    assert made[0][1].tolist() == [[0.0, 0.0], [3.0, 3.0]]


def test_exponents_by_the_matrices_of_the_machine_s_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    """With inertia and to first order in closed form, else of the averaged equations; a singular one has none."""
    states = list[tuple[float, list[float]]]()
    slow: Any = SimpleNamespace(
        inertia=True, order=1, values=lambda: "values",
        steady_state=lambda speed, at: (states.append((speed, at.tolist())), np.array([speed, at[1]]))[1],
    )  # fmt: skip
    matrices = np.array([np.diag([-1.0, 2.0, 1e-9]), np.full((3, 3), np.nan)])
    monkeypatch.setattr(
        averaged_stability, "averaged_matrices", lambda torques, speeds, phases: matrices * speeds[:, None, None]
    )
    made = AveragedStability(torques(), slow)
    state: Any = SimpleNamespace(interior_state=SimpleNamespace(speed=10.0), neutral=1, phases=np.array([0.0, 1.0]))
    first, second = made.exponents(state, np.zeros((2, 2)))
    assert first.real == pytest.approx([20.0, -10.0]) and np.isnan(second).all()
    for inertia, order in ((False, 1), (True, 2)):
        slow.inertia, slow.order = inertia, order
        made = AveragedStability(torques(), slow)
        vars(made)["_linear"] = lambda x, values: (None, np.moveaxis(matrices, 0, -1) * x[1])
        states.clear()
        (one, *_) = made.exponents(state, np.array([[0.0, 0.0], [3.0, 4.0]]))
        assert states == [(10.0, [0.0, 3.0]), (10.0, [0.0, 4.0])] and one.real == pytest.approx([6.0, -3.0])
