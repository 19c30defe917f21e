"""Machines from part objects: the same as from a file, refused with the same sentences, and shown."""

from __future__ import annotations

import doctest
import pickle
import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import refused, rejected

import wucht
from wucht import kinds, parts
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.machines import machine as machine_module

CARRIER: dict[str, Any] = {"mass": "1 kg", "stiffness": "1e5 N/m", "damping": "200 N s/m"}
DRUM: dict[str, Any] = {"name": "drum", "mass": "9 kg", "eccentricity": "1 mm", "inertia": "0.03 kg m^2"}
P1: dict[str, Any] = {"name": "p1", "about": "drum", "mass": "125 g", "length": "104 mm", "damping": "0.17 N m s"}
MOTOR: dict[str, Any] = {"slope": "0.04 N m s", "no_load_speed": "200 rad/s"}


def same(first: wucht.Machine, second: wucht.Machine) -> bool:
    """Whether two machines have equal systems, numbers and warnings."""
    assert isinstance(first, wucht.Machine)
    assert isinstance(second, wucht.Machine)
    assert first.system == second.system
    assert dict(first.parameters) == dict(second.parameters)
    assert (first.warnings, first.schedules, first.tracks) == (second.warnings, second.schedules, second.tracks)
    assert (first.start_angles, first.start_positions) == (second.start_angles, second.start_positions)
    return first.title == second.title


# As somebody writes it in Python, beside the file.


# What is wrong is the same sentence; the place is the part's path, or its table.

Refused = tuple[Callable[[], object], dict[str, Any], str]


def file(**changes: Any) -> dict[str, Any]:
    """The table of the machine below, changed."""
    bodies = [{"kind": "rotor", **DRUM}, {"kind": "pendulum", **P1}]
    return {"carrier": CARRIER, "bodies": bodies, "drive": {"kind": "linear", **MOTOR}} | changes


def made(*bodies: Any, carrier: Any = None, drives: Any = None, **others: Any) -> wucht.Machine:
    """A machine in Python, with two bodies if none is given."""
    drives = [parts.LinearDrive(**MOTOR)] if drives is None else drives
    every_body = list(bodies) or [parts.Rotor(**DRUM), parts.Pendulum(**P1)]
    return wucht.Machine(carrier or parts.Carrier(**CARRIER), every_body, drives, **others)


ROTOR2 = DRUM | {"name": "two"}
LINEAR = {"kind": "linear", **MOTOR}


def bodies(*tables: dict[str, Any]) -> dict[str, Any]:
    """The table with these bodies: rotors, and pendulums about something."""
    return file(bodies=[{"kind": "pendulum" if "about" in b else "rotor", **b} for b in tables])


REFUSED: dict[str, Refused] = {
    "inertia": (
        lambda: parts.Pendulum(**P1, inertia=1e-9), bodies(DRUM, P1 | {"inertia": 1e-9}), "pendulum.inertia",
    ),
    "circle": (
        lambda: made(parts.Rotor(**DRUM), parts.Pendulum(**P1 | {"about": "p1"})), bodies(DRUM, P1 | {"about": "p1"}),
        "p1.about",
    ),
    "on what of several": (
        lambda: made(parts.Rotor(**DRUM), parts.Rotor(**ROTOR2),
                     drives=[parts.LinearDrive(**MOTOR), parts.LinearDrive(on="two", **MOTOR)]),
        {k: v for k, v in bodies(DRUM, ROTOR2).items() if k != "drive"} | {"drives": [LINEAR, LINEAR | {"on": "two"}]},
        "drives[0].on",
    ),
    "scheduled": (
        lambda: made(schedules=[{"parameter": "drum.mass", "points": [[0, -1]]}]),
        file(schedules=[{"parameter": "drum.mass", "points": [[0, -1]]}]), "schedules[0].points (t = 0)",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("in_python", "in_file", "place"), REFUSED.values(), ids=REFUSED.keys())
def test_a_refusal_is_the_same_sentence(in_python: Callable[[], object], in_file: dict[str, Any], place: str) -> None:
    with pytest.raises(InputError) as of_python:
        in_python()
    with pytest.raises(InputError) as of_file:
        machine_from(in_file)
    assert of_python.value.explanation == of_file.value.explanation
    assert of_python.value.value == of_file.value.value
    assert of_python.value.location == place
    assert of_file.value.location.startswith("machine.")


@given(mass=st.floats(-1, 1), length=st.floats(-1, 1), inertia=st.floats(-1, 1))
@settings(max_examples=50, deadline=None)
def test_a_part_is_the_same_or_refused_alike(mass: float, length: float, inertia: float) -> None:
    numbers = P1 | {"mass": mass, "length": length, "inertia": inertia}
    outcomes = []
    for build in (lambda: made(parts.Rotor(**DRUM), parts.Pendulum(**numbers)), lambda: machine_from(bodies(DRUM, numbers))):
        try:
            outcomes.append(build().values)
        except InputError as error:
            outcomes.append((error.location.rpartition(".")[2], error.value, error.explanation))
    assert outcomes[0] == outcomes[1]


@pytest.mark.parametrize(
    ("given", "where"),
    [
        (lambda: wucht.Machine(parts.Rotor(**DRUM)), "carrier"),
        (lambda: made(parts.LinearDrive(**MOTOR)), "bodies[0]"),
        (lambda: made(drives=parts.LinearDrive(**MOTOR)), "drives"),
    ],
)
def test_what_is_no_part_of_that_kind_is_refused(given: Callable[[], object], where: str) -> None:
    with pytest.raises(InputError) as error:
        given()
    assert error.value.location == where


# The machine itself.


def test_a_changed_machine_derives_anew_and_keeps_the_first() -> None:
    machine = made()
    before = machine.values
    bare = machine.with_fields(parameters={}, title="bare")
    assert (bare.values, bare.title) == ({}, "bare")
    assert machine.values is before
    with refused("titel", "title", "with_values"):
        machine.with_fields(titel="x")
    with pytest.raises(AttributeError):
        machine.title = "x"  # type: ignore[misc]
    assert same(pickle.loads(pickle.dumps(machine)), machine)


def test_its_example_is_true() -> None:
    assert doctest.testmod(machine_module).failed == 0
    assert doctest.testmod(sys.modules["wucht.machines.parts"]).failed == 0


# The names in Python, and where parts come from.


def test_a_package_that_cannot_be_loaded_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kinds, "entry_points", lambda group: [EntryPoint("broken", "no_such_parts", group)])
    kinds._load.cache_clear()  # entry points are read once: here again, before and after
    try:
        with rejected("not-loaded", "'broken'", "no_such_parts", "No module named"):
            parts.loads()
    finally:
        kinds._load.cache_clear()


def test_a_machine_is_shown_as_a_table_whatever_its_title() -> None:
    html = made(title="Drum <1>")._repr_html_()
    assert "Drum &lt;1&gt;" in html and "<td>p1.length</td><td>0.104 m</td><td>length</td>" in html
    with pytest.raises(AttributeError, match="there is no part 'Rotr'; did you mean 'Rotor'"):
        parts.Rotr  # noqa: B018
