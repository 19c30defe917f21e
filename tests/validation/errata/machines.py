"""Machines in SI units whose structure alone matters: their parameters are kept as symbols."""

from __future__ import annotations

from typing import Any

from wucht.files.building import machine_from
from wucht.machines.machine import Machine

DRIVE = {"on": "drum", "kind": "linear", "slope": 0.0195, "no_load_speed": 200.0}
HELD = {"on": "drum", "kind": "constant-speed", "speed": 80.0}
DRUM = {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 9.75e-4}


def si_rotor(directions: str) -> Machine:
    """A rotor with a linear drive."""
    return machine_from(
        {"carrier": {"directions": directions, "stiffness": 1e5, "damping": 200.0}, "bodies": [DRUM], "drive": DRIVE}
    )


def with_rollers(drive: dict[str, Any]) -> Machine:
    """A drum with two rollers on a support whose directions differ."""
    roller = {"kind": "roller", "about": "drum", "mass": 1e-3, "radius": 0.01, "damping": 5e-5}
    drum = {"kind": "rotor", "name": "drum", "mass": 1.0, "unbalance": 1e-4, "inertia": 5e-3}
    return machine_from(
        {
            "carrier": {"directions": "xy", "stiffness": [4e3, 1.6e4], "damping": [0.3, 0.6]},
            "bodies": [drum, roller | {"name": "r1", "track_radius": 0.13}, roller | {"name": "r2", "track_radius": 0.09}],
            "drive": drive,
        }
    )


def with_balls(directions: str) -> Machine:
    """A drum at a given speed with two balls, whose inertia is a parameter."""
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.08, "length": 0.1, "inertia": 1e-3, "damping": 0.05}
    drum = {"kind": "rotor", "name": "drum", "mass": 0.84, "unbalance": 0.01, "inertia": 1e-3}
    return machine_from(
        {
            "carrier": {"directions": directions, "stiffness": 40.0, "damping": 0.4},
            "bodies": [drum, ball | {"name": "b1"}, ball | {"name": "b2"}],
            "drive": HELD,
        }
    )


def disc_with_sliders() -> Machine:
    """A disc on a fixed axis with two sliders opposite each other, in the field of gravity."""
    slider = {"kind": "slider", "about": "disc", "radius": 0.1, "mass": 1.0, "stiffness": 2500.0, "damping": 2.0}
    disc = {"kind": "rotor", "name": "disc", "mass": 1.0, "unbalance": 0.0, "inertia": 0.02}
    return machine_from(
        {
            "carrier": {"directions": "fixed", "gravity": 9.81},
            "bodies": [disc, slider | {"name": "s1", "angle": 0.0}, slider | {"name": "s2", "angle": 3.141592653589793}],
        }
    )
