"""The rating of a rotor's bearing: what it may be, its parameters, and that it changes nothing in the machine's motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.files.building import machine_from

ROTOR: dict[str, Any] = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 2e-2, "inertia": 1.5e-2}
ROCKING = {"directions": "r", "inertia": 1.0, "rotation_stiffness": 900.0}


def document(bearing: Any, **more: Any) -> dict[str, Any]:
    carrier, rotor = {"mass": 2.0, "stiffness": 1e4, "damping": 30.0}, ROTOR | {"bearing": bearing}
    drive = {"kind": "linear", "slope": 0.1, "no_load_speed": 50.0}
    return {"carrier": carrier, "bodies": [rotor], "drive": drive, **more}


@pytest.mark.parametrize(
    ("bearing", "key", "code"),
    [
        ({}, ".C", "missing"), ({"C": "45 kg"}, ".C", "dimension"), ({"C": 0}, ".C", "limits"), ({"C": -1}, ".C", "limits"),
        ({"C": 1e3, "p": 0.99}, ".p", "limits"), ({"C": 1e3, "p": 10.01}, ".p", "limits"),
        ({"C": 1e3, "p": "9/3"}, ".p", "no-quantity"), ({"C": 1e3, "share": 0.0}, ".share", "limits"),
        ({"C": 1e3, "share": 1.01}, ".share", "limits"), ({"C": 1e3, "P": 3}, ".P", "unknown-key"), ("45 kN", "", "type"),
    ],
)  # fmt: skip
def test_what_is_no_bearing(bearing: Any, key: str, code: str) -> None:
    with refused(f"machine.bodies[0] (drum).bearing{key}", code=code):
        machine_from(document(bearing))


def test_where_no_bearing_can_be() -> None:
    couple = {"kind": "rotor", "name": "drum", "mass": 3.0, "couple_unbalance": 1e-3, "inertia": 1.5e-2, "bearing": {"C": 1e3}}
    with refused("machine.bodies[0] (drum).bearing", "a couple unbalance has no force in the plane"):
        machine_from({"carrier": ROCKING, "bodies": [couple]})
    points = [["0 s", "1 kN"], ["1 s", "2 kN"]]
    with refused("machine.schedules[0].parameter", "does not change over time", given="drum.bearing.C", code="rating"):
        machine_from(document({"C": 1e3}, schedules=[{"parameter": "drum.bearing.C", "points": points}]))


def test_the_limits_are_allowed() -> None:
    for table in ({"C": 1e-3, "p": 1, "share": 1}, {"C": "45 kN", "p": 10}, {"C": "45 kN", "p": "10/3", "share": 1e-3}):
        machine = machine_from(document(table))
    assert machine.values["drum.bearing.p"] == 10 / 3
    assert machine.parameters["drum.bearing.C"].unit == "N"


def test_a_rating_moves_nothing() -> None:
    motions = []
    for table in (None, {"C": 1e3}):
        machine = machine_from(document(table))
        motions.append(run_to_end(machine, {}, RunSettings(until=2.0)).machine_motion)
    assert np.array_equal(motions[0].states, motions[1].states)
