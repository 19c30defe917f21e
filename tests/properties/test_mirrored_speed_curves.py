"""A machine whose rotor turns the other way has the same speed curve, but for the sign of speeds."""

from __future__ import annotations

from typing import Any

import pytest

from wucht import SpeedCurve, run
from wucht.files.building import machine_from

DISC = {"kind": "rotor", "name": "disc", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03, "bearing_damping": 1e-4}


def states(sense: int) -> list[dict[str, Any]]:
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e5, "damping": 200.0, "gravity": 0.0},
        "bodies": [DISC],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": sense * 200.0},
    })  # fmt: skip
    low, high = sorted((sense * 100.0, sense * 300.0))
    result = run(SpeedCurve(along="drive.no_load_speed", range=(low, high), points=1), machine)
    found: list[dict[str, Any]] = result.wucht.summary["states"]
    return found


def test_disturbances_decay_by_the_angle_as_fast_whichever_way_the_rotor_turns() -> None:
    """Of exponents over time and over the angle the real parts have one sign: that of growth."""
    forwards, backwards = states(1), states(-1)
    assert len(forwards) == len(backwards) > 0
    for one, mirrored in zip(forwards, backwards, strict=True):
        assert mirrored["speed"] == pytest.approx(-one["speed"], rel=1e-6) and mirrored["stable"] == one["stable"]
        for key in ("exponents", "exponents_phi"):
            assert [re for re, _ in mirrored[key]] == pytest.approx([re for re, _ in one[key]], rel=1e-6)
