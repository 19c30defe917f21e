"""How a page names what it shows: groups, controls and panels of curves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht import Machine, load_machine
from wucht.dynamics.live_machine import machine_description
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.files.building import machine_from
from wucht.files.catalogue import load_document, names
from wucht.studies.study_file import read_study
from wucht.web.cards import card_of
from wucht.web.curve_panels import panels
from wucht.web.sliders import parameter_groups
from wucht.web.start_controls import start_groups


def groups_of(machine: Machine) -> dict[str, list[str]]:
    """The names of the controls by the titles of their groups."""
    groups = parameter_groups(machine, list(machine.parameters))
    result = {g["title"]: [c["name"] for c in g["controls"]] for g in groups}
    assert len(result) == len(groups)
    return result


def panels_of(name: str) -> list[dict[str, Any]]:
    question = read_study(name)
    case = RunUpCase.of(question.subject, question.spec.start, question.spec.settings)  # type: ignore[attr-defined]
    return panels(case.machine, machine_description(case.machine, case.models[0].initial)["outputs"])


@pytest.mark.parametrize("name", [n for n in names() if "machine" in load_document(n)[0]])
def test_no_two_controls_of_a_group_have_one_name(name: str) -> None:
    for title, controls in groups_of(load_machine(name)).items():
        assert len(set(controls)) == len(controls), title


def test_mounts_are_numbered_and_positions_have_their_direction() -> None:
    groups = groups_of(load_machine("practice/screen"))
    assert [c for c in groups["carrier"] if c.startswith("mount 2")] == [
        f"mount 2: {c}"
        for c in ("x position", "y position", "stiffness in x", "stiffness in y", "damping in x", "damping in y")
    ]
    assert {"x position", "y position"} < set(groups["rotor e1"])
    assert list(groups)[:2] == ["motor of e1", "motor of e2"]


@pytest.mark.parametrize(
    ("name", "title"),
    [
        ("practice/laundry-drum", "balls b1 to b6 (identical)"), ("drozdetskaya-2020/r1", "pendulums p1 and p2 (identical)"),
        ("sperling-rollers/table-1", "ball r2"),
    ],
)  # fmt: skip
def test_balls_are_balls_and_identical_bodies_have_one_group(name: str, title: str) -> None:
    assert title in groups_of(load_machine(name))


def test_a_body_that_differs_interrupts_the_names_of_the_others() -> None:
    machine = load_machine("practice/laundry-drum", {"b3.mass": "0.2 kg"})
    titles = list(groups_of(machine))
    assert "balls b1, b2, b4, b5 and b6 (identical)" in titles and "ball b3" in titles


@pytest.mark.parametrize(("unbalance", "rotation"), [("eccentricity", "rotation angle"), ("couple_unbalance", "tilt")])
def test_a_carrier_that_turns_has_an_angle_and_an_angular_velocity(unbalance: str, rotation: str) -> None:
    """In the plane of the drawing, or about an axis in it."""
    body = {"kind": "rotor", "name": "drum", "mass": 2.0, "inertia": 0.02, unbalance: 1e-3}
    carrier = {"directions": "r", "inertia": 0.5, "rotation_stiffness": 1e3}
    machine = machine_from(
        {"carrier": carrier, "bodies": [body if unbalance != "eccentricity" else body | {"position": [0.1, 0.0]}]}
    )
    *_, group = start_groups(machine, np.zeros(len(machine.state_names)))
    assert [c["name"] for c in group["controls"]] == [rotation, "angular velocity"]


def test_panels_of_curves_and_their_order() -> None:
    one, two = panels_of("drozdetskaya-2020/r1"), panels_of("practice/screen")
    assert [p["title"] for p in one] == [
        "speed", "displacement of the axis", "phases on the rotor", "residual unbalance", "motor power",
    ]  # fmt: skip
    assert [c["name"] for p in one for c in p["curves"] if "output" in c] == ["drum", "amplitude", "drum", "power"]
    assert [p["title"] for p in two][2] == "phases of the rotors relative to e1"


def test_a_card_names_nothing_that_its_machine_cannot_change() -> None:
    """The unbalance of the tumbling laundry follows a schedule."""
    name = "practice/laundry-drum-tumbling"
    card, controls = card_of(name), groups_of(load_machine(name))["rotor drum"]
    assert card is not None and "40 s" in card.task and "Drag" not in card.task and "unbalance" not in controls
