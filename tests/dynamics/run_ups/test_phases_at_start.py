"""Steady phases in which balancing bodies start, and starts of runs, of branches and machines made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.dynamics.run_ups import run_up, steady_phases
from wucht.dynamics.run_ups.run_up import _legs_on_samples, prepare_start
from wucht.dynamics.run_ups.steady_phases import BodyPhases, SteadyPhases, phases_at_start
from wucht.files.building import machine_from

CARRIER = {"mass": 1.0, "stiffness": 1e4, "damping": 5.0}
ROTOR = {"kind": "rotor", "name": "d", "mass": 1.0, "unbalance": 1e-3, "inertia": 1e-2}


def branch(stable: bool, label: str, phases: tuple[float, ...] = (0.0, 0.0, 0.0), overlapping: bool = False) -> Any:
    return SimpleNamespace(
        stable=lambda speeds: np.array([stable]), overlapping=overlapping, labels=lambda speeds: [f"{label} at {speeds[0]:g}"],
        machine_phases=lambda speeds: (np.array(phases)[:, None], None),
    )  # fmt: skip


def bodies(release: Any = None) -> Any:
    """A clockwise rotor with a body p, on which there is a body q; the torques name them in another order."""
    every = [SimpleNamespace(name=n, about=a, release=None) for n, a in (("d", None), ("p", "d"), ("q", "p"))]
    every[2].release = release
    machine = SimpleNamespace(bodies=every, units=SimpleNamespace(speed="rad/s"))
    machine.at = lambda time: SimpleNamespace(with_fields=lambda schedules: machine)
    return machine


def steady(monkeypatch: pytest.MonkeyPatch, *branches: Any, speed: float = -50.0) -> BodyPhases:
    torques = SimpleNamespace(names=("d", "q", "p"), senses=np.array([-1.0, 1.0, -1.0]))
    monkeypatch.setattr(steady_phases, "steady_branches", lambda machine: (torques, branches))
    monkeypatch.setattr(steady_phases, "machine_at_speed", lambda machine, at: machine)
    return BodyPhases._steady(bodies(), speed)


def test_the_first_stable_branch_whose_bodies_are_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its angles relative to the body that each turns about, counter-clockwise."""
    found = steady(
        monkeypatch,
        branch(False, "a"),
        branch(True, "b", overlapping=True),
        branch(True, "c", (0.5, 2.0, 3.25)),
        branch(True, "d"),
    )
    assert found.to_rotor == {"p": -1.5, "q": 1.25}
    assert (found.label, found.other_labels) == ("c at 50", ("d at 50",))
    (sentence,) = found.assumptions({"p": 0.1})
    assert "c at 50" in sentence and "1 other (d at 50)" in sentence
    with refused("machine.bodies"):
        steady(monkeypatch, branch(False, "a"), branch(True, "b", overlapping=True))
    with refused("machine.bodies"):
        BodyPhases._steady(bodies(release="locked"), 1.0)


def rotors(*speeds: float) -> Any:
    """Rotors a, b ... on one carrier, each driven to a speed; b1 turns about a."""
    names = "abc"[: len(speeds)]
    made = [ROTOR | {"name": n} for n in names]
    ball = {"kind": "pendulum", "name": "b1", "about": "a", "mass": 1e-3, "length": 0.1, "damping": 1e-3}
    motors = [{"on": n, "kind": "linear", "slope": 0.1, "no_load_speed": w} for n, w in zip(names, speeds, strict=True)]
    return machine_from({"carrier": CARRIER, "bodies": [*made, ball], "drives": motors})


def test_phases_that_a_start_gives_count_each_in_the_sense_of_its_rotor() -> None:
    """a turns clockwise, b counter-clockwise: b's angle 0.5 is 0.5 + 0.25 ahead of a's angle 0.25 against it."""
    machine = rotors(-50.0, 50.0)
    assert phases_at_start(machine, {}) == {}
    assert phases_at_start(machine, {"a": 0.25, "b": 0.5}) == {"b": pytest.approx(0.75)}
    assert phases_at_start(machine, {"b": 0.5, "b1": 0.125}) == {"b": pytest.approx(0.5), "b1": pytest.approx(0.125)}
    assert phases_at_start(machine, {"a": 0.25}) == {"b": pytest.approx(0.25)}
    assert phases_at_start(machine, {"a": {"speed": 3.0}}) == {}
    assert phases_at_start(rotors(50.0, -50.0), {"a": 0.25, "b": 0.5}) == {"b": pytest.approx(-0.75)}


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_grid_of_speeds_has_the_ends_of_branches_in_the_sense_of_the_rotor(sense: float) -> None:
    ending: Any = [SimpleNamespace(ends=lambda speeds, k=k: np.array([12.5 + k, 99.0])) for k in range(2)]
    steady = SteadyPhases(rotors(sense * 50.0), np.zeros(2), SimpleNamespace(), branches=ending)  # type: ignore[arg-type]
    grid = steady.grid(sense * np.array([10.0, 20.0]))
    assert sorted(np.abs(grid).tolist()) == [10.0, 12.5, 13.5, 20.0] and np.all(sense * grid > 0)


def test_pieces_of_a_branch_have_one_name_each() -> None:
    speeds = np.array([1.0, 2.0, 3.0, 4.0])

    def made(labels: list[str], stable: list[bool], overlapping: bool) -> Any:
        return SimpleNamespace(labels=lambda w: np.array(labels), stable=lambda w: np.array(stable), overlapping=overlapping)

    both = (made(["a", "b", "a", ""], [True, True, False, True], False), made(["c"] * 4, [False, True, True, False], True))
    steady = SteadyPhases(SimpleNamespace(), np.zeros(1), SimpleNamespace(), branches=both)  # type: ignore[arg-type]
    pieces = [(p.branch, p.label, p.inside.tolist(), p.stable.tolist(), p.overlapping) for p in steady.pieces(speeds)]
    assert pieces == [
        (0, "a", [True, False, True, False], [True, False, False, False], False),
        (0, "b", [False, True, False, False], [False, True, False, False], False),
        (1, "c", [True] * 4, [False, True, True, False], True),
    ]


def test_labels_are_listed_once_and_those_of_several_rotors_with_a_word_between() -> None:
    for configurations, listed in ((None, "a, b"), ((), "a or b")):
        steady = SteadyPhases(SimpleNamespace(), np.zeros(1), SimpleNamespace(), configurations=configurations)  # type: ignore[arg-type]
        assert steady.list_labels(["a", "", "b", "a"]) == listed


def test_what_steady_vibration_leaves_out() -> None:
    """The release of bodies, where these are in steady phases; why they are held, where they are not."""
    ball = {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.01, "length": 0.1, "damping": 1e-3}
    machine = machine_from({"carrier": CARRIER, "bodies": [ROTOR, ball | {"release": {"time": 1.0}}]})
    given: Any = (machine, np.zeros(2), SimpleNamespace())
    branches: Any = (SimpleNamespace(),)
    assert SteadyPhases(*given, branches=branches).warnings == ["p is taken as released"]
    assert SteadyPhases(*given).warnings == []
    (held,) = SteadyPhases(*given, held_reason="there are none").warnings
    assert held == "balancing bodies are held, as their steady phases are not computed: there are none"


def test_what_drives_or_moves_a_machine_at_its_start() -> None:
    loose = machine_from({"carrier": CARRIER, "bodies": [ROTOR]})
    with refused("machine.drive", code="nothing-turns"):
        prepare_start(loose, {})
    for start in ({"d": {"speed": -0.1}}, {"d": {"speed": 0.1}}):
        assert prepare_start(loose, start)[1][loose.row(loose.rotor.coordinate.velocity)] == start["d"]["speed"]
    with refused("machine.drive", code="nothing-turns"):
        prepare_start(loose, {"d": {"angle": 1.0}})
    driven = {"kind": "linear", "slope": 0.1, "no_load_speed": -100.0}
    prepare_start(machine_from({"carrier": CARRIER, "bodies": [ROTOR], "drive": driven}), {})
    hanging = machine_from({"carrier": CARRIER | {"gravity": 9.81}, "bodies": [ROTOR]})
    prepare_start(hanging, {"d": {"angle": 0.5}})


@pytest.mark.parametrize("speed", [30.0, -30.0])
def test_a_limit_of_the_speed_is_above_the_one_that_a_drive_prescribes(speed: float) -> None:
    held = machine_from({"carrier": CARRIER, "bodies": [ROTOR], "drive": {"kind": "constant-speed", "speed": speed}})
    prepare_start(held, {}, 1.0, 30.5)
    with refused("study.speed_limit", given=29.5):
        prepare_start(held, {}, 1.0, 29.5)
    ramp = {"parameter": "drive.speed", "points": [[0.0, speed], [2.0, 3 * speed]]}
    rising = machine_from({
        "carrier": CARRIER, "bodies": [ROTOR], "drive": {"kind": "constant-speed", "speed": speed}, "schedules": [ramp],
    })  # fmt: skip
    prepare_start(rising, {}, 1.0, 61.0)
    with refused("study.speed_limit", given=59.0):
        prepare_start(rising, {}, 1.0, 59.0)


def test_legs_over_given_samples_join(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_up, "_SAMPLES_A_LEG", 3)
    for count, ends in ((8, [(0.0, 3.0), (3.0, 6.0), (6.0, 7.0)]), (7, [(0.0, 3.0), (3.0, 6.0)]), (2, [(0.0, 1.0)])):
        legs = list(_legs_on_samples(np.arange(float(count))))
        assert [(leg.samples[0], leg.samples[-1]) for leg in legs] == ends
        assert all((leg.end, leg.is_judged) == (count - 1.0, False) for leg in legs)
