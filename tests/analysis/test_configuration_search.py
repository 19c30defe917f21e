"""The search for steady phase configurations from many starts, what it says, and what may be wrong with its states."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations import search as module
from wucht.analysis.configurations.averaged_stability import Stability
from wucht.analysis.configurations.closed_form import State, fixed_speed_states
from wucht.analysis.configurations.configuration import name_of, residual_unbalance
from wucht.analysis.configurations.search import (
    index,
    search_by_subdivision,
    search_from_many_starts,
    speeds_in_line,
)
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.configurations.torus import TorusProblem
from wucht.files.building import machine_from
from wucht.machines.structure import SPEED
from wucht.piecewise import PiecewiseCubic, interpolated_pieces, step

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


@pytest.mark.usefixtures("few")
def test_more_bodies_are_sought_from_many_starts_until_no_index_is_missing(
    monkeypatch: pytest.MonkeyPatch, two: SteadyTorques, driven: SteadyTorques
) -> None:
    monkeypatch.setattr(module, "_MOST_PROVED", 1)
    found = module.search(two, 0.0, 0.0)
    assert same(found.states, fixed_speed_states(two, 100.0)) and not found.complete
    assert found.evidence.endswith("completeness is not proved, but their indices add up to 0, as they must")
    assert module.search(driven, 1.0, 110.0).evidence.endswith("completeness is not proved")


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


DRUM = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
TWO_BALLS = [
    {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02, "name": f"b{k}", "mass": m}
    for k, m in enumerate((0.008, 0.006))
]


def problem(damping: float, **torques: Any) -> TorusProblem:
    carrier = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": [damping, 1.5 * damping]}
    return TorusProblem(SteadyTorques.of(machine_from({"carrier": carrier, "bodies": [DRUM, *TWO_BALLS], **torques})))


LINEAR = {"drive": {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}}
# So steep that the vibration hardly counts.
STEEP = {"drive": {"kind": "table", "points": [[0, 1e6], [105, 9e5], [112, 8e5], [118, -9e5], [400, -1e6]]}}
ROUNDED = LINEAR | {
    "load": {"kind": "table", "points": [[0, 1e3], [112, 2e3], [118, 9e5], [400, 1e6]], "transition_speed": 0.1}
}


@pytest.mark.parametrize("damping", [40.0, 3000.0])
@pytest.mark.parametrize("torques", [STEEP, ROUNDED], ids=["steep", "rounded"])
@pytest.mark.parametrize(("wide", "turn"), [(0.0, 0.3), (2.0, 1e-3), (2.0, 0.3)], ids=["phases", "speed", "both"])
def test_no_change_of_the_jacobian_within_a_box_exceeds_its_bound(
    damping: float, torques: dict[str, Any], wide: float, turn: float
) -> None:
    torus = problem(damping, **torques)
    rng = np.random.default_rng(3)
    centre = np.concatenate([rng.uniform(-3, 3, (2, 100)), rng.uniform(95, 130, (1, 100))])
    radius = np.repeat([[turn], [turn], [wide]], 100, axis=1)
    bound, here = torus.spread(centre, radius), torus.jacobian(centre)
    assert np.isfinite(bound).all()
    corner = rng.choice([-1.0, 1.0], (3, 100)) * radius
    for share in (0.3, 1.0):
        change = np.abs(torus.jacobian(centre + share * corner) - here)
        assert (change <= bound * (1 + 1e-6) + 1e-9 * np.abs(here).max()).all()


@pytest.mark.parametrize("bend", [1, -1])
def test_at_a_kink_of_a_torque_the_slopes_of_both_sides_are_within_the_bound(bend: int) -> None:
    """Its slope falls, or rises, by 2e5 at 100: from a little below and a little above."""
    of = problem(40.0, **LINEAR).torques
    kink = PiecewiseCubic(SPEED, interpolated_pieces("kink", [0.0, 100.0, 400.0], [0.0, 0.0, bend * 300 * 2e5], "linear"))
    torus = TorusProblem(replace(of, shaft_torques=(of.shaft_torques[0] + kink, *of.shaft_torques[1:])))
    for side in (-1, 1):
        centre, radius = np.array([[0.3], [2.0], [100.0 + side]]), np.array([[0.0], [0.0], [1.5]])
        bound, here = torus.spread(centre, radius), torus.jacobian(centre)
        change = np.abs(torus.jacobian(centre - side * radius) - here)
        assert change[0, 2] == pytest.approx(2e5, rel=1e-2)
        assert (change <= bound * (1 + 1e-6)).all()
        assert bound[0, 2] < 3e5


def test_names_of_configurations() -> None:
    """Together within an eighth of a turn, opposed within one of half a turn; what is left of the unbalance must be nothing."""
    balls = torques(0.004, 0.004)
    rotors = [ROTOR, ROTOR | {"name": "other"}]
    drives = [MOTOR | {"on": n} for n in ("drum", "other")]
    pair = SteadyTorques.of(machine_from({"carrier": CARRIER, "bodies": rotors, "drives": drives}))
    for apart, name in ((0.78, "together"), (0.79, None), (2.35, None), (2.36, "opposed")):
        assert name_of(pair, State(1.0, np.array([0.0, apart])), None) == name
    for phases, residual, name in (
        ([0.0, 2.0, 4.0], 0.0, "compensating"),
        ([0.0, 2.0, 4.0], 1e-30, None),
        ([0.0, 0.78, 0.1], 0.5, "together"),
        ([0.0, 0.79, 0.1], 0.5, None),
    ):
        assert name_of(balls, State(1.0, np.array(phases)), residual) == name
    left = residual_unbalance(balls, np.array([3.0, -2.0, 1.0]), np.array([0.0, 0.0, math.pi / 2]))
    assert left == pytest.approx(math.sqrt(2.0))


@pytest.mark.parametrize(("slowest", "stable"), [(-0.51, True), (0.51, False), (-0.49, None), (0.49, None), (-0.6 + 3j, True)])
def test_stability_is_open_within_what_is_neutral(slowest: complex, stable: bool | None) -> None:
    found = Stability.from_exponents(np.array([slowest, -2.0], complex), 0.5, "near zero")
    assert (found.stable, found.reason == "", found.leading) == (stable, stable is not None, slowest)
