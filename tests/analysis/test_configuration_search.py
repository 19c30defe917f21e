"""The search for steady phase configurations from many starts, what it says, and what may be wrong with its states."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations import search as module
from wucht.analysis.configurations.closed_form import State, fixed_speed_states
from wucht.analysis.configurations.search import (
    StateSearch,
    all_states,
    index,
    search_by_subdivision,
    search_from_many_starts,
    speeds_in_line,
)
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.files.building import machine_from
from wucht.machines.structure import SPEED
from wucht.piecewise import PiecewiseCubic, step

ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
CARRIER = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": [40.0, 60.0]}
HELD = {"kind": "constant-speed", "speed": 100.0}
MOTOR = {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}


def torques(*unbalances: float, drive: dict[str, Any] = HELD) -> SteadyTorques:
    common = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    balls = [common | {"name": f"b{k}", "mass": u / 0.5} for k, u in enumerate(unbalances)]
    return SteadyTorques.of(machine_from({"carrier": CARRIER, "bodies": [ROTOR, *balls], "drive": drive}))


@pytest.fixture(scope="module")
def two() -> SteadyTorques:
    """Two unequal balls that cannot compensate: four states in line."""
    return torques(0.004, 0.003)


@pytest.fixture(scope="module")
def driven() -> SteadyTorques:
    return torques(0.004, drive=MOTOR)


def same(states: list[State], others: list[State]) -> bool:
    def apart(a: State, b: State) -> float:
        return max(float(np.abs(np.exp(1j * a.phases) - np.exp(1j * b.phases)).max()), abs(a.speed - b.speed) / a.speed)

    return len(states) == len(others) and all(min(apart(a, b) for b in others) < 1e-8 for a in states)


# --- from many starts ---


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tenth of the starts: enough for some bodies."""
    monkeypatch.setattr(module, "_STARTS", 60)
    monkeypatch.setattr(module, "_ROUNDS", 2)


@pytest.mark.usefixtures("few")
def test_many_starts_find_the_states_in_closed_form(two: SteadyTorques) -> None:
    closed = fixed_speed_states(two, 100.0)
    found = search_from_many_starts(two, 0.0, 0.0, [])
    assert same(found, closed) and len(closed) == 4
    assert [s.phases.tolist() for s in found] == sorted(s.phases.tolist() for s in found)
    assert all((s.phases >= 0).all() and (s.phases < 2 * math.pi).all() and s.multiplicity == 1 for s in found)


@pytest.mark.usefixtures("few")
def test_equal_balls_are_one_state_with_several_ways() -> None:
    equal = torques(0.004, 0.004)
    found = search_from_many_starts(equal, 0.0, 0.0, [])
    assert sorted(s.multiplicity for s in found) == [1, 1, 2]
    assert all(s.phases[1] <= s.phases[2] for s in found)


@pytest.mark.usefixtures("few")
def test_known_states_are_kept_and_the_user_is_heard(two: SteadyTorques) -> None:
    known, heard = fixed_speed_states(two, 100.0)[:2], list[int]()
    found = search_from_many_starts(two, 0.0, 0.0, known, watch=lambda: heard.append(1))
    assert len(found) == 4 and len(heard) == 2

    def stop() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search_from_many_starts(two, 0.0, 0.0, known, watch=stop)


def test_other_seeds_give_other_starts(monkeypatch: pytest.MonkeyPatch, two: SteadyTorques, driven: SteadyTorques) -> None:
    monkeypatch.setattr(module, "_STARTS", 5)
    monkeypatch.setattr(module, "_ROUNDS", 1)
    starts = list[np.ndarray]()
    monkeypatch.setattr(module, "_newton", lambda problem, x, low, high: starts.append(x) or x[:, :0])
    for seed in (0, 0, 1):
        search_from_many_starts(two, 0.0, 0.0, [], seed)
    search_from_many_starts(driven, 50.0, 60.0, [])
    assert np.array_equal(starts[0], starts[1]) and not np.isclose(starts[0], starts[2]).any()
    assert starts[0].shape == (2, 5) and (starts[0] >= 0).all() and 3.0 < np.max(starts[:3]) < 2 * math.pi
    assert starts[3].shape == (2, 5) and (starts[3][1] >= 50).all() and (starts[3][1] <= 60).all()


@pytest.mark.usefixtures("few")
def test_with_a_motor_the_speed_is_sought_too(driven: SteadyTorques) -> None:
    """Within the range alone, and as subdivision finds all of them."""
    complete = search_by_subdivision(driven, 1.0, 110.0)
    assert complete.complete and len(complete.states) >= 2
    assert same(search_from_many_starts(driven, 1.0, 110.0, []), complete.states)
    speeds = [s.speed for s in complete.states]
    above = (speeds[0] + speeds[-1]) / 2
    assert same(search_from_many_starts(driven, above, 110.0, []), [s for s in complete.states if s.speed >= above])


@pytest.mark.usefixtures("few")
def test_what_does_not_balance_is_no_state(monkeypatch: pytest.MonkeyPatch, two: SteadyTorques) -> None:
    monkeypatch.setattr(SteadyTorques, "is_balanced", lambda *_: False)
    assert search_from_many_starts(two, 0.0, 0.0, []) == []


# --- what a search says ---


def test_states_that_do_not_balance_are_counted_and_left_out(monkeypatch: pytest.MonkeyPatch, two: SteadyTorques) -> None:
    whole = all_states(two, 0.0, 0.0)
    assert whole.complete and len(whole.states) == 4
    wrong = whole.states[1].phases
    real = SteadyTorques.is_balanced
    monkeypatch.setattr(SteadyTorques, "is_balanced", lambda self, w, at: real(self, w, at) and at is not wrong)
    monkeypatch.setattr(module.closed_form, "fixed_speed_states", lambda *_: whole.states)
    left = all_states(two, 0.0, 0.0)
    assert left == StateSearch([whole.states[k] for k in (0, 2, 3)], False, left.evidence)
    assert left.evidence == f"{whole.evidence}; 1 more do not satisfy the torque balance"


def test_what_subdivision_leaves_open_is_sought_from_many_starts(monkeypatch: pytest.MonkeyPatch, two: SteadyTorques) -> None:
    given = list[Any]()
    first, *rest = fixed_speed_states(two, 100.0)
    monkeypatch.setattr(
        module, "search_by_subdivision", lambda *_, watch=None: StateSearch([first], False, "some boxes are open")
    )
    monkeypatch.setattr(module, "search_from_many_starts", lambda *of, watch=None: given.append(of) or [first, *rest])
    assert module.search(two, 1.0, 2.0) == StateSearch([first, *rest], False, "some boxes are open")
    assert given == [(two, 1.0, 2.0, [first])]


def single(drive: dict[str, Any]) -> SteadyTorques:
    return SteadyTorques.of(machine_from({"carrier": CARRIER, "bodies": [ROTOR], "drive": drive}))


@pytest.mark.parametrize("sense", [1, -1])
def test_a_single_rotor_has_its_working_points(monkeypatch: pytest.MonkeyPatch, sense: int) -> None:
    """On a grid where subdivision does not decide: at the speeds that it finds where it does."""
    alone = single(MOTOR | {"no_load_speed": sense * 110.0})
    complete = search_by_subdivision(alone, 1.0, 120.0)
    assert complete.complete and complete.states
    monkeypatch.setattr(module, "search_by_subdivision", lambda *_, watch=None: StateSearch([], False, "some boxes are open"))
    found = module.search(alone, 1.0, 120.0)
    assert (found.complete, found.evidence) == (False, "some boxes are open")
    assert [s.speed for s in found.states] == pytest.approx([s.speed for s in complete.states], rel=1e-6)
    assert all(s.phases.tolist() == [0.0] for s in found.states)
    least = found.states[-1].speed
    assert [s.speed for s in module.search(alone, least + 0.5, 120.0).states] == []


@pytest.mark.parametrize(
    ("indices", "given", "calls", "shown"),
    [
        ([0], True, 1, "192 starts: completeness is not proved, but their indices add up to 0, as they must"),
        (
            [2, -1, 0], True, 3,
            "576 starts: completeness is not proved, but their indices add up to 0, as they must",
        ),
        (
            [2] * 6, True, 6,
            "1152 starts: completeness is not proved; their indices add up to 2 and not to 0: at least one is "
            "missing",
        ),
        ([], False, 1, "192 starts: completeness is not proved"),
    ],
)  # fmt: skip
def test_more_bodies_are_sought_until_no_index_is_missing(
    monkeypatch: pytest.MonkeyPatch, two: SteadyTorques, driven: SteadyTorques, indices: list[int], given: bool, calls: int,
    shown: str,
) -> None:  # fmt: skip
    of, asked = two if given else driven, list[Any]()
    monkeypatch.setattr(module, "_MOST_PROVED", 1)
    monkeypatch.setattr(module, "_STARTS", 64)
    monkeypatch.setattr(module, "_ROUNDS", 3)
    state, totals = State(100.0, np.zeros(3)), iter(indices)

    def starts(t: Any, low: float, high: float, known: list[State], seed: int, watch: Any) -> list[State]:
        asked.append((low, high, len(known), seed))
        return [*known, state]

    monkeypatch.setattr(module, "search_from_many_starts", starts)
    monkeypatch.setattr(module, "index", lambda *_: next(totals))
    found = module.search(of, 1.0, 2.0)
    assert not found.complete and found.evidence == f"Newton's method from {shown}"
    assert asked == [(1.0, 2.0, k, k) for k in range(calls)] and len(found.states) == calls


def test_indices_of_all_states_add_up_to_zero(two: SteadyTorques) -> None:
    states = fixed_speed_states(two, 100.0)
    each = [index(two, [s]) for s in states]
    assert sorted(each) == [-1, -1, 1, 1] and index(two, states) == 0 and index(two, []) == 0
    assert [index(two, [replace(s, multiplicity=3)]) for s in states] == [3 * k for k in each]


def test_in_line_nothing_is_shown_where_a_torque_jumps() -> None:
    of = torques(0.012, 0.008, drive=MOTOR)
    jumps = replace(
        of, shaft_torques=(PiecewiseCubic(SPEED, step("torque", 60.0, 50.0, 5.0)) - SPEED / 20, *of.shaft_torques[1:])
    )
    assert speeds_in_line(jumps, 1.0, 120.0) is None
