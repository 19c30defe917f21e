"""Switches of drives in the exported machine: off, it moves as Python's machine without the drive."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.node import run_in_node

import wucht
from wucht import load_machine
from wucht.dynamics.drive_switches import switch_path, switchable_drives, with_switches
from wucht.dynamics.live_machine import machine_script
from wucht.dynamics.run_ups.coasting import without_drives
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.run_ups.operating_state import transfer_state
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

RUN = """
const [engine, script, job] = process.argv.slice(-3);
const { Integrator } = await import(engine);
const { machine } = await import(script);
const { state, off, end } = JSON.parse(job);
const integrator = new Integrator(machine, 1e-11);
integrator.equations.setParameters(machine.parameters.map(({ path, value }) => (path === off ? 0 : value)));
integrator.start(0, state);
integrator.advance([end], new Float64Array(state.length));
console.log(JSON.stringify([...integrator.state]));
"""


def end_state(machine: Machine, state: np.ndarray, end: float) -> np.ndarray:
    values = machine.system.values(machine.values)
    states = integrate(compile_system(machine.system, 1e-13), state, values, np.array([0.0, end])).states
    return np.asarray(states[:, -1])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "end"), [("practice/screen", 0.8), ("practice/fan-on-belt", 1.0), ("practice/laundry-drum", 0.5)]
)
def test_a_drive_that_is_switched_off_gives_no_torque(tmp_path: Path, name: str, end: float) -> None:
    """Two induction motors of which one is off, a motor behind a belt with losses, a motor with a current."""
    loaded = load_machine(name)
    state = initial_state(loaded, {})
    machine = machine_in_state(loaded, state)
    drive = switchable_drives(machine)[-1]
    rotor = machine.row(machine.body(drive.on).coordinate.velocity)
    state[rotor] = 100.0
    exported, lost = with_switches(machine), without_drives(machine, [drive])
    (tmp_path / "machine.mjs").write_text(machine_script(exported, state), encoding="utf-8")
    (tmp_path / "run.mjs").write_text(RUN, encoding="utf-8")
    job = json.dumps({"state": state.tolist(), "off": switch_path(drive), "end": end})
    engine = Path(wucht.__file__).parent / "web" / "integrator.ts"
    answer = json.loads(run_in_node(tmp_path / "run.mjs", engine.as_uri(), (tmp_path / "machine.mjs").as_uri(), job))
    values = dict(zip(machine.state_names, answer, strict=True))
    expected = dict(zip(lost.state_names, end_state(lost, transfer_state(machine, state, lost, 0.0), end), strict=True))
    driven = dict(zip(machine.state_names, end_state(machine, state, end), strict=True))
    speed = machine.state_names[rotor]
    assert abs(driven[speed] - expected[speed]) > 1e-4 * abs(expected[speed])  # with its drive it moves otherwise
    for state_name in set(expected) & set(values):
        assert values[state_name] == pytest.approx(expected[state_name], rel=1e-6, abs=1e-7)


def test_a_drive_that_enforces_a_speed_has_no_switch() -> None:
    machine = load_machine("sperling-rollers/table-1")
    assert machine.drives
    assert switchable_drives(machine) == ()
    assert with_switches(machine).parameters == machine.parameters


def test_a_machine_with_switches_moves_as_without() -> None:
    machine = load_machine("drozdetskaya-2020/r1")
    exported = with_switches(machine)
    state = initial_state(machine, {"p1": 0.3, "p2": -0.5})
    assert exported.state_names == machine.state_names
    assert np.abs(end_state(exported, state, 1.0) - end_state(machine, state, 1.0)).max() < 1e-8
