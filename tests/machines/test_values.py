"""Other parameter values: refused where the parts do not allow them, by the sentence that a file gets."""

import math

import pytest
from tests.refusals import Refusal, refused

from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

DRUM = {
    "carrier": {"mass": 1.0, "stiffness": [100.0, 200.0], "damping": 1.0},
    "bodies": [{"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.1, "inertia": 0.05}],
    "drive": {"kind": "linear", "slope": 0.1, "no_load_speed": 20.0},
}


def drum() -> Machine:
    return machine_from(DRUM)


def test_values_are_changed_and_the_structure_stays() -> None:
    machine = drum()
    other = machine.with_values({"drum.mass": 3.0, "carrier.stiffness.y": 150.0})
    assert (other.values["drum.mass"], other.values["carrier.stiffness.y"]) == (3.0, 150.0)
    assert machine.values["drum.mass"] == 2.0
    assert other.system == machine.system


@pytest.mark.parametrize(
    ("values", "refusal"),
    [
        ({"drum.mas": 1.0}, refused("drum.mas", "drum.mass", given=1.0)),
        ({"drum.mass": -1.0}, refused("drum.mass", "0 kg", given=-1.0, code="limits")),
        ({"drum.mass": math.nan}, refused("drum.mass", given=float("nan"), code="not-finite")),
        ({"drum.mass": math.inf}, refused("drum.mass", given=float("inf"), code="not-finite")),
        ({"carrier.stiffness.y": -1.0}, refused("carrier.stiffness.y", given=-1.0)),
        ({"drum.inertia": 0.01}, refused("drum.inertia", "2 = 0.02", given=0.01)),
        ({"drum.eccentricity": 1.0}, refused("drum.eccentricity", "drum.inertia", "2 = 2", given=1.0)),
    ],
)
def test_what_the_parts_do_not_allow_is_refused(values: dict[str, float], refusal: Refusal) -> None:
    with refusal:
        drum().with_values(values)


def test_a_file_gets_the_same_sentence() -> None:
    bad = {**DRUM, "bodies": [DRUM["bodies"][0] | {"mass": -1.0}]}  # type: ignore[index,operator]
    with pytest.raises(InputError) as of_file:
        machine_from(bad)
    with pytest.raises(InputError) as of_values:
        drum().with_values({"drum.mass": -1.0})
    assert of_file.value.explanation == of_values.value.explanation


def test_values_are_checked_with_those_of_the_moment() -> None:
    heavy = drum().with_values({"drum.inertia": 5.0})
    assert heavy.with_values({"drum.eccentricity": 1.0}).values["drum.eccentricity"] == 1.0
    with refused("drum.eccentricity", given=2.0):
        heavy.with_values({"drum.eccentricity": 2.0})


def test_a_dimensionless_machine_refuses_too() -> None:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    assert machine.with_values({"u": 2.0}).values["u"] == 2.0
    with refused("u", given=-1.0, code="limits"):
        machine.with_values({"u": -1.0})


def test_values_known_to_be_allowed_need_no_check() -> None:
    assert drum().with_unchecked_values({"drum.inertia": 1e-300}).values["drum.inertia"] == 1e-300
