"""What ``capture-probability`` refuses, in one sentence each."""

from __future__ import annotations

import sys
from typing import Any

import pytest
from tests.refusals import Refusal, refused

from wucht import CaptureProbability, Machine, load_machine, run
from wucht.files.building import machine_from

R1, NUMBERS = load_machine("drozdetskaya-2020/r1"), load_machine("drozdetskaya-2020/table-5.1")
PSI = {"psi": {"uniform": [0.0, 6.0]}}
TWO = PSI | {"delta": {"uniform": [0.0, 3.0]}}


@pytest.mark.parametrize(
    ("asked", "where", "refusal"),
    [
        ({"random": {}}, "study.random", refused("study.random", given={})),
        ({"random": [1]}, "study.random", refused("study.random", given=[1])),
        ({"random": {"psi": 3.0}}, "study.random.psi", refused("study.random.psi", given=3.0)),
        ({"random": {"psi": {}}}, "study.random.psi", refused("study.random.psi", given={})),
        (
            {"random": {"p1": {"speed": {"unform": [0, 1]}}}},
            "study.random.p1.speed.unform",
            refused("study.random.p1.speed.unform", "uniform", given=[0, 1]),
        ),
        (
            {"random": {"p1.speed": PSI["psi"], "p1": {"speed": PSI["psi"]}}},
            "study.random.p1.speed",
            refused("study.random.p1.speed", given={"uniform": [0.0, 6.0]}),
        ),
        (
            {"random": {"drive": {"slope": PSI["psi"]}}},
            "study.random.drive.slope",
            refused("study.random.drive.slope", given="drive.slope"),
        ),
        ({"samples": 100}, "study.samples", refused("study.samples", "16", "64", "1048576", given=100)),
        ({"samples": 32}, "study.samples", refused("study.samples", "16", "64", given=32)),
        ({"samples": 64.5}, "study.samples", refused("study.samples", given=64.5)),
        ({"points": 1}, "study.points", refused("study.points", "1000", given=1)),
        ({"seed": -1}, "study.seed", refused("study.seed", given=-1)),
        ({"probability": 1.0}, "study.probability", refused("study.probability", code="limits")),
        ({"confidence": 95}, "study.confidence", refused("study.confidence", code="limits")),
        ({"outcome": "captive"}, "study.outcome", refused("study.outcome", "captured", given="captive")),
        (
            {"outcome": ["captured", "unidentified"]},
            "study.outcome",
            refused("study.outcome", given=["captured", "unidentified"]),
        ),
        ({"outcome": []}, "study.outcome", refused("study.outcome", given=[])),
        ({"at": 0.01}, "study.at", refused("study.at", "sensitivity = true", given=0.01)),
        (
            {"sensitivity_samples": 64},
            "study.sensitivity_samples",
            refused("study.sensitivity_samples", "sensitivity = true", given=64),
        ),
        ({"sensitivity": True, "random": TWO}, "study.at", refused("study.at", "drive.slope", given=None, code="missing")),
        ({"sensitivity": True, "at": 0.01}, "study.sensitivity", refused("study.sensitivity", given=True, code="too-few")),
        (
            {"sensitivity": True, "at": 0.01, "random": TWO, "samples": 240},
            "study.samples",
            refused("study.samples", given=240),
        ),
        ({"sensitivity": "yes"}, "study.sensitivity", refused("study.sensitivity", given="yes")),
        ({"inertia": True, "model": "full"}, "study.inertia", refused("study.inertia", "model = 'slow'", given=True)),
        ({"until": "0 s"}, "study.until", refused("study.until", code="limits")),
    ],
)
def test_what_the_question_refuses(asked: dict[str, Any], where: str, refusal: Refusal) -> None:
    given = {"along": "drive.slope", "range": [0.01, 0.02], "random": PSI} | asked
    with refusal as raised:
        CaptureProbability(**given)
    assert raised.value.location == where


def rail() -> Machine:
    """Two balls in one track."""
    ball = {"kind": "roller", "about": "drum", "mass": 0.1, "track_radius": 0.06, "radius": 0.02, "shape_factor": 0.4}
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [drum, ball | {"name": "b1", "damping": 0.01, "track": "ring"}],
        "drive": {"kind": "constant-torque", "torque": 0.0},
    })  # fmt: skip


@pytest.mark.parametrize(
    ("machine", "asked", "where", "refusal"),
    [
        (
            R1,
            {"along": "drive.slop"},
            "study.along",
            refused("study.along", "drive.slope", given="drive.slop", code="unknown-parameter"),
        ),
        (R1, {"range": [0.02, 0.01]}, "study.range", refused("study.range", given=[0.02, 0.01])),
        (R1, {"range": [-0.02, 0.01]}, "study.range[0]", refused("study.range[0]", code="limits")),
        (
            R1,
            {"random": {"psy": PSI["psi"]}},
            "study.random.psy",
            refused("study.random.psy", "psi", given="psy", code="unknown-name"),
        ),
        (
            R1,
            {"random": {"psi": {"uniform": ["0 m", 1.0]}}},
            "study.random.psi.uniform[0]",
            refused("study.random.psi.uniform[0]", code="dimension"),
        ),
        (
            R1,
            {"start": {"psi": 1.0}},
            "study.random.psi",
            refused("study.random.psi", "study.start", given="psi", code="given-twice"),
        ),
        (
            R1,
            {"random": {"p1": PSI["psi"], "p1.angle": PSI["psi"]}},
            "study.random.p1.angle",
            refused("study.random.p1.angle", given="p1.angle", code="given-twice"),
        ),
        (R1, {"random": {"psi": PSI["psi"], "p1": PSI["psi"]}}, "study.random.p1", refused("study.random.p1", given=None)),
        (
            R1,
            {"random": {"drum.mass": {"normal": [1.0, 1.0]}}},
            "study.random.drum.mass",
            refused("study.random.drum.mass", given={"normal": [1.0, 1.0]}),
        ),
        (
            NUMBERS,
            {"along": "u", "random": {"psi": {"uniform": ["0 s", 1.0]}}},
            "study.random.psi.uniform[0]",
            refused("study.random.psi.uniform[0]", code="dimension"),
        ),
        (R1, {"random": TWO, "sensitivity": True, "at": "1 kg"}, "study.at[0]", refused("study.at[0]", code="dimension")),
        (
            rail(),
            {"along": "drum.mass", "random": {"b1": PSI["psi"]}},
            "machine.drive",
            refused("machine.drive", code="nothing-turns"),
        ),
    ],
)
def test_what_does_not_fit_the_machine(machine: Machine, asked: dict[str, Any], where: str, refusal: Refusal) -> None:
    given = {"along": "drive.slope", "range": [0.01, 0.02], "random": PSI, "samples": 64} | asked
    with refusal as raised:
        run(CaptureProbability(**given), machine)
    assert raised.value.location == where


def test_without_salib_the_sensitivity_is_refused_before_the_first_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "SALib.sample.sobol", None)
    spec = CaptureProbability(along="drive.slope", range=[0.01, 0.02], random=TWO, samples=64, sensitivity=True, at=0.01)
    with refused("study.sensitivity", "wucht[sensitivity]", given=True) as raised:
        run(spec, R1)
    assert raised.value.location == "study.sensitivity"


def test_a_distribution_that_reaches_what_the_machine_forbids() -> None:
    """A mass that is negative, or none."""
    for ends in ([-0.5, 1.0], [0.0, 1.0]):
        with refused("study.random.p1.mass", "between", given={"uniform": ends}):
            run(
                CaptureProbability(along="drive.slope", range=[0.01, 0.02], random={"p1.mass": {"uniform": ends}}, samples=64),
                R1,
            )


@pytest.mark.parametrize(("key", "low", "high"), [("samples", 64, 2**20), ("points", 2, 1000)])
def test_numbers_that_are_allowed(key: str, low: int, high: int) -> None:
    given = {"along": "u", "range": [1.0, 3.0], "random": PSI, "model": "slow"}
    for value in (low, high):
        assert getattr(CaptureProbability(**given | {key: value}), key) == value
    step = 16 if key == "samples" else 1
    for value in (low - step, high + step):
        with refused(f"study.{key}", given=value):
            CaptureProbability(**given | {key: value})
