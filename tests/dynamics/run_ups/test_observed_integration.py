"""A watched motion is one motion, whatever the parts in which it is integrated: its samples, releases and works."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wucht import RunUp, run
from wucht.dynamics.run_ups.observed_integration import Leg, ObservedIntegration
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver
from wucht.files.building import machine_from
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory

SPEED = 200.0
ROTOR = {"kind": "rotor", "name": "d", "mass": 10.0, "unbalance": 0.01, "inertia": 0.03}
ALONE = {
    "carrier": {"stiffness": 1e5, "damping": 200.0},
    "bodies": [ROTOR],
    "drive": {"kind": "linear", "slope": 0.04, "no_load_speed": SPEED},
}
PENDULUM = {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.125, "length": 0.104, "damping": 0.17}
RELEASES = [{"time": 0.05}, {"speed": 10.0}]


def _released(when: dict[str, float]) -> Machine:
    return machine_from(ALONE | {"bodies": [ROTOR, PENDULUM | {"release": when}]})


def _swing(result: Any) -> np.ndarray:
    """By how much (N,) the pendulum has moved on the rotor."""
    relative = (result.angle.sel(body="p") - result.angle.sel(body="d")).values
    return np.abs(relative - relative[0])


# --- samples ---


@pytest.mark.parametrize("until", [0.5, 0.7, 1.0])
def test_a_run_in_many_legs_has_each_sample_of_its_even_grid_once(until: float) -> None:
    result = run(RunUp(until=until), machine_from(ALONE))
    samples = math.ceil(until * 24 * SPEED / (2 * math.pi)) + 1
    assert result.time.values.tolist() == np.linspace(0.0, until, samples).tolist()


def test_a_run_until_settled_has_each_sample_once() -> None:
    time = run(RunUp(), machine_from(ALONE)).time.values
    assert time[0] == 0.0
    assert len(time) > 5000
    assert np.diff(time) == pytest.approx(np.full(len(time) - 1, time[1]), rel=1e-9)


def _watched(machine: Machine) -> tuple[ObservedIntegration, Leg]:
    placed, state = prepare_start(machine, {})
    watched = ObservedIntegration(
        MotionObserver(placed, 2 * math.pi / SPEED, Noise.of()),
        compile_system(placed.system),
        lambda motion: motion,
        SPEED,
        1.0,
    )
    return watched, watched.begin(state, placed.system.values(placed.values))


def test_a_coarse_grid_that_is_integrated_piece_by_piece_has_each_sample_once() -> None:
    """Six samples over 2400 turns, of which only a thousand are held at once."""
    machine, grid = machine_from(ALONE | {"carrier": {"directions": "fixed"}}), np.linspace(0.0, 75.0, 6)
    watched, first = _watched(machine)
    leg = watched.leg(first, grid)
    whole = Trajectory.of([first.trajectory, leg.trajectory])
    assert whole.time.tolist() == grid.tolist()
    exact = integrate(watched.compiled_system, first.trajectory.end_state, first.trajectory.final_parameter_values, grid)
    assert whole.states == pytest.approx(exact.states, rel=1e-10)
    seen = watched.observation(leg).rotors["d"].whole.angle[-1]
    assert seen == pytest.approx(float(exact.states[0, -1]), abs=2 * math.pi)


# --- releases ---


@pytest.mark.slow
@pytest.mark.parametrize("when", RELEASES, ids=["time", "speed"])
def test_a_released_body_stays_free_in_the_legs_that_follow(when: dict[str, float]) -> None:
    """It is released in the first leg of several: the run is that of a single integration."""
    result = run(RunUp(until=0.5, start={"p": 0.7}), _released(when))
    machine, state = prepare_start(_released(when), {"p": 0.7})
    whole = integrate(compile_system(machine.system, events=release_events(machine)), state, machine.values, result.time.values)
    assert len(whole.hits) == 1
    assert whole.hits[0].time < 0.06
    for body in machine.bodies:
        alone = whole.states[machine.row(body.coordinate.position)]
        assert result.angle.sel(body=body.name).values == pytest.approx(alone)
    assert _swing(result)[-1] > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("when", RELEASES, ids=["time", "speed"])
def test_a_released_body_is_free_where_a_run_is_taken_up_again(when: dict[str, float], tmp_path: Path) -> None:
    machine, asked = _released(when), RunUp(until=0.5, start={"p": 0.7})

    def stop(share: float, _what: str) -> None:
        if share > 0.4:
            raise KeyboardInterrupt

    whole = run(asked, machine)
    part = run(asked, machine, folder=tmp_path, progress=stop)
    assert 0.05 < part.attrs["end_time"] < 0.4
    again = run(asked, machine, folder=tmp_path, resume=True)
    assert again.attrs["finished"] == 1
    np.testing.assert_array_equal(again.angle.values, whole.angle.values)
    assert _swing(again)[-1] > 0.1


# --- works ---


@pytest.mark.parametrize("share", [1e-12, 1e6])
def test_the_energy_closes_whatever_its_size(share: float) -> None:
    """Masses, springs, dampers and the motor of such a share: works of nanojoules or of hundreds of megajoules, one motion."""
    carrier = {key: share * value for key, value in ALONE["carrier"].items()}
    rotor = {key: share * value if isinstance(value, float) else value for key, value in ROTOR.items()}
    drive = ALONE["drive"] | {"slope": share * 0.04}
    ends = []
    for document in (ALONE, {"carrier": carrier, "bodies": [rotor], "drive": drive}):
        result = run(RunUp(until=2.0), machine_from(document))
        assert result.wucht.summary["energy_residual"] < 1e-11
        ends.append(float(result.angle[0, -1]))
    assert ends[1] == pytest.approx(ends[0], abs=1e-8)
