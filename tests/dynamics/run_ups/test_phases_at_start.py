"""Steady phases in which balancing bodies start, and starts of runs, of branches and machines made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.dynamics.run_ups import run_up, steady_phases
from wucht.dynamics.run_ups.run_up import _legs_on_samples, prepare_start
from wucht.dynamics.run_ups.steady_phases import BodyPhases
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
