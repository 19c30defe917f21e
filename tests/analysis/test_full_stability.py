"""Stability of steady phase configurations in the full equations: families that creep, why models disagree."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations import full_stability as module
from wucht.analysis.configurations.averaged_stability import Stability
from wucht.analysis.configurations.closed_form import State, fixed_speed_states
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.synchronous_motion import SynchronousMotion, SynchronousMotions
from wucht.errors import WuchtError
from wucht.files.building import machine_from

ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
HELD = {"kind": "constant-speed", "speed": 100.0}


def stability(gravity: float = 0.0, damping: float = 40.0, count: int = 2, sense: int = 1) -> FullStability:
    ball = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    balls = [ball | {"name": f"b{k}", "mass": 0.02 + 0.01 * k} for k in range(count)]
    carrier = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": damping, "gravity": gravity}
    drive = HELD | {"speed": sense * HELD["speed"]}
    return FullStability(SteadyTorques.of(machine_from({"carrier": carrier, "bodies": [ROTOR, *balls], "drive": drive})), True)


@pytest.fixture(scope="module")
def full() -> FullStability:
    return stability()


@pytest.fixture(scope="module")
def state(full: FullStability) -> State:
    return fixed_speed_states(full.torques, 100.0)[0]


class Orbit:
    """That does not repeat exactly: bodies move by 1 and 3 degrees a turn."""

    residual = 1e-6

    def __init__(self, full: FullStability, along: list[float], across: list[float]) -> None:
        self.multipliers = np.array([*along, *across])
        self._full, self._across, self.asked = full, np.array(across), list[int]()

    def creep(self, neutral: int) -> np.ndarray:
        self.asked.append(neutral)
        moved = np.zeros(len(self._full.machine.state_names))
        moved[self._full._rows] = self._full.torques.senses * np.radians([10.0, 11.0, 7.0])
        return moved

    def nontrivial(self, neutral: int) -> np.ndarray:
        self.asked.append(neutral)
        return self._across


def judged(
    monkeypatch: pytest.MonkeyPatch,
    full: FullStability,
    state: State,
    exponents: list[complex],
    orbit: Any = None,
    turn: float = 0.0,
) -> Stability:
    """Of a motion near a state, whose bodies are turned by an angle, the last one most."""
    at = full.start(state)
    at[full._rows] += full.torques.senses * np.array([0.5, 0.5 + turn / 2, 0.5 + turn])
    motion = SynchronousMotion(at, 0.0625, np.array(exponents), orbit=orbit)
    monkeypatch.setattr(SynchronousMotions, "find_near", lambda *_: motion)
    return full.stability(state)


def test_a_motion_elsewhere_is_another_one(monkeypatch: pytest.MonkeyPatch, full: FullStability, state: State) -> None:
    assert judged(monkeypatch, full, state, [-1.0], turn=0.49).stable is True
    away = judged(monkeypatch, full, state, [-1.0], turn=-0.51)
    assert (away.stable, away.reason) == (
        None, "the nearest periodic motion of the full equations has phases up to 29 degrees away",
    )  # fmt: skip
    assert judged(monkeypatch, full, replace(state, dimension=1), [-1.0], turn=0.51).stable is True


def test_what_neither_grows_nor_decays(monkeypatch: pytest.MonkeyPatch, full: FullStability, state: State) -> None:
    one = judged(monkeypatch, full, state, [1e-6, -1.0])
    assert (one.stable, one.reason) == (None, "a multiplier lies on the unit circle")
    assert judged(monkeypatch, full, state, [2e-6, -1.0]).stable is False
    undamped = stability(damping=0.0)
    reason = "the carrier is not damped: its free vibration neither grows nor decays"
    assert judged(monkeypatch, undamped, fixed_speed_states(undamped.torques, 100.0)[0], [0.0]).reason == reason


@pytest.mark.parametrize(("gravity", "by"), [(0.0, ""), (9.81, " by gravity")])
def test_a_broken_family_is_judged_across_it(monkeypatch: pytest.MonkeyPatch, gravity: float, by: str) -> None:
    """Where what happens along it is at least ten times slower."""
    full = stability(gravity)
    family = replace(fixed_speed_states(full.torques, 100.0)[0], dimension=1)
    creep = f"the family is broken{by}: bodies creep along it, here by up to 3 degrees a turn"
    n = family.neutral
    slow = Orbit(full, [1.0] * n + [1.0 - 0.00999], [0.9, -0.5])
    across = judged(monkeypatch, full, family, [-1.0 + 2.0j], slow)
    assert (across.stable, across.reason) == (True, f"{creep}; stability is judged across the family")
    assert slow.asked == [1 + n, 1 + n]
    fast = Orbit(full, [1.0] * n + [1.0 - 0.0101], [0.9, -0.5])
    along = judged(monkeypatch, full, family, [-1.0 + 2.0j], fast)
    assert (along.stable, along.reason) == (None, f"{creep}, not much slower than perturbations decay across the family")
    assert along.exponents.tolist() == [-1.0 + 2.0j]
    grows = judged(monkeypatch, full, family, [0.5], Orbit(full, [1.0] * (n + 1), [1.1, -0.5]))
    assert grows.stable is False and grows.reason.startswith(creep)
    undecided = judged(monkeypatch, full, family, [0.0, -1.0], slow)
    assert (undecided.stable, undecided.reason) == (None, "a multiplier lies on the unit circle")


def test_an_orbit_that_repeats_itself(monkeypatch: pytest.MonkeyPatch, full: FullStability, state: State) -> None:
    orbit: Any = SimpleNamespace(residual=1e-10)
    one = judged(monkeypatch, full, state, [-1.0], orbit)
    assert (one.stable, one.reason) == (True, "")


def test_where_no_motion_is_found_it_is_said_why(monkeypatch: pytest.MonkeyPatch, full: FullStability, state: State) -> None:
    def none(*_: Any) -> None:
        raise WuchtError("no convergence")

    monkeypatch.setattr(SynchronousMotions, "find_near", none)
    one = full.stability(state)
    assert (one.stable, one.reason) == (None, "no convergence")


def test_the_orbit_is_that_near_the_state(monkeypatch: pytest.MonkeyPatch, full: FullStability, state: State) -> None:
    monkeypatch.setattr(SynchronousMotions, "orbit", lambda self, *of: of)
    given: Any = full.orbit(replace(state, dimension=1))
    assert np.array_equal(given[0], full.start(state)) and given[1:] == (state.speed, 1)
    assert given[0][full.machine.row(full.machine.body("b0").coordinate.velocity)] == 100.0
    assert given[0][full._rows] == pytest.approx(full.torques.senses * state.phases)


def test_a_clockwise_machine_has_the_orbit_of_its_mirror_image() -> None:
    both = [stability(count=1, sense=sense) for sense in (1, -1)]
    state, *_ = fixed_speed_states(both[0].torques, 100.0)
    (same,) = (s for s in fixed_speed_states(both[1].torques, 100.0) if s.phases == pytest.approx(state.phases))
    orbits = [one.orbit(at) for one, at in zip(both, (state, same), strict=True)]
    assert all(orbit.residual < 1e-6 for orbit in orbits)
    sizes = [np.sort(np.abs(orbit.multipliers)) for orbit in orbits]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-5)


# --- why the models disagree ---


def of(*exponents: complex) -> Stability:
    return Stability(all(e.real < 0 for e in exponents), np.array(exponents, complex), "")


def test_where_they_agree_there_is_nothing_to_say(full: FullStability, state: State) -> None:
    assert full.disagreement(state, of(-1.0), of(-1.0)) is None
    assert full.disagreement(state, of(-1.0), Stability.without_verdict("x")) is None
    assert full.disagreement(state, Stability.without_verdict("x"), of(-1.0)) is None


@pytest.fixture
def first_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second order agrees no better."""
    monkeypatch.setattr(FullStability, "_agrees_in_second_order", lambda *_: False)


STEADY = "the averaged equations assume a steady vibration of the carrier"


@pytest.mark.usefixtures("first_order")
def test_why_the_models_disagree(full: FullStability, state: State) -> None:
    slowest = -full.torques.vibration.poles.real.max()
    tail = f": {STEADY}, but its transients decay at no more than {slowest:.3g} 1/s, while the phases move at up to 2.5 1/s"
    slow, stable = of(2.5), of(-0.125 + 3.0j, -7.0)
    assert full.disagreement(state, slow, stable) == (
        f"in the full equations all perturbations decay (the slowest at 0.125 1/s){tail}"
    )
    slow = of(-2.5)
    assert (
        full.disagreement(state, slow, of(0.125, -7.0)) == f"a real multiplier leaves the unit circle (growth 0.125 1/s){tail}"
    )
    assert full.disagreement(state, slow, of(0.125 + 9.9e-5j, -7.0)) == full.disagreement(state, slow, of(0.125, -7.0))
    pair = full.disagreement(state, slow, of(0.125 + 0.01j, -7.0))
    assert pair == f"a pair of multipliers with the frequency 0.01 rad/s leaves the unit circle (growth 0.125 1/s){tail}"


@pytest.mark.usefixtures("first_order")
def test_a_pair_may_be_the_carriers_vibration_less_whole_turns(full: FullStability, state: State) -> None:
    own = np.abs(full.torques.vibration.poles.imag).max()
    seen = abs(own - 100.0 * round(own / 100.0))
    for off, its in ((0.049, True), (-0.049, True), (0.051, False)):
        words = full.disagreement(state, of(-2.5), of(0.125 + 1j * (seen + off * own), -7.0))
        carrier = f", those of the carrier's free vibration at about {own:.4g} rad/s, leaves the unit circle"
        assert words is not None and (carrier in words) is its, off


def test_without_damping_there_is_no_slowest_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FullStability, "_agrees_in_second_order", lambda *_: False)
    undamped = stability(damping=0.0)
    words = undamped.disagreement(fixed_speed_states(undamped.torques, 100.0)[0], of(-2.5), of(0.125))
    assert words is not None
    assert words.endswith(
        "but its transients are not damped by anything outside the rotor, while the phases move at up to 2.5 1/s"
    )


def test_the_next_order_may_agree(monkeypatch: pytest.MonkeyPatch, full: FullStability, state: State) -> None:
    agreeing, asked = of(-1.0), list[Any]()

    def second(*given: Any) -> Any:
        asked.append(given)
        return SimpleNamespace(stability=lambda _: agreeing)

    monkeypatch.setattr(module, "averaged_equations_of", lambda *given: given)
    monkeypatch.setattr(module, "AveragedStability", second)
    words = replace(full).disagreement(state, of(2.5), of(-0.125))
    assert words == (
        f"in the full equations all perturbations decay (the slowest at 0.125 1/s): {STEADY}; those of second order agree"
    )
    assert asked == [(full.torques, (full.torques.machine, True, 2))]
    against = replace(full).disagreement(state, of(-2.5), of(0.125))
    assert against is not None and "second order" not in against


def test_where_the_next_order_is_not_to_be_had(monkeypatch: pytest.MonkeyPatch, full: FullStability, state: State) -> None:
    def none(*_: Any) -> None:
        raise WuchtError("too long")

    monkeypatch.setattr(module, "AveragedStability", lambda *_: SimpleNamespace(stability=none))
    monkeypatch.setattr(module, "averaged_equations_of", lambda *_: None)
    assert replace(full)._agrees_in_second_order(state, of(-1.0)) is False
    monkeypatch.setattr(module, "averaged_equations_of", none)
    assert replace(full)._second_order is None and replace(full)._agrees_in_second_order(state, of(-1.0)) is False
    monkeypatch.setattr(module, "averaged_equations_of", lambda *_: None)
    many = replace(full, torques=stability(count=5).torques)
    assert many.torques.size == 6 and many._second_order is None
    assert replace(full, torques=stability(count=4).torques)._second_order is not None
    assert math.isclose(module._NEXT_ORDER, 5)
