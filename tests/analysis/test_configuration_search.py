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
def test_with_a_motor_the_speed_is_sought_too(driven: SteadyTorques) -> None:
    """Within the range alone, and as subdivision finds all of them."""
    complete = search_by_subdivision(driven, 1.0, 110.0)
    assert complete.complete and len(complete.states) >= 2
    assert same(search_from_many_starts(driven, 1.0, 110.0, []), complete.states)
    speeds = [s.speed for s in complete.states]
    above = (speeds[0] + speeds[-1]) / 2
    assert same(search_from_many_starts(driven, above, 110.0, []), [s for s in complete.states if s.speed >= above])


# --- what a search says ---


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
