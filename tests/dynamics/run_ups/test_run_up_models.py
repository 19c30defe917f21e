"""The averaged model of a run-up in either sense, and the signals that are compared."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.deviations import compared_motion
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up_models import FullModel, slow_model
from wucht.files.building import machine_from
from wucht.machines.machine import DISSIPATED_WORK
from wucht.mechanics.rotating_bodies.solution import VIBRATION_WORK
from wucht.numerics.flow.trajectory import Trajectory

SLOPE, FREE = 0.01, 200.0


def machine(sense: float = 1.0, drive: bool = True, **more: Any) -> Any:
    table = {
        "carrier": {"mass": 1.0, "directions": "x", "stiffness": 1e4, "damping": 5.0},
        "bodies": [
            {"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01},
            {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.05, "length": 0.1, "damping": 0.01},
        ],
    }
    motor = {"on": "a", "kind": "linear", "slope": SLOPE, "no_load_speed": sense * FREE}
    return machine_from(table | ({"drive": motor} if drive else {}) | more)


def model(of: Any, **start: Any) -> Any:
    return slow_model(of, initial_state(of, start), None, 1)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_angle_is_positive_in_the_sense_of_the_rotor(sense: float) -> None:
    of = machine(sense)
    start = {"a": {"angle": sense * 3.0, "speed": sense * 40.0}, "p": {"angle": sense * 0.5, "speed": sense * 40.0}}
    slow = model(of, **start)
    states = dict(zip([s.name for s in slow.system.states], slow.initial.tolist(), strict=True))
    assert slow.averaged_equations.senses["a"] == sense and slow.initial[-1] == pytest.approx(3.0)
    assert states["a.speed"] == pytest.approx(40.0) and states["p.phase"] == pytest.approx(0.5)


def trajectory(slow: Any, speed: float) -> Trajectory:
    """Two instants at a steady speed (positive in the rotor's sense), the phase at rest."""
    time = np.array([0.0, 0.01])
    names = [s.name for s in slow.system.states]
    rows = {"a.speed": np.full(2, speed), "p.phase": np.full(2, 0.5)}
    states = np.array([rows.get(n, speed * time) for n in names])
    works = {q.name: np.array([0.0, k + 1.0]) for k, q in enumerate(slow.system.quadratures)}
    return Trajectory(time, states, works, np.array(slow.parameter_values), 0.01, states[:, -1])


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_torques_and_works_of_the_averaged_motion(sense: float) -> None:
    """k (W - w) with the sign of its axis, times the speed a power; and all losses together."""
    of = machine(sense)
    slow = model(of)
    motion = trajectory(slow, 150.0)
    whole = slow.machine_motion(motion)
    assert (
        whole.quadratures[DISSIPATED_WORK].tolist()
        == (motion.quadratures[DISSIPATED_WORK] + motion.quadratures[VIBRATION_WORK]).tolist()
    )
    assert VIBRATION_WORK not in whole.quadratures
    rows = slow.rows(motion, whole)
    torque = sense * SLOPE * (FREE - 150.0)
    assert rows["motor_torque"] == pytest.approx([torque] * 2) and rows["drive_torque"] == pytest.approx([torque] * 2)

    speed = rows[of.rotor.coordinate.velocity.name]
    assert np.sign(speed).tolist() == [sense] * 2 and rows["motor_power"] == pytest.approx(torque * speed)
    assert rows[of.rotor.coordinate.position.name] == pytest.approx(sense * motion.states[-1], abs=1e-3)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_signals_that_are_compared_are_positive_in_the_sense_of_the_rotor(sense: float) -> None:
    of = machine()
    time = np.linspace(0.0, 1.0, 5)
    a, p, v = of.rotor.coordinate.position.name, of.body("p").coordinate.position.name, of.rotor.coordinate.velocity.name
    rows = {a: sense * (1 + 9 * time), p: sense * (1 + 9 * time - 0.25), v: sense * 9 + 0 * time, "orbit.x": 0.5 + 0 * time}
    full = FullModel(of, initial_state(of, {}))
    assert full.events(()) == ()
    rest = SimpleNamespace(time=time)
    names = {f"orbit.{k}{n}": 0 * time for n in of.orbit for k in ("", "v")}
    motion: Any = SimpleNamespace(case=SimpleNamespace(machine=of), rows=names | rows, machine_motion=rest)
    found = compared_motion(motion)
    assert found.angle == pytest.approx(1 + 9 * time) and found.speed == pytest.approx(np.full((1, 5), 9.0))
    assert found.phase == pytest.approx(np.full(5, -0.25))
    assert found.radius == pytest.approx(np.full(5, 0.5), abs=1e-3)
