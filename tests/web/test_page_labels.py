"""How a page names what it shows: groups, controls and panels of curves."""

from __future__ import annotations

import pytest

from wucht import Machine, load_machine
from wucht.files.catalogue import load_document, names
from wucht.web.sliders import parameter_groups


def groups_of(machine: Machine) -> dict[str, list[str]]:
    """The names of the controls by the titles of their groups."""
    groups = parameter_groups(machine, list(machine.parameters))
    result = {g["title"]: [c["name"] for c in g["controls"]] for g in groups}
    assert len(result) == len(groups)
    return result


@pytest.mark.parametrize("every", [9, pytest.param(1, marks=pytest.mark.slow)])
def test_no_two_controls_of_a_group_have_one_name(every: int) -> None:
    for name in names()[::every]:
        if "machine" in load_document(name)[0]:
            for title, controls in groups_of(load_machine(name)).items():
                assert len(set(controls)) == len(controls), (name, title)


@pytest.mark.parametrize(
    ("name", "title"),
    [("practice/laundry-drum", "balls b1 to b6 (identical)"), ("sperling-rollers/table-1", "ball r2")],
)
def test_balls_are_balls_and_identical_bodies_have_one_group(name: str, title: str) -> None:
    assert title in groups_of(load_machine(name))
