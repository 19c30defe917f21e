"""Forces of rotors on bearings: a virtual displacement gives what the System states where the carrier moves, and m e w^2."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht.analysis.bearing_forces import BearingForces, _force_on_guide, bearing_force
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.files.building import machine_from
from wucht.numerics.flow.program import Evaluator

ROTOR: dict[str, Any] = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 2e-2, "inertia": 1.5e-2}
TRACK = {"track": "t", "diameter": 0.01}
BODIES = (
    {"kind": "pendulum", "name": "p1", "about": "drum", "mass": 0.4, "length": 0.08, "damping": 0.02, **TRACK},
    {"kind": "pendulum", "name": "p2", "about": "drum", "mass": 0.4, "length": 0.08, "damping": 0.02, **TRACK},
    {
        "kind": "pendulum", "name": "s1", "about": "drum", "mass": 0.3, "length": 0.05, "damping": 0.02,
        "suspension": [0.04, 0.01],
    },
    {
        "kind": "roller", "name": "ball", "about": "drum", "mass": 0.2, "track_radius": 0.1, "radius": 0.01,
        "shape_factor": 0.4, "damping": 0.01, "release": {"time": 0.4},
    },
    {
        "kind": "slider", "name": "s2", "about": "drum", "mass": 0.3, "angle": 1.0, "radius": 0.06, "stiffness": 5e3,
        "damping": 4.0,
    },
)  # fmt: skip
MOTOR = {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}


def motion_of(machine: Any, until: float = 0.8, **start: Any) -> Any:
    return run_to_end(machine, start, RunSettings(until=until)).machine_motion


FIXED_IN_R = {"stiffness": 1e4, "damping": 60.0, "mass": 2.0, "gravity": 9.81}
PLANAR = FIXED_IN_R | {"directions": "xyr", "inertia": 1.0, "rotation_stiffness": 500.0}


@pytest.mark.parametrize(
    ("carrier", "bodies"), [(FIXED_IN_R, BODIES[:1]), pytest.param(PLANAR, BODIES, marks=pytest.mark.slow)]
)
def test_a_virtual_displacement_gives_the_force_on_a_carrier_that_moves(carrier: dict[str, Any], bodies: Any) -> None:
    """Of a rotor with bodies of every kind about it, on a track, one still locked, beside a second rotor."""
    place = {"position": [0.2, 0.1]} if carrier is PLANAR else {}
    second = {"kind": "rotor", "name": "other", "mass": 2.0, "unbalance": 1e-2, "inertia": 1e-2}
    drives = [{**MOTOR, "on": "drum", "stator": "carrier"}, {**MOTOR, "on": "other"}]
    machine = machine_from({"carrier": carrier, "bodies": [ROTOR | place, second, *bodies], "drives": drives})
    start = {"p1": 0.5, "p2": 2.0} if carrier is PLANAR else {"p1": 0.5}
    motion = motion_of(machine, **start)
    for rotor in ("drum", "other"):
        expressions = [e for d in "xy" for e in (bearing_force(machine, rotor, d), _force_on_guide(machine, rotor, d))]
        rows = Evaluator.of(machine.system, expressions, ["x", "x0", "y", "y0"])
        x, virtual_x, y, virtual_y = rows.array(motion.time, motion.states, motion.final_parameter_values)
        size = np.hypot(x, y).max()
        assert size > 50
        assert np.abs(virtual_x - x).max() < 1e-9 * size and np.abs(virtual_y - y).max() < 1e-9 * size


@pytest.mark.parametrize("directions", ["fixed", "x", "y", "xy"])
def test_a_rotor_in_rigid_bearings(directions: str) -> None:
    """U w^2 round, and the weight; a carrier that hardly moves is rigid."""
    speed = 60.0
    still = {"directions": directions, "gravity": 9.81} | ({} if directions == "fixed" else {"mass": 1e9, "stiffness": 1e9})
    drive = {"kind": "constant-speed", "speed": speed}
    machine = machine_from({"carrier": still, "bodies": [ROTOR], "drive": drive})
    motion = motion_of(machine)
    forces, speeds = BearingForces.of(machine)(motion)
    angle = speed * motion.time
    expected = 0.02 * speed**2 * np.array([np.cos(angle), np.sin(angle)]) - np.array([[0.0], [3.0 * 9.81]])
    assert np.abs(forces["drum"] - expected).max() < 1e-4
    assert speeds["drum"] == pytest.approx(np.full(len(angle), speed))


def test_a_bearing_turns_against_its_carrier() -> None:
    """A rotor at rest in a carrier that rocks: its bearing turns to and fro."""
    rocking = {"directions": "r", "inertia": 1.0, "rotation_stiffness": 900.0}
    bodies = [ROTOR | {"unbalance": 0.0, "position": [0.2, 0.0]}]
    machine = machine_from({"carrier": rocking, "bodies": bodies, "drive": {"kind": "constant-speed", "speed": 40.0}})
    motion = motion_of(machine, carrier={"r": 0.1})
    forces, speeds = BearingForces.of(machine)(motion)
    rate = motion.states[list(machine.state_names).index("carrier.vr")]
    assert np.ptp(rate) > 1
    assert speeds["drum"] == pytest.approx(40.0 - rate)
    # Its axis is (-b chi, a chi) from where it is at rest: the linear motion of the frame.
    turn = motion.states[list(machine.state_names).index("carrier.r")]
    acceleration = -900.0 / (1.0 + 3.0 * 0.2**2) * turn
    assert forces["drum"][1] == pytest.approx(-3.0 * 0.2 * acceleration, rel=1e-9, abs=1e-9)
    assert np.abs(forces["drum"][0]).max() < 1e-12
