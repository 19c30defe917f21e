"""What the study ``basin`` refuses."""

from __future__ import annotations

import math
from typing import Any

import pytest
from tests.refusals import Refusal, refused

from wucht import Basin
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.runner import run

R1, NUMBERS = load_machine("drozdetskaya-2020/r1"), load_machine("drozdetskaya-2020/table-5.1")
TURN = 2 * math.pi
PSI, DELTA = [0.0, TURN, 4], [0.0, math.pi, 4]


def driven(*, gravity: float = 0.0, more: dict[str, Any] | None = None) -> Machine:
    """A drum with a ball."""
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0, "gravity": gravity},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2},
            {"kind": "pendulum", "name": "ball", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.01},
        ],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 150.0},
        **(more or {}),
    })  # fmt: skip


SCHEDULED = driven(more={"schedules": [{"parameter": "drive.slope", "points": [[0.0, 0.0], [1.0, 0.02]]}]})
AT_REST = driven(more={"drive": {"kind": "constant-torque", "torque": 0.0}})
HELD = driven(more={"drive": {"kind": "constant-speed", "speed": 100.0}})


def test_paths_as_toml_reads_them() -> None:
    """``drive.slope = [...]`` is a table in a table."""
    nested = Basin(axes={"drive": {"slope": ["0 N m s", 1.0, 4]}, "p1": {"speed": [0.0, 1.0, 5.0]}})
    assert nested.axes == {"drive.slope": ("0 N m s", 1.0, 4), "p1.speed": (0.0, 1.0, 5)}


@pytest.mark.parametrize(
    ("asked", "where", "refusal"),
    [
        ({"axes": {"psi": PSI, "delta": DELTA, "u": [0, 1, 4]}}, "study.axes",
         refused("study.axes", given=['psi', 'delta', 'u'])),
        ({"axes": {"psi": PSI}}, "study.axes", refused("study.axes", given=['psi'])),
        ({"axes": {"p1.speed": PSI, "p1": {"speed": DELTA}}}, "study.axes",
         refused("study.axes", given=['p1.speed', 'p1.speed'])),
        ({"axes": [PSI, DELTA]}, "study.axes", refused("study.axes", code="table")),
        ({}, "study.axes", refused("study.axes", code="missing")),
        ({"axes": {"psi": [0.0, 1.0], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0], code="shape")),
        ({"axes": {"psi": [0.0, 1.0, 4.5], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0, 4.5], code="whole-number")),
        ({"axes": {"psi": [0.0, 1.0, 1], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0, 1], code="whole-number")),
        ({"axes": {"psi": [0.0, 1.0, True], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0, True], code="whole-number")),
        ({"axes": {"psi": [0, 1, 4096], "delta": [0, 1, 4096]}}, "study.axes",
         refused("study.axes", "4194304", "4096", given="4096 x 4096")),
        ({"refine": 10}, "study.axes", refused("study.axes", "4194304", "4096", given="4 x 4, halved 10 times")),
        ({"refine": -1}, "study.refine", refused("study.refine", "10", given=-1)),
        ({"refine": 1.5}, "study.refine", refused("study.refine", given=1.5)),
        ({"inertia": True, "model": "full"}, "study.inertia", refused("study.inertia", "model = 'slow'", given=True)),
        ({"until": "0 s"}, "study.until", refused("study.until", code="limits")),
        ({"model": "both"}, "study.model", refused("study.model", code="unknown-name")),
    ],
)  # fmt: skip
def test_what_the_question_refuses(asked: dict[str, Any], where: str, refusal: Refusal) -> None:
    given = {"axes": {"psi": PSI, "delta": DELTA}} | asked if asked else {}
    with refusal as raised:
        Basin(**given)
    assert raised.value.location == where


@pytest.mark.parametrize(
    ("machine", "asked", "where", "refusal"),
    [
        (R1, {"axes": {"psy": PSI, "delta": DELTA}}, "study.axes.psy",
         refused("study.axes.psy", "psi", given="psy", code="unknown-name")),
        (R1, {"axes": {"psi": [1.0, 0.0, 4], "delta": DELTA}}, "study.axes.psi", refused("study.axes.psi", given=[1.0, 0.0])),
        (R1, {"axes": {"psi": ["1 kg", 2.0, 4], "delta": DELTA}}, "study.axes.psi[0]",
         refused("study.axes.psi[0]", code="dimension")),
        (R1, {"axes": {"psi": PSI, "p1": PSI}}, "study.axes.p1", refused("study.axes.p1", given=None)),
        (R1, {"axes": {"p1": PSI, "p1.angle": PSI}}, "study.axes.p1.angle",
         refused("study.axes.p1.angle", given="p1.angle", code="given-twice")),
        (R1, {"axes": {"psi": PSI, "delta": DELTA}, "start": {"psi": 0.1}}, "study.axes.psi",
         refused("study.axes.psi", "study.start", given="psi", code="given-twice")),
        (R1, {"axes": {"p1": PSI, "p2": PSI}, "start": {"p2": 0.1}}, "study.axes.p2",
         refused("study.axes.p2", "study.start", given="p2", code="given-twice")),
        (R1, {"axes": {"p1": PSI, "p2": PSI}, "start": {"p3": 0.1}}, "study.start.p3",
         refused("study.start.p3", code="unknown-key")),
        (R1, {"axes": {"p1": PSI, "drum.mass": [-2.0, 1.0, 4]}}, "study.axes.drum.mass",
         refused("study.axes.drum.mass", code="limits")),
        (HELD, {"axes": {"drum.speed": [0, 1, 4], "ball": PSI}}, "study.axes.drum.speed",
         refused("study.axes.drum.speed", given="drum.speed", code="prescribed")),
        (SCHEDULED, {"axes": {"drive.slope": [0, 1, 4], "ball": PSI}}, "study.axes.drive.slope",
         refused("study.axes.drive.slope", given="drive.slope", code="scheduled")),
        (driven(), {"axes": {"psi": PSI, "ball": PSI}}, "study.axes.psi",
         refused("study.axes.psi", given="psi", code="unknown-name")),
        (NUMBERS, {"axes": {"psi": ["0 s", 1, 4], "delta": DELTA}}, "study.axes.psi[0]",
         refused("study.axes.psi[0]", code="dimension")),
        (AT_REST, {"axes": {"ball": PSI, "drum.mass": [1.0, 2.0, 2]}}, "machine.drive",
         refused("machine.drive", code="nothing-turns")),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_machine(machine: Machine, asked: dict[str, Any], where: str, refusal: Refusal) -> None:
    with refusal as raised:
        run(Basin(**asked), machine)
    assert raised.value.location == where
