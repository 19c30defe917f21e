"""Cam files for the tests of the study: an eccentric circle, and a dwell with a return by five harmonics."""

from __future__ import annotations

import cmath
from pathlib import Path
from typing import Any

import numpy as np

from wucht import CamDrive
from wucht.cams.drive import cam_drive_from

R, E, ROLLER, PIVOT, ARM = 0.050, 0.012, 0.010, 0.110, 0.090
ZERO = np.radians(-143.08681668)  # of the lever at cam angle 0
FOLLOWER = {"kind": "oscillating-roller", "pivot": PIVOT, "arm": ARM, "roller_radius": ROLLER, "angle": "-143 deg"}
FIVE = {
    "kind": "harmonic", "harmonics": 5, "objective": "flattest-dwell",
    "restrictions": [
        {"of": "position", "at": "180 deg", "equals": "24 deg"}, {"on": ["-120 deg", "120 deg"], "equals": "0 deg"},
    ],
}  # fmt: skip
MODIFIED_SINE = {
    "kind": "modified-sine", "stroke": "12 mm", "rise": ["20 deg", "140 deg"], "return": ["160 deg", "290 deg"]
}  # fmt: skip
FLAT = {"kind": "flat-faced", "distance": "40 mm"}
ROD = {"kind": "translating-roller", "distance": "60 mm", "roller_radius": "12 mm", "offset": "5 mm"}
FOUR_BAR = {"kind": "four-bar", "ground": 0.3, "input": 0.1, "coupler": 0.29, "output": 0.12, "angle": "70 deg"}
SMOOTH = {"kind": "harmonic", "coefficients": {"mean": "6 deg", "cosine": ["-6 deg", "0.7 deg"]}}
COUNTER = {"arm": "90 mm", "roller_radius": "10 mm", "angle": "120 deg"}


def lever_on_circle(phi: float) -> float:
    """The angle of the lever whose roller runs on a circle of radius R + r, its centre E from the cam's: a triangle."""
    centre = E * cmath.exp(1j * phi)
    to_pivot = centre - PIVOT
    reach = R + ROLLER
    corner = np.arccos((ARM**2 + abs(to_pivot) ** 2 - reach**2) / (2 * ARM * abs(to_pivot)))
    return float(np.angle(to_pivot) % (2 * np.pi) + corner - 2 * np.pi)


def eccentric(points: int = 180) -> dict[str, Any]:
    """The tables of a lever on an eccentric circle, its law by points."""
    phi = np.linspace(0, 2 * np.pi, points + 1)
    motion = [lever_on_circle(float(x)) - ZERO for x in phi]
    motion[-1] = motion[0]
    law = {"kind": "table", "points": np.column_stack([phi, motion]).tolist()}
    return {"law": law, "follower": FOLLOWER | {"angle": float(ZERO)}}


def drive(law: dict[str, Any], follower: dict[str, Any], **tables: Any) -> CamDrive:
    """A drive by its tables."""
    return cam_drive_from({"law": law, "follower": follower, **tables}, "A cam", Path())
