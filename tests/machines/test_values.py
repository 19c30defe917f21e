"""Other parameter values: refused where the parts do not allow them, by the sentence that a file gets."""

import math

import numpy as np
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


@pytest.mark.parametrize("component", ["x", "y"])
def test_a_component_of_a_pair_is_that_of_its_letter(component: str) -> None:
    machine = drum()
    changed = machine.with_values({f"carrier.stiffness.{component}": 400.0})
    assert np.diag(changed.matrices[2]).tolist() == ([400.0, 200.0] if component == "x" else [100.0, 400.0])


def test_a_schedule_gives_the_values_at_the_start() -> None:
    schedule = {"parameter": "drum.mass", "points": [[0, 2.0], [2, 4.0]]}
    machine = machine_from(DRUM | {"schedules": [schedule]})
    assert machine.values["drum.mass"] == 2.0
    assert machine.at(1.0).values["drum.mass"] == pytest.approx(3.0)


def test_a_list_of_its_bodies_says_what_bears_each() -> None:
    ball = {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.1, "length": 0.1}
    rows = machine_from(DRUM | {"bodies": [*DRUM["bodies"], ball]})._repr_html_()  # type: ignore[misc]
    assert "<td>rotor drum</td><td></td><td>on the carrier</td>" in rows
    assert "<td>pendulum p</td><td></td><td>on drum</td>" in rows
    assert "<td>linear drive</td><td></td><td>on drum</td>" in rows
    assert "<td>drum.mass</td><td>2 kg</td>" in rows
