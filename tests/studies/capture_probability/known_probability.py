"""A rotor between two steady speeds: which one it comes to from a random speed is known by its averaged equations."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.studies.capture_probability.study import CaptureProbability
from wucht.studies.runner import run

MASS, STIFFNESS, DAMPING, UNBALANCE, FREE_SPEED = 10.0, 1e5, 60.0, 5e-3, 150.0
SLOWEST, FASTEST = 95.0, 115.0  # of the random speeds


def machine() -> Machine:
    body = {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": UNBALANCE, "inertia": 0.02}
    return machine_from({
        "carrier": {"mass": MASS - 5.0, "directions": "xy", "stiffness": STIFFNESS, "damping": DAMPING}, "bodies": [body],
        "drive": {"kind": "linear", "on": "drum", "slope": 0.01, "no_load_speed": FREE_SPEED},
    })  # fmt: skip


def share_above_border(slope: float) -> float:
    """Of the random speeds those above the unstable steady speed, where the drive's torque is just that of the vibration."""

    def excess(speed: float) -> float:
        resonance = (STIFFNESS - MASS * speed**2) ** 2 + (DAMPING * speed) ** 2
        return slope * (FREE_SPEED - speed) - DAMPING * speed * (UNBALANCE * speed**2) ** 2 / resonance

    speeds = np.linspace(100.5, 110.0, 96)
    border = next(brentq(excess, a, b) for a, b in pairwise(speeds) if excess(a) < 0 <= excess(b))
    return (FASTEST - border) / (FASTEST - SLOWEST)


SPEED: dict[str, Any] = {"drum": {"speed": {"uniform": [SLOWEST, FASTEST]}}}
KEYS: dict[str, Any] = {
    "along": "drive.slope", "range": [0.005, 0.008], "points": 3, "random": SPEED, "model": "slow", "samples": 64,
    "until": 50.0,
}  # fmt: skip


def asked(**keys: Any) -> xr.Dataset:
    return run(CaptureProbability(**KEYS | keys), machine())
