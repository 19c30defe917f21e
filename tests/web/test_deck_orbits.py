"""The orbits of a deck's ends and centre of mass, as the page draws them: those of Python's run, and within the picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.web.page_answers import answer, page_text

from wucht import Machine
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.machine_shape import machine_shape
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.studies.study_file import read_study
from wucht.studies.subjects import MACHINE

CANVAS = 640, 480
ORBITS = "orbits of the carrier's ends and centre of mass"


def deck_places(machine: Machine) -> np.ndarray:
    """Left end of the deck that a report draws, centre of mass, right end, (3, 2)."""
    description = MACHINE.describe(machine)
    shape = machine_shape(description.facts["bodies"], machine.values, description.parts, dimensionless=False)
    return np.array([[shape.box[0], 0.0], [0.0, 0.0], [shape.box[2], 0.0]])


def displacements(machine: Machine, state: np.ndarray, time: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Displacements from rest of places on the carrier in Python's run, (k, N, 2). The model's turns are small."""
    system = compile_system(machine.system, 1e-13)
    motion = integrate(system, state, machine.system.values(machine.values), np.array([0.0, *time]))
    rows = [machine.state_names.index(f"carrier.{name}") for name in "xyr"]
    x, y, r = motion.states[rows, 1:] - machine.rest[[machine.labels.index(name) for name in "xyr"], None]
    return np.array([np.stack([x - b * r, y + a * r], axis=1) for a, b in places])


def size_of(orbit: np.ndarray) -> float:
    """The largest distance of an orbit's points from their mean."""
    return float(np.linalg.norm(orbit - orbit.mean(axis=0), axis=1).max())


def check_orbits(
    folder: Path, name: str, times: list[float], default_start: dict[str, float] | None = None
) -> list[np.ndarray]:
    """Compare what is drawn at some times with Python's run to 1e-6 of each orbit's size. Returns the drawn displacements.

    default_start: of a study that names none.
    """
    study = read_study(name)
    machine = study.subject
    assert isinstance(machine, Machine)
    state = initial_state(machine, getattr(study.spec, "start", {}) or default_start or {})
    job = {"scenario": {"until": max(times) * 1.001}, "times": times, "tolerance": 1e-12}
    result = answer(folder, page_text(name), "orbits", **job)
    assert ORBITS in result["description"]
    places, drawn = deck_places(machine), []
    for orbit in result["orbits"]:
        assert orbit["places"] == pytest.approx(places, rel=1e-12)
        drawn.append(np.array(orbit["displacements"]))
        expected = displacements(machine, state, np.array(orbit["time"]), places)
        for points, reference in zip(drawn[-1], expected, strict=True):
            assert np.abs(points - reference).max() < 1e-6 * size_of(reference)
    return drawn


@pytest.mark.slow
@pytest.mark.parametrize(("name", "times"), [("practice/screen", [0.15, 1.0]), ("practice/fan-on-belt", [2.0])])
def test_orbits_of_a_deck_that_pitches_are_those_of_python(tmp_path: Path, name: str, times: list[float]) -> None:
    for left, centre, right in check_orbits(tmp_path, name, times):
        assert np.abs(left - right).max() > 0.1 * size_of(centre)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "until"),
    [("practice/screen", 1.0), ("practice/screen-loaded", 1.0)],
)
def test_orbits_of_the_ends_stay_in_the_picture_and_are_large(tmp_path: Path, name: str, until: float) -> None:
    """At most a fifth of the deck from rest; 2 % beyond, as the largest of 16 samples a turn may be less than the peak."""
    times = np.linspace(0, until, 201)[1:].tolist()
    result = answer(tmp_path, page_text(name), "orbits", scenario={"until": until}, times=times, tolerance=1e-6)
    pixels = np.concatenate([np.concatenate(orbit["pixels"]) for orbit in result["orbits"]])
    assert pixels.min() > 0
    assert (pixels.max(axis=0) < CANVAS).all()
    moved = max(
        np.linalg.norm(points, axis=1).max() for orbit in result["orbits"] for points in map(np.array, orbit["displacements"])
    )
    (left, _), _, (right, _) = result["orbits"][0]["places"]
    assert 0.08 < result["magnification"] * moved / (right - left) <= 0.2 * 1.02
    largest = max(np.ptp(np.array(ends), axis=0).max() for orbit in result["orbits"] for ends in orbit["pixels"])
    assert largest > 40


@pytest.mark.slow
def test_orbits_are_drawn_about_the_rest_of_changed_springs(tmp_path: Path) -> None:
    """Harder springs, from 1 s on: the deck rests nearly 5 mm higher, much more than its orbits are large."""
    changes = [{"time": 1, "parameters": {f"carrier.mounts.{k}.stiffness.y": 150e3 for k in (1, 2)}}]
    job = {"scenario": {"until": 9, "changes": changes}, "times": [9], "tolerance": 1e-6}
    (orbit,) = answer(tmp_path, page_text("practice/screen"), "orbits", **job)["orbits"]
    for points in np.array(orbit["displacements"]):
        assert np.linalg.norm(points.mean(axis=0)) < 0.1 * size_of(points)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "practice/laundry-drum",
    ],
)
def test_a_carrier_that_does_not_turn_has_the_orbit_of_its_axis_alone(tmp_path: Path, name: str) -> None:
    result = answer(tmp_path, page_text(name), "orbits", scenario={"until": 1}, times=[1], tolerance=1e-6)
    assert result["orbits"][0]["pixels"] == []
    assert "orbits" not in result["description"]
