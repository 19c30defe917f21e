"""What ``capture-probability`` refuses, in one sentence each."""

from __future__ import annotations

import sys
from typing import Any

import pytest
from tests.refusals import check_refusal, refused

from known_borders import rail
from wucht import CaptureProbability, Machine, load_machine, run
from wucht.files.building import machine_from

R1, NUMBERS = "drozdetskaya-2020/r1", "drozdetskaya-2020/table-5.1"
PSI = {"psi": {"uniform": [0.0, 6.0]}}
TWO = PSI | {"delta": {"uniform": [0.0, 3.0]}}


@pytest.mark.parametrize(
    "asked",
    [
        {"random": {}}, {"random": [1]}, {"random": {"psi": 3.0}}, {"random": {"psi": {}}},
        {"random": {"p1": {"speed": {"unform": [0, 1]}}}}, {"random": {"p1.speed": PSI["psi"], "p1": {"speed": PSI["psi"]}}},
        {"random": {"drive": {"slope": PSI["psi"]}}}, {"samples": 100}, {"seed": -1},
        {"probability": 1.0}, {"confidence": 95}, {"outcome": "captive"},
        {"outcome": ["captured", "unidentified"]}, {"outcome": []}, {"at": 0.01}, {"sensitivity_samples": 64},
        {"sensitivity": True, "random": TWO}, {"sensitivity": True, "at": 0.01},
        {"sensitivity": True, "at": 0.01, "random": TWO, "samples": 240}, {"sensitivity": "yes"},
        {"inertia": True, "model": "full"}, {"until": "0 s"}, {"samples": 7}, {"samples": 72},
        {"random": {"tracks": "uniform"}}, {"random": {"psi": "uniform"}}, {"random": {"tracks": {"ring": "normal"}}},
        {"sensitivity": True, "at": 0.01, "random": TWO, "samples": 32},
    ],
)  # fmt: skip
def test_what_the_question_refuses(asked: dict[str, Any]) -> None:
    given = {"along": "drive.slope", "range": [0.01, 0.02], "random": PSI} | asked
    check_refusal(f"capture-probability: {asked}", lambda: CaptureProbability(**given))


def at_rest() -> Machine:
    """A ball, and no torque."""
    ball = {"kind": "roller", "about": "drum", "mass": 0.1, "track_radius": 0.06, "radius": 0.02, "shape_factor": 0.4}
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [drum, ball | {"name": "b1", "damping": 0.01, "track": "ring"}],
        "drive": {"kind": "constant-torque", "torque": 0.0},
    })  # fmt: skip


RING = {"tracks.ring": "uniform"}


@pytest.mark.parametrize(
    "asked",
    [
        {"random": {"tracks.rung": "uniform"}}, {"random": RING | {"b1": PSI["psi"]}}, {"start": {"b2": {"angle": 1.0}}},
        {"random": RING | PSI}, {"start": {"psi": 1.0}},
    ],
)  # fmt: skip
def test_what_does_not_go_with_an_arrangement(asked: dict[str, Any]) -> None:
    given = {"along": "drive.slope", "range": [0.01, 0.02], "random": RING, "samples": 8} | asked
    check_refusal(f"capture-probability of a track: {asked}", lambda: run(CaptureProbability(**given), rail()))


def test_what_cannot_be_arranged() -> None:
    """Bodies without a track; six balls whose radius is half of that of the circle of their centres, which fill it."""
    ball = {"kind": "roller", "name": "b", "count": 6, "about": "drum", "mass": 0.1, "track_radius": 0.1875}
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}
    full = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [drum, ball | {"radius": 0.0625 - 1e-10, "shape_factor": 0.4, "damping": 0.01, "track": "ring"}],
        "drive": {"kind": "linear", "slope": 0.01, "no_load_speed": 30.0},
    })  # fmt: skip
    question = CaptureProbability(along="drive.slope", range=[0.01, 0.02], random=RING, samples=8)
    with refused("study.random.tracks.ring", "no body of the machine has a track", given="uniform", code="unknown-track"):
        run(question, load_machine(R1))
    with refused("study.random.tracks.ring", "the 6 bodies of this track fill its circle", given="uniform", code="full-track"):
        run(question, full)


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        (R1, {"along": "drive.slop"}), (R1, {"range": [0.02, 0.01]}), (R1, {"range": [-0.02, 0.01]}),
        (R1, {"random": {"psy": PSI["psi"]}}), (R1, {"random": {"psi": {"uniform": ["0 m", 1.0]}}}),
        (R1, {"start": {"psi": 1.0}}), (R1, {"random": {"p1": PSI["psi"], "p1.angle": PSI["psi"]}}),
        (R1, {"random": {"psi": PSI["psi"], "p1": PSI["psi"]}}), (R1, {"random": {"drum.mass": {"normal": [1.0, 1.0]}}}),
        (NUMBERS, {"along": "u", "random": {"psi": {"uniform": ["0 s", 1.0]}}}),
        (R1, {"random": TWO, "sensitivity": True, "at": "1 kg"}),
        (None, {"along": "drum.mass", "random": {"b1": PSI["psi"]}}),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_machine(name: str | None, asked: dict[str, Any]) -> None:
    machine = load_machine(name) if name else at_rest()
    given = {"along": "drive.slope", "range": [0.01, 0.02], "random": PSI, "samples": 64} | asked
    check_refusal(f"capture-probability of a machine: {asked}", lambda: run(CaptureProbability(**given), machine))


def test_without_salib_the_sensitivity_is_refused_before_the_first_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "SALib.sample.sobol", None)
    spec = CaptureProbability(along="drive.slope", range=[0.01, 0.02], random=TWO, samples=64, sensitivity=True, at=0.01)
    with refused("study.sensitivity", "wucht[sensitivity]", given=True):
        run(spec, load_machine(R1))


def test_a_distribution_that_reaches_what_the_machine_forbids() -> None:
    """A mass that is negative, or none."""
    for ends in ([-0.5, 1.0], [0.0, 1.0]):
        with refused("study.random.p1.mass", "between", given={"uniform": ends}):
            random = {"p1.mass": {"uniform": ends}}
            run(CaptureProbability(along="drive.slope", range=[0.01, 0.02], random=random, samples=64), load_machine(R1))


@pytest.mark.parametrize(("key", "low", "high"), [("samples", 8, 2**20), ("points", 2, 1000)])
def test_numbers_that_are_allowed(key: str, low: int, high: int) -> None:
    given = {"along": "u", "range": [1.0, 3.0], "random": PSI, "model": "slow"}
    for value in (low, high):
        assert getattr(CaptureProbability(**given | {key: value}), key) == value
    for value in (low - 1, high + (16 if key == "samples" else 1)):
        with refused(f"study.{key}", given=value):
            CaptureProbability(**given | {key: value})
