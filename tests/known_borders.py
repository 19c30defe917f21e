"""Machines whose borders are known: a rotor between two steady speeds by its averaged equations, and balls that overlap."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from wucht import CaptureProbability, run
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

MASS, STIFFNESS, DAMPING, UNBALANCE, FREE_SPEED = 10.0, 1e5, 60.0, 5e-3, 150.0
SLOWEST, FASTEST = 95.0, 115.0  # of the random speeds


@cache
def machine() -> Machine:
    body = {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": UNBALANCE, "inertia": 0.02}
    return machine_from({
        "carrier": {"mass": MASS - 5.0, "directions": "xy", "stiffness": STIFFNESS, "damping": DAMPING}, "bodies": [body],
        "drive": {"kind": "linear", "on": "drum", "slope": 0.01, "no_load_speed": FREE_SPEED},
    })  # fmt: skip


def border(slope: float) -> float:
    """The unstable steady speed, where the drive's torque is just that of the vibration: from above it gets through."""

    def excess(speed: float) -> float:
        resonance = (STIFFNESS - MASS * speed**2) ** 2 + (DAMPING * speed) ** 2
        return slope * (FREE_SPEED - speed) - DAMPING * speed * (UNBALANCE * speed**2) ** 2 / resonance

    speeds = np.linspace(100.5, 110.0, 96)
    return next(brentq(excess, a, b) for a, b in pairwise(speeds) if excess(a) < 0 <= excess(b))


def share_above_border(slope: float) -> float:
    """Of the random speeds."""
    return (FASTEST - border(slope)) / (FASTEST - SLOWEST)


SPEED: dict[str, Any] = {"drum": {"speed": {"uniform": [SLOWEST, FASTEST]}}}
KEYS: dict[str, Any] = {
    "along": "drive.slope", "range": [0.005, 0.008], "points": 3, "random": SPEED, "model": "slow", "samples": 64,
    "until": 50.0,
}  # fmt: skip


def asked(**keys: Any) -> xr.Dataset:
    return run(CaptureProbability(**KEYS | keys), machine())


def rail(drive: dict[str, Any] | None = None) -> Machine:
    """Two balls in one track, which overlap where they are nearer than 60 degrees."""
    ball = {"kind": "roller", "about": "drum", "mass": 0.1, "track_radius": 0.06, "radius": 0.02, "shape_factor": 0.4}
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [drum, *(ball | {"name": name, "damping": 0.01, "track": "ring"} for name in ("b1", "b2"))],
        "drive": {"on": "drum"} | (drive or {"kind": "linear", "slope": 0.01, "no_load_speed": 30.0}),
    })  # fmt: skip
