"""Torques over the speed in the page: those of the study torque-balance, for the bodies at the same phases."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.typescript_jobs import run_jobs

from wucht import Machine, TorqueBalance, load_machine
from wucht.analysis.vibration import ForcedVibration
from wucht.analysis.working_points import TorqueCurves
from wucht.dynamics.live_machine import export_obstacles, machine_script
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.torque_hills import torque_hills, unavailability_reason
from wucht.errors import InputError
from wucht.files.catalogue import load_document, names
from wucht.machines.operation import free_speed

POINTS = 100
FAMILIES = [
    "drozdetskaya-2020/r1", "drozdetskaya-2020/figure-6.5", "drozdetskaya-2020/table-5.1", "practice/fan-on-belt",
    "practice/fan-on-inverter", "practice/laundry-drum", "practice/screen", "sperling-vibration/figure-2a",
    "sperling-vibration/lock-limits",
]  # fmt: skip


@cache
def machine_at_start(name: str) -> tuple[Machine, np.ndarray]:
    """A machine of the catalogue as its run-up starts it."""
    study = load_document(name)[0].get("study", {})
    machine = load_machine(name)
    state = initial_state(machine, study.get("start", {}) if study.get("kind") == "run-up" else {})
    return machine_in_state(machine, state), state


def machine_names() -> list[str]:
    """Machines of the catalogue that can be exported."""
    return [n for n in names() if "machine" in load_document(n)[0] and not export_obstacles(machine_at_start(n)[0])]


def curves_of(machine: Machine, state: np.ndarray, rotor: int) -> TorqueCurves:
    """Python's torques over the speed, with the bodies at the phases of a state, at the end of all schedules."""
    steady = machine.at(machine.breakpoints[-1])
    angles = np.array([state[machine.row(b.coordinate.position)] for b in machine.bodies])
    shaft = steady.rotors[rotor]
    end = 1.5 * (free_speed(steady, shaft) or 300.0)
    return TorqueCurves(steady, shaft, ForcedVibration.of(steady, angles), (min(0.0, end), max(0.0, end)), POINTS)


def with_phases(machine: Machine, state: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """A state at standstill with random angles."""
    changed = state.copy()
    for b in machine.bodies:
        changed[machine.row(b.coordinate.position)] = generator.uniform(-3.0, 3.0)
        if b.coordinate.prescribed_velocity is None:
            changed[machine.row(b.coordinate.velocity)] = 0.0
    return changed


def check_torques(folder: Path, chosen: list[str]) -> int:
    """Compare drive, load and vibration at 100 speeds, each to 1e-12 of its largest nearby. Returns the number of curves."""
    generator, jobs, expected = np.random.default_rng(51), [], []
    for name in chosen:
        machine, start = machine_at_start(name)
        if unavailability_reason(machine):
            continue
        script, state, data = (
            machine_script(machine, start),
            with_phases(machine, start, generator),
            torque_hills(machine)[0],
        )
        for k, rotor in enumerate(data["rotors"]):
            if rotor["is_driven"]:
                curves = curves_of(machine, state, k)
                speeds = np.linspace(*curves.range, POINTS + 2)[1:-1]
                job = {"kind": "torques", "rotor": k, "speeds": speeds.tolist(), "state": state.tolist()}
                jobs.append((script, job | {"time": machine.breakpoints[-1] + 1.0}))
                expected.append((f"{name} {rotor['name']}", curves.torques(speeds)[0]))
    differences = {}
    for (name, reference), answer in zip(expected, run_jobs(folder, jobs), strict=True):
        values = np.array(answer["torques"]).reshape(-1, 3).T
        assert values.shape == reference.shape == (3, POINTS)
        # Near a crossing of zero Python's rounding is as large as the difference.
        size = np.maximum(np.abs(reference), 1e-2 * np.median(np.abs(reference), axis=1)[:, None]) + 1e-300
        differences[name] = float((np.abs(values - reference) / size).max())
    assert {name: d for name, d in differences.items() if not d <= 1e-12} == {}
    return len(differences)


def test_torques_of_a_machine_of_each_family_are_those_of_python(tmp_path: Path) -> None:
    """Motors of all kinds, tables, schedules, several rotors, a shaken carrier, a machine without units."""
    assert check_torques(tmp_path, FAMILIES) == 11


@pytest.mark.slow
def test_torques_of_the_whole_catalogue_are_those_of_python(tmp_path: Path) -> None:
    assert check_torques(tmp_path, machine_names()) > 80


def test_hills_are_there_where_the_study_has_its_balance() -> None:
    """And say why where they are not; the study's ``bodies = "held"`` has the phases of the start."""
    differing = {}
    for name in (*FAMILIES, "practice/laundry-drum-friction"):
        machine, _ = machine_at_start(name)
        try:
            TorqueBalance(bodies="held").prepare(machine)
            is_defined = True
        except InputError:
            is_defined = False
        if (unavailability_reason(machine) == "") != is_defined:
            differing[name] = unavailability_reason(machine)
    assert differing == {}
    friction, _ = machine_at_start("practice/laundry-drum-friction")
    assert torque_hills(friction)[0] == {
        "available": False,
        "reason": "the vibration torque is known for a linear carrier only: the dry friction of 'left' is not linear",
    }


def test_working_points_and_their_stability_are_those_of_python(tmp_path: Path) -> None:
    """R1 with pendulums beside the unbalance: a slow, a middle and a fast speed balance."""
    machine, start = machine_at_start("drozdetskaya-2020/r1")
    state = start.copy()
    for name, angle in (("p1", 1.1), ("p2", -1.1)):
        state[machine.row(machine.body(name).coordinate.position)] = angle
    curves = curves_of(machine, state, 0)
    script, trace = machine_script(machine, state), {"speedTrace": [0.0, 50.0], "torqueTrace": [1.0, 2.0]}
    speeds = np.linspace(*curves.range, 2000).tolist()
    job = {"kind": "torques", "rotor": 0, "speeds": speeds, "time": 0.0, "state": state.tolist()}
    grid, drawing = run_jobs(tmp_path, [(script, job), (script, {"kind": "hill", "time": 0.0, **trace})])
    expected = [(p.speed, p.torque, p.stable) for p in curves.working_points]
    assert len(expected) == 3
    for points in (grid["points"], drawing["points"]):
        assert [p["stable"] for p in points] == [stable for _, _, stable in expected] == [True, False, True]
        assert [p["speed"] for p in points] == pytest.approx([speed for speed, _, _ in expected], rel=1e-9)
        assert [p["torque"] for p in points] == pytest.approx([torque for _, torque, _ in expected], rel=1e-7)
    assert drawing["rotors"] == ["drum"]
    assert {"speed in rpm", "torque in N·m", "motor", "vibration", "stable", "unstable", "now"} <= set(drawing["words"])
    assert len(drawing["arcs"]) == 7  # three working points, where the rotor is now, and what the three marks mean
    free = free_speed(machine, machine.rotor)
    assert free is not None
    assert grid["range"] == pytest.approx([0.0, 1.2 * free], rel=1e-9)


def test_vibration_of_a_rotor_at_another_speed_is_left_out(tmp_path: Path) -> None:
    """Its phase goes round: the mean of its torque is zero. Python, with the other unbalance zero, is the witness."""
    name = "sperling-vibration/lock-limits"
    machine, start = machine_at_start(name)
    state = start.copy()
    state[machine.row(machine.rotors[0].coordinate.velocity)] = 10.0
    state[machine.row(machine.rotors[1].coordinate.velocity)] = 11.0
    other = machine.rotors[1].name
    path = next(p for p in (f"{other}.eccentricity", f"{other}.unbalance") if p in machine.values)
    alone = curves_of(machine.with_values({path: 0.0}), start, 0)
    speeds = np.linspace(*alone.range, 20)[1:]
    job: Mapping[str, Any] = {"kind": "torques", "rotor": 0, "speeds": speeds.tolist(), "time": 0.0, "state": state.tolist()}
    together = curves_of(machine, start, 0).torques(speeds)[0][2]
    (answer,) = run_jobs(tmp_path, [(machine_script(machine, start), job)])
    vibration = np.array(answer["torques"]).reshape(-1, 3)[:, 2]
    assert vibration == pytest.approx(alone.torques(speeds)[0][2], rel=1e-10)
    assert np.abs(vibration - together).max() > 0.1 * np.abs(together).max()
