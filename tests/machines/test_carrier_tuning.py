"""Carriers by natural frequency and damping ratio, against the eigenvalues of their matrices; and where that says nothing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht.files.building import machine_from
from wucht.machines.machine import Machine

PLANAR = {"directions": "xyr", "mass": 40.0, "inertia": 3.0}
ROCKING = {"directions": "r", "inertia": 3.0}
PLACES = ({"at": (-0.5, 0.0)}, {"at": (0.5, 0.0)})


def with_carrier(carrier: dict[str, Any], place: tuple[float, float] = (0.3, -0.1), **more: Any) -> Machine:
    """Two rotors on opposite sides of the centre of mass: they do not couple translation and rotation. One has a pendulum."""
    rotors = [
        {"kind": "rotor", "name": name, "mass": 4.0 - 0.5 * (name == "e"), "unbalance": 0.06, "inertia": 0.01, "position": at}
        for name, at in (("e", place), ("f", (-place[0], -place[1])))
    ]
    ball = {"kind": "pendulum", "name": "p", "about": "e", "mass": 0.5, "length": 0.05, "damping": 0.01}
    drives = [{"kind": "linear", "on": r["name"], "slope": 0.05, "no_load_speed": 100.0} for r in rotors]
    return machine_from({"carrier": carrier, "bodies": [*rotors, ball], "drives": drives} | more)


def poles(machine: Machine) -> dict[float, float]:
    """Natural frequencies in Hz, and their damping ratios."""
    mass, damping, stiffness = machine.matrices
    n = len(mass)
    found = np.linalg.eigvals(
        np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    )
    return {round(abs(p) / (2 * math.pi), 9): float(-p.real / abs(p)) for p in found}


def test_a_planar_carrier_on_springs_at_its_centre_of_mass() -> None:
    carrier = PLANAR | {"frequency": ["5 Hz", "6 Hz"], "damping_ratio": [0.1, 0.05]}
    machine = with_carrier(carrier | {"rotation_frequency": "7 Hz", "rotation_damping_ratio": 0.2})
    assert poles(machine) == pytest.approx({5.0: 0.1, 6.0: 0.05, 7.0: 0.2})
    assert machine.matrices[0][2, 2] == pytest.approx(3 + 2 * 4 * (0.3**2 + 0.1**2))
    assert machine.notes[0].startswith("carrier: stiffness 47374.1 and 68218.7 N/m, damping ")
    assert "from frequency or damping ratio with 48 kg; rotation_stiffness " in machine.notes[0]


def test_mounts_share_a_frequency_alike() -> None:
    machine = with_carrier(PLANAR | {"frequency": ["5 Hz", "6 Hz"], "damping_ratio": 0.1, "mounts": PLACES})
    found = poles(machine)
    assert found[5.0] == pytest.approx(0.1)
    assert found[6.0] == pytest.approx(0.1)
    assert machine.values["carrier.mounts.1.stiffness.x"] == machine.values["carrier.mounts.2.stiffness.x"]
    across = 2 * machine.values["carrier.mounts.1.stiffness.y"] * 0.5**2 / machine.matrices[0][2, 2]
    assert math.sqrt(across) / (2 * math.pi) in [pytest.approx(f, rel=1e-8) for f in found]


def test_a_carrier_that_only_turns() -> None:
    """Rotors on it carry their mass around."""
    machine = with_carrier(ROCKING | {"rotation_frequency": "7 Hz", "rotation_damping_ratio": 0.2})
    assert poles(machine) == pytest.approx({7.0: 0.2})
    assert machine.matrices[0][0, 0] == pytest.approx(3 + 2 * 4 * (0.3**2 + 0.1**2))


@pytest.mark.parametrize(
    ("carrier", "refusal"),
    [
        (PLANAR | {"frequency": 5.0, "stiffness": 1.0}, refused("machine.carrier.frequency", given=5.0, code="either-or")),
        (PLANAR | {"mounts": [{"at": (0, 0)}]}, refused("machine.carrier.mounts", "mounts[0]", given=[{"at": (0, 0)}])),
        (PLANAR | {"frequency": 5.0, "damping": 3.0, "mounts": PLACES}, refused("machine.carrier.damping", given=3.0)),
        (
            PLANAR | {"stiffness": [0.0, 5.0], "damping_ratio": 0.1},
            refused("machine.carrier.damping_ratio", code="no-stiffness"),
        ),
        (PLANAR | {"frequency": -5.0}, refused("machine.carrier.frequency", given=-5.0, code="limits")),
    ],
)
def test_what_is_refused(carrier: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        with_carrier(carrier)
