"""What the study ``basin`` refuses."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from tests.refusals import Refusal, refused

from wucht import Basin, run_file
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.runner import run

TURN = 2 * math.pi
PSI, DELTA = [0.0, TURN, 4], [0.0, math.pi, 4]


def driven(**more: Any) -> Machine:
    """A drum with a ball."""
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2},
            {"kind": "pendulum", "name": "ball", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.01},
        ],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 150.0},
        **more,
    })  # fmt: skip


MACHINES: dict[str, Callable[[], Machine]] = {
    "r1": lambda: load_machine("drozdetskaya-2020/r1"),
    "driven": driven,
    "scheduled": lambda: driven(schedules=[{"parameter": "drive.slope", "points": [[0.0, 0.0], [1.0, 0.02]]}]),
    "at rest": lambda: driven(drive={"kind": "constant-torque", "torque": 0.0}),
    "held": lambda: driven(drive={"kind": "constant-speed", "speed": 100.0}),
}


def test_paths_as_toml_reads_them() -> None:
    """``drive.slope = [...]`` is a table in a table."""
    nested = Basin(axes={"drive": {"slope": ["0 N m s", 1.0, 4]}, "p1": {"speed": [0.0, 1.0, 5.0]}})
    assert nested.axes == {"drive.slope": ("0 N m s", 1.0, 4), "p1.speed": (0.0, 1.0, 5)}


@pytest.mark.parametrize(
    ("asked", "refusal"),
    [
        ({"axes": {"psi": PSI, "delta": DELTA, "u": [0, 1, 4]}}, refused("study.axes", given=['psi', 'delta', 'u'])),
        ({"axes": {"p1.speed": PSI, "p1": {"speed": DELTA}}}, refused("study.axes", given=['p1.speed', 'p1.speed'])),
        ({"axes": [PSI, DELTA]}, refused("study.axes", code="table")),
        ({}, refused("study.axes", code="missing")),
        ({"axes": {"psi": [0.0, 1.0], "delta": DELTA}}, refused("study.axes.psi", given=[0.0, 1.0], code="shape")),
        ({"axes": {"psi": [0.0, 1.0, 1], "delta": DELTA}}, refused("study.axes.psi", given=[0.0, 1.0, 1], code="whole-number")),
        ({"axes": {"psi": [0, 1, 4096], "delta": [0, 1, 4096]}}, refused("study.axes", "4194304", "4096", given="4096 x 4096")),
        ({"refine": 10}, refused("study.axes", "4194304", "4096", given="4 x 4, halved 10 times")),
        ({"inertia": True, "model": "full"}, refused("study.inertia", "model = 'slow'", given=True)),
    ],
)  # fmt: skip
def test_what_the_question_refuses(asked: dict[str, Any], refusal: Refusal) -> None:
    given = {"axes": {"psi": PSI, "delta": DELTA}} | asked if asked else {}
    with refusal:
        Basin(**given)


@pytest.mark.parametrize(
    ("machine", "asked", "refusal"),
    [
        ("r1", {"axes": {"psy": PSI, "delta": DELTA}}, refused("study.axes.psy", "psi", given="psy", code="unknown-name")),
        ("r1", {"axes": {"psi": [1.0, 0.0, 4], "delta": DELTA}}, refused("study.axes.psi", given=[1.0, 0.0])),
        ("r1", {"axes": {"psi": ["1 kg", 2.0, 4], "delta": DELTA}}, refused("study.axes.psi[0]", code="dimension")),
        ("r1", {"axes": {"p1": PSI, "p1.angle": PSI}}, refused("study.axes.p1.angle", given="p1.angle", code="given-twice")),
        ("r1", {"axes": {"psi": PSI, "delta": DELTA}, "start": {"psi": 0.1}},
         refused("study.axes.psi", "study.start", given="psi", code="given-twice")),
        ("r1", {"axes": {"p1": PSI, "p2": PSI}, "start": {"p2": 0.1}},
         refused("study.axes.p2", "study.start", given="p2", code="given-twice")),
        ("r1", {"axes": {"p1": PSI, "drum.mass": [-2.0, 1.0, 4]}}, refused("study.axes.drum.mass", code="limits")),
        ("held", {"axes": {"drum.speed": [0, 1, 4], "ball": PSI}},
         refused("study.axes.drum.speed", given="drum.speed", code="prescribed")),
        ("scheduled", {"axes": {"drive.slope": [0, 1, 4], "ball": PSI}},
         refused("study.axes.drive.slope", given="drive.slope", code="scheduled")),
        ("driven", {"axes": {"psi": PSI, "ball": PSI}}, refused("study.axes.psi", given="psi", code="unknown-name")),
        ("at rest", {"axes": {"ball": PSI, "drum.mass": [1.0, 2.0, 2]}}, refused("machine.drive", code="nothing-turns")),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_machine(machine: str, asked: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        run(Basin(**asked), MACHINES[machine]())


def test_a_file_of_another_study_keeps_its_own_axes() -> None:
    """``synchronous-states`` has a key of this name that means something else."""
    with refused("study.axes", code="missing"):
        run_file("sperling-rollers/stability-map", {"study.kind": "basin"})
