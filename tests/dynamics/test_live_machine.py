"""Machines in JavaScript: their equations and their motion are those of Python."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.node import run_in_node

import wucht
from wucht import Machine, load_machine
from wucht.dynamics.live_machine import export_obstacles, machine_description, machine_script
from wucht.dynamics.run_ups.horizon import Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.verdicts.observation import AxisMotion, rows_of
from wucht.errors import WuchtError
from wucht.files.catalogue import load_document, names
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import lower
from wucht.numerics.flow.trajectory import Trajectory
from wucht.system import Output

ENGINE, JOBS = Path(wucht.__file__).parent / "web", Path(__file__).with_name("live_machine_jobs.mjs")
POINTS = 100
SIZES = {"rad": 10.0, "rad/s": 100.0, "m": 0.01, "m/s": 1.0}
FAMILIES = [
    "drozdetskaya-2020/r1", "drozdetskaya-2020/figure-6.5", "drozdetskaya-2020/table-5.1", "practice/fan-on-belt",
    "practice/fan-on-inverter", "practice/laundry-drum", "practice/laundry-drum-friction", "practice/screen",
    "sperling-vibration/figure-2a",
]  # fmt: skip
RELEASES = {"sperling-vibration/figure-4", "sperling-vibration/figure-4-y-blocked", "sperling-vibration/table-1"}


def catalogue_machines() -> dict[str, tuple[Machine, np.ndarray]]:
    """All machines of the catalogue; the rest are equations and cams."""
    return {name: catalogue_machine(name) for name in names() if "machine" in load_document(name)[0]}


@cache
def catalogue_machine(name: str) -> tuple[Machine, np.ndarray]:
    """A machine as its run-up starts it."""
    study = load_document(name)[0].get("study", {})
    return in_start(load_machine(name), study.get("start", {}) if study.get("kind") == "run-up" else {})


def in_start(machine: Machine, start: Mapping[str, Any]) -> tuple[Machine, np.ndarray]:
    state = initial_state(machine, start)
    return machine_in_state(machine, state), state


def answers(folder: Path, jobs: Sequence[tuple[str, Mapping[str, Any]]]) -> list[Any]:
    """Results of jobs, each of a machine's script, in one process."""
    entries = []
    for i, (script, job) in enumerate(jobs):
        path = folder / f"machine-{i}.mjs"
        path.write_text(script, encoding="utf-8")
        entries.append({"script": str(path), **job})
    (folder / "jobs.json").write_text(json.dumps(entries), encoding="utf-8")
    run_in_node(JOBS, ENGINE, folder / "jobs.json", folder / "results.json")
    results: list[Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return results


def random_points(machine: Machine, description: Mapping[str, Any], generator: np.random.Generator) -> list[dict[str, Any]]:
    """Random states and values of parameters, at times before, within and after schedules."""
    sizes = np.array([SIZES.get(state["unit"], 1.0) for state in description["states"]])
    values = np.array([parameter["value"] for parameter in description["parameters"]])
    return [
        {
            "time": generator.uniform(0.0, 1.2) * max(machine.breakpoints[-1], 1.0),
            "state": (sizes * generator.uniform(-1.0, 1.0, len(sizes))).tolist(),
            "parameters": (values * generator.uniform(0.8, 1.2, len(values))).tolist(),
        }
        for _ in range(POINTS)
    ]


def evaluated(machine: Machine, outputs: Sequence[Output], points: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Python's rates and outputs at the points, (POINTS, k)."""
    system = machine.system
    program = lower(system, [*system.derivatives, *(o.expression for o in outputs)])
    constants = np.array([program.constant_values(p["parameters"]) for p in points]).T
    states, time = np.array([p["state"] for p in points]).T, np.array([p["time"] for p in points])
    values = program.function()(tuple(states), time, tuple(constants))
    return np.array([np.broadcast_to(v, time.shape) for v in values]).T


def check_equations(folder: Path, machines: Mapping[str, tuple[Machine, np.ndarray]]) -> None:
    """Compare rates and outputs with Python's at random states and values of parameters, each number to 1e-12 of itself."""
    generator, jobs, expected = np.random.default_rng(38), [], []
    for name, (machine, state) in machines.items():
        description = machine_description(machine, state)
        points, shown = random_points(machine, description, generator), [o["name"] for o in description["outputs"]]
        outputs = [o for o in machine.system.outputs if o.name in shown]
        places = [shown.index(o.name) for o in outputs]
        jobs.append((machine_script(machine, state), {"points": points}))
        expected.append((name, places, evaluated(machine, outputs, points)))
    differences = {}
    for (name, places, reference), answer in zip(expected, answers(folder, jobs), strict=True):
        values = np.array([[*a["rates"], *(a["outputs"][i] for i in places)] for a in answer], float)
        assert np.isfinite(reference).all()
        # Where terms cancel to less than a hundredth of the usual number, Python's rounding is as large as the difference.
        size = np.maximum(np.abs(reference), 0.01 * np.median(np.abs(reference), axis=0)) + 1e-300
        differences[name] = float((np.abs(values - reference) / size).max())
    assert {name: d for name, d in differences.items() if not d <= 1e-12} == {}


@pytest.mark.slow
def test_equations_of_a_machine_of_each_family_are_those_of_python(tmp_path: Path) -> None:
    """Contacts, friction, motors with states, a law within a law, schedules, quantities without units, a shaken carrier."""
    check_equations(tmp_path, {name: catalogue_machine(name) for name in FAMILIES})


def test_torques_on_several_rotors_are_those_of_all_drives(tmp_path: Path) -> None:
    machine, state = catalogue_machine("practice/screen")
    description = machine_description(machine, state)
    points = random_points(machine, description, np.random.default_rng(1))
    (answer,) = answers(tmp_path, [(machine_script(machine, state), {"points": points})])
    whole, *each = (place_of(description["outputs"], f"drive_torque{rotor}") for rotor in ("", "[e1]", "[e2]"))
    torques = np.array([a["outputs"] for a in answer])
    assert np.abs(torques[:, each]).min() > 0
    assert torques[:, each].sum(axis=1) == pytest.approx(torques[:, whole], rel=1e-9)


@pytest.mark.slow
def test_equations_of_the_whole_catalogue_are_those_of_python(tmp_path: Path) -> None:
    machines = {name: m for name, m in catalogue_machines().items() if name not in RELEASES}
    assert len(machines) == 92
    check_equations(tmp_path, machines)


def test_a_machine_can_be_exported_or_says_why() -> None:
    obstacles = {name: export_obstacles(catalogue_machine(name)[0]) for name in (*FAMILIES, *RELEASES)}
    sentence = "bodies of a live machine are free from the start, and these have a release: b1, b2"
    assert {name: o for name, o in obstacles.items() if o} == dict.fromkeys(RELEASES, (sentence,))
    with pytest.raises(WuchtError, match=f"cannot be exported: {sentence}"):
        machine_script(*catalogue_machine("sperling-vibration/table-1"))


def motion_in_python(machine: Machine, state: np.ndarray, end: float, count: int, tolerance: float = 1e-13) -> Trajectory:
    return integrate(
        compile_system(machine.system, tolerance), state, machine.system.values(machine.values), np.linspace(0, end, count)
    )


def motion_in_node(answer: Mapping[str, Any], count: int) -> tuple[np.ndarray, np.ndarray]:
    """States and outputs of a run, (n, count) and (m, count)."""
    assert (answer["ending"], answer["samples"]) == ("end", count)
    states, outputs = (np.array(answer[key], float).reshape(count, -1).T for key in ("states", "outputs"))
    return states, outputs


def place_of(entries: Sequence[Mapping[str, Any]], name: str) -> int:
    return [entry["name"] for entry in entries].index(name)


def test_r1_runs_up_as_in_python(tmp_path: Path) -> None:
    """Over 320 turns of the no-load speed; the error falls with the tolerance."""
    machine, state = catalogue_machine("drozdetskaya-2020/r1")
    end, count, job = 20.0, 2001, {"end": 20.0, "count": 2001}
    reference = motion_in_python(machine, state, end, count)
    script, description = machine_script(machine, state), machine_description(machine, state)
    fine, coarse = answers(tmp_path, [(script, job | {"tolerance": tolerance}) for tolerance in (1e-8, 1e-6)])
    states, outputs = motion_in_node(fine, count)
    angles = description["angles"]
    phase_errors = np.abs(states - reference.states)[angles, -1]
    assert phase_errors.max() < 1e-5
    assert phase_errors.max() < 0.1 * np.abs(motion_in_node(coarse, count)[0] - reference.states)[angles, -1].max()
    speed = place_of(description["outputs"], "speed[drum]")
    assert outputs[speed, -1] == pytest.approx(reference.states[machine.row(machine.rotor.coordinate.velocity), -1], rel=1e-6)
    amplitude = outputs[place_of(description["outputs"], "amplitude")]
    assert amplitude[-1] == pytest.approx(np.hypot(*reference.states[:2, -1]), rel=1e-6)
    assert amplitude.max() == pytest.approx(np.hypot(*reference.states[:2]).max(), rel=1e-6)


# Balls that collide during the whole run-up: differences of rounding grow. And machines of questions without a run-up: at their
# values the motion leaves all bounds, in Python as well; nothing drives the disc.
CHAOTIC, WITHOUT_RUN_UP = {"practice/fan-ball-ring"}, {"drozdetskaya-2020/figure-6.7a", "sperling-vibration/figure-7"}


@pytest.mark.slow
def test_each_machine_of_the_catalogue_ends_as_in_python(tmp_path: Path) -> None:
    """After the first part of a run-up: the speed of its rotor, and the amplitude as a share of the largest."""
    names = set(catalogue_machines()) - RELEASES - CHAOTIC - WITHOUT_RUN_UP
    machines, count = {name: catalogue_machine(name) for name in sorted(names)}, 401
    ends = [Horizon.of(machine, RunSettings(), state).first for machine, state in machines.values()]
    jobs = [
        (machine_script(machine, state), {"end": end, "count": count, "tolerance": 1e-11})
        for (machine, state), end in zip(machines.values(), ends, strict=True)
    ]
    differences = {}
    for (name, (machine, state)), end, answer in zip(machines.items(), ends, answers(tmp_path, jobs), strict=True):
        reference, (_, outputs) = motion_in_python(machine, state, end, count, 1e-11), motion_in_node(answer, count)
        assert reference.failure is None, name
        description = machine_description(machine, state)
        speed = outputs[place_of(description["outputs"], f"speed[{machine.rotor.name}]"), -1]
        amplitude = outputs[place_of(description["outputs"], "amplitude")]
        expected = AxisMotion.of(machine, reference.time, rows_of(compile_system(machine.system, 1e-12), reference)).distance
        size, turning = max(expected.max(), 1e-300), machine.rotor.coordinate.prescribed_velocity is None
        ending = reference.states[machine.row(machine.rotor.coordinate.velocity), -1] if turning else speed
        differences[name] = max(abs(speed / ending - 1), abs(amplitude[-1] - expected[-1]) / size)
    assert len(differences) == 89
    assert {name: d for name, d in differences.items() if not d <= 1e-6} == {}


@pytest.mark.slow
def test_balls_of_a_washing_machine_push_each_other_as_in_python(tmp_path: Path) -> None:
    """The balls leave the bottom of the ring and collide: each contact is a spring that is switched on and off."""
    machine, state = catalogue_machine("practice/laundry-drum")
    end, count = 8.0, 4001
    reference = motion_in_python(machine, state, end, count).states
    description = machine_description(machine, state)
    (answer,) = answers(tmp_path, [(machine_script(machine, state), {"end": end, "count": count, "tolerance": 1e-12})])
    states, _ = motion_in_node(answer, count)
    switches = 0
    for k, contact in enumerate(description["contacts"]):
        a, b = (reference[machine.row(machine.body(name).coordinate.position)] for name in contact["bodies"])
        in_contact = b - a + machine.values[f"tracks.ring.offset_{k + 1}"] < 0
        switches += int(np.count_nonzero(np.diff(in_contact)))
    assert switches >= 10
    assert answer["switches"] >= switches
    assert np.abs(states - reference).max() < 1e-6


def test_a_title_cannot_end_the_script() -> None:
    machine, state = catalogue_machine("drozdetskaya-2020/r1")
    title = '</script><script>"'
    script = machine_script(machine.with_fields(title=title), state)
    assert "<" not in script
    assert machine_description(machine.with_fields(title=title), state)["title"] == title
