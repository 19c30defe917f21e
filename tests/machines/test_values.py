"""Other parameter values: refused where the parts do not allow them, by the sentence that a file gets."""

import math

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht.files.building import machine_from
from wucht.machines.machine import Machine

DRUM = {
    "carrier": {"mass": 1.0, "stiffness": [100.0, 200.0], "damping": 1.0},
    "bodies": [{"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.1, "inertia": 0.05}],
    "drive": {"kind": "linear", "slope": 0.1, "no_load_speed": 20.0},
}


def drum() -> Machine:
    return machine_from(DRUM)


@pytest.mark.parametrize(
    ("values", "refusal"),
    [
        ({"drum.mas": 1.0}, refused("drum.mas", "drum.mass", given=1.0)),
        ({"drum.mass": -1.0}, refused("drum.mass", "0 kg", given=-1.0, code="limits")),
        ({"drum.mass": math.nan}, refused("drum.mass", given=float("nan"), code="not-finite")),
        ({"drum.inertia": 0.01}, refused("drum.inertia", "2 = 0.02", given=0.01)),
        ({"drum.eccentricity": 1.0}, refused("drum.eccentricity", "drum.inertia", "2 = 2", given=1.0)),
    ],
)
def test_what_the_parts_do_not_allow_is_refused(values: dict[str, float], refusal: Refusal) -> None:
    with refusal:
        drum().with_values(values)


MOUNTS = [{"at": [x, 0.0], "stiffness": [1e4, 2e4], "damping": [1.0, 2.0]} for x in (-0.3, 0.4, 0.6)]
SCREEN = {
    "carrier": {"directions": "xyr", "mass": 30.0, "inertia": 3.0, "mounts": MOUNTS},
    "bodies": [{"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.05, "position": [0.1, 0.2]}],
}


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_value_of_a_table_of_a_list_is_that_of_its_number(number: int) -> None:
    """Numbers count from 1: the others stay, and a value that is not allowed is located at its number."""
    machine = machine_from(SCREEN)
    path = f"carrier.mounts.{number}.stiffness.y"
    changed = machine.with_values({path: 5e4})
    assert {p for p, v in changed.values.items() if v != machine.values[p]} == {path}
    stiffness = machine.matrices[2], changed.matrices[2]
    place = (-0.3, 0.4, 0.6)[number - 1]
    assert stiffness[1] - stiffness[0] == pytest.approx(3e4 * np.outer([0, 1, place], [0, 1, place]), abs=1e-9)
    with refused(path, given=-1.0, code="limits"):
        machine.with_values({path: -1.0})
