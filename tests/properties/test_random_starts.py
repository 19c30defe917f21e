"""What starts at random may start anywhere in a turn: every quarter of it is as likely as another."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht.dynamics.balancers.candidates import phases
from wucht.dynamics.run_ups.initial_state import angles_in, initial_state
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

TURN = 2 * np.pi
PENDULUM = {"kind": "pendulum", "about": "ring", "mass": 0.05, "length": 0.1, "damping": 0.01}
BALL = {
    "kind": "roller", "name": "b", "about": "ring", "mass": 2e-3, "track_radius": 0.03, "radius": 4e-3, "shape_factor": 0.4,
    "damping": 1e-6, "track": "t", "count": 3,
}  # fmt: skip


def machine_with(*bodies: dict[str, Any]) -> Machine:
    ring = {"kind": "rotor", "name": "ring", "mass": 2.0, "unbalance": 1e-3, "inertia": 0.02}
    drive = {"kind": "linear", "on": "ring", "slope": 0.01, "no_load_speed": 100.0}
    return machine_from({"carrier": {"stiffness": 1e4}, "bodies": [ring, *bodies], "drive": drive})


def shares_of_quarters(angles: np.ndarray) -> np.ndarray:
    """Return the share of angles in each quarter of a turn."""
    return np.histogram(np.mod(angles, TURN), bins=4, range=(0, TURN))[0] / angles.size


@pytest.mark.parametrize("bodies", [[PENDULUM | {"name": "p1"}, PENDULUM | {"name": "p2"}], [BALL]], ids=["pendulums", "balls"])
def test_runs_of_a_balancer_start_anywhere(bodies: list[dict[str, Any]]) -> None:
    """Each body by itself: those that pass each other, and those on a track."""
    for at in phases(machine_with(*bodies), 256, [3]):
        assert shares_of_quarters(at) == pytest.approx(0.25, abs=0.06)


def test_bodies_of_a_file_that_stand_at_random_stand_anywhere() -> None:
    """Over a hundred seeds."""
    starts = []
    for seed in range(100):
        machine = machine_with(BALL | {"start": "random", "seed": seed})
        starts.append([angle for name, angle in angles_in(machine, initial_state(machine, {})).items() if name != "ring"])
    for at in np.array(starts).T:
        assert shares_of_quarters(at) == pytest.approx(0.25, abs=0.15)
