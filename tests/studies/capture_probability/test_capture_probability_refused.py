"""What ``capture-probability`` refuses, in one sentence each."""

from __future__ import annotations

from typing import Any

import pytest

from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.capture_probability import sobol_indices
from wucht.studies.capture_probability.prepare import prepare
from wucht.studies.capture_probability.spec import CaptureProbability

R1, NUMBERS = load_machine("drozdetskaya-2020/r1"), load_machine("drozdetskaya-2020/table-5.1")
PSI = {"psi": {"uniform": [0.0, 6.0]}}
TWO = PSI | {"delta": {"uniform": [0.0, 3.0]}}


@pytest.mark.parametrize(
    ("asked", "where", "sentence"),
    [
        ({"random": {}}, "study.random", "must be a table of random quantities"),
        ({"random": [1]}, "study.random", "must be a table of random quantities"),
        ({"random": {"psi": 3.0}}, "study.random.psi", "must be a table"),
        ({"random": {"psi": {}}}, "study.random.psi", "must be a table of one distribution"),
        ({"random": {"p1": {"speed": {"unform": [0, 1]}}}}, "study.random.p1.speed.unform", "did you mean 'uniform'"),
        ({"random": {"p1.speed": PSI["psi"], "p1": {"speed": PSI["psi"]}}}, "study.random.p1.speed", "given twice"),
        ({"random": {"drive": {"slope": PSI["psi"]}}}, "study.random.drive.slope", "the parameter along which is looked"),
        ({"samples": 100}, "study.samples", "multiple of 16 from 64 to 1048576, best a power of two"),
        ({"samples": 32}, "study.samples", "multiple of 16 from 64"),
        ({"samples": 64.5}, "study.samples", "must be a whole number"),
        ({"points": 1}, "study.points", "from 2 to 1000"),
        ({"seed": -1}, "study.seed", "not below 0"),
        ({"probability": 1.0}, "study.probability", "less than 1|lower|of less|must be"),
        ({"confidence": 95}, "study.confidence", "must be"),
        ({"outcome": "captive"}, "study.outcome", "'captive' is no outcome; did you mean 'captured'"),
        ({"outcome": ["captured", "unidentified"]}, "study.outcome", "cannot be counted"),
        ({"outcome": []}, "study.outcome", "must be an outcome or a list of them"),
        ({"at": 0.01}, "study.at", "allowed only with sensitivity = true"),
        ({"sensitivity_samples": 64}, "study.sensitivity_samples", "allowed only with sensitivity = true"),
        ({"sensitivity": True, "random": TWO}, "study.at", "this key is missing; needed is the value of drive.slope"),
        ({"sensitivity": True, "at": 0.01}, "study.sensitivity", "two random quantities or more"),
        ({"sensitivity": True, "at": 0.01, "random": TWO, "samples": 240}, "study.samples", "must be a power of two"),
        ({"sensitivity": "yes"}, "study.sensitivity", "true or false"),
        ({"inertia": True, "model": "full"}, "study.inertia", "allowed only with model = 'slow'"),
        ({"until": "0 s"}, "study.until", "greater than 0"),
    ],
)
def test_what_the_question_refuses(asked: dict[str, Any], where: str, sentence: str) -> None:
    given = {"along": "drive.slope", "range": [0.01, 0.02], "random": PSI} | asked
    with pytest.raises(InputError, match=sentence) as refused:
        CaptureProbability(**given)
    assert refused.value.where == where


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
    ("machine", "asked", "where", "sentence"),
    [
        (R1, {"along": "drive.slop"}, "study.along", "did you mean 'drive.slope'"),
        (R1, {"range": [0.02, 0.01]}, "study.range", "low below high"),
        (R1, {"range": [-0.02, 0.01]}, "study.range[0]", "at least 0|greater"),
        (R1, {"random": {"psy": PSI["psi"]}}, "study.random.psy", "neither a start state nor a parameter; did you mean 'psi'"),
        (R1, {"random": {"psi": {"uniform": ["0 m", 1.0]}}}, "study.random.psi.uniform[0]", "this one is a length"),
        (R1, {"start": {"psi": 1.0}}, "study.random.psi", "given by study.start too"),
        (R1, {"random": {"p1": PSI["psi"], "p1.angle": PSI["psi"]}}, "study.random.p1.angle", "another random quantity"),
        (R1, {"random": {"psi": PSI["psi"], "p1": PSI["psi"]}}, "study.random.p1", "give either psi and delta"),
        (R1, {"random": {"drum.mass": {"normal": [1.0, 1.0]}}}, "study.random.drum.mass", "reaches -.*does not allow.*between"),
        (NUMBERS, {"along": "u", "random": {"psi": {"uniform": ["0 s", 1.0]}}}, "study.random.psi.uniform[0]", "without unit"),
        (R1, {"random": TWO, "sensitivity": True, "at": "1 kg"}, "study.at[0]", "this one is a mass"),
        (rail(), {"along": "drum.mass", "random": {"b1": PSI["psi"]}}, "machine.drive", "nothing would turn"),
    ],
)
def test_what_does_not_fit_the_machine(machine: Machine, asked: dict[str, Any], where: str, sentence: str) -> None:
    given = {"along": "drive.slope", "range": [0.01, 0.02], "random": PSI, "samples": 64} | asked
    with pytest.raises(InputError, match=sentence) as refused:
        prepare(CaptureProbability(**given), machine)
    assert refused.value.where == where


def test_without_salib_the_sensitivity_is_refused_before_the_first_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(sobol_indices, "import_module", missing)
    spec = CaptureProbability(along="drive.slope", range=[0.01, 0.02], random=TWO, samples=64, sensitivity=True, at=0.01)
    with pytest.raises(InputError, match=r"pip install wucht\[sensitivity\]"):
        prepare(spec, R1)


def test_samples_that_fill_unevenly_are_warned_of() -> None:
    spec = CaptureProbability(along="drive.slope", range=[0.01, 0.02], random=PSI, samples=240)
    assert "samples = 240 is no power of two: Sobol' points fill evenly with 128 or 256" in prepare(spec, R1).warnings
    assert prepare(spec.model_copy(update={"samples": 128}), R1).warnings == ()
