"""``wucht list NAME``: the keys of a study or part."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Command = Callable[..., Any]
Refused = Callable[..., str]


def test_keys_with_units_defaults_and_limits(wucht: Command) -> None:
    lines = wucht("list", "pendulum").out.splitlines()
    assert lines[0] == '[[machine.bodies]] kind = "pendulum"'
    rows = {line.split()[0]: k for k, line in enumerate(lines) if line.startswith("  ") and line[2] != " "}
    assert lines[rows["mass"]].split() == ["mass", "number", "kg", "needed", ">", "0"]
    assert lines[rows["mass"] + 1].strip() == "mass of the body"
    assert lines[rows["damping"]].split() == ["damping", "number", "N", "m", "s", "0.0", ">=", "0"]
    assert wucht("list", "run-up").out.startswith('[study] kind = "run-up"')


def test_several_things_of_one_name(wucht: Command) -> None:
    said = wucht("list", "table").out
    assert [f"[{t}] kind" in said for t in ("machine.drive", "[machine.loads]", "law")] == [True] * 3


def test_as_json(wucht: Command) -> None:
    document = wucht("list", "rotor", "--json").document
    (table,) = document["tables"]
    mass = next(key for key in table["keys"] if key["name"] == "mass")
    assert (document["name"], mass["unit"], mass["needed"], mass["type"]) == ("rotor", "kg", True, "number")


def test_the_own_states_of_a_part(wucht: Command) -> None:
    rows = [line.split() for line in wucht("list", "friction-damper").out.splitlines()]
    assert ["lining", "m", "lining", "travel"] in rows
    (table,) = wucht("list", "inverter", "--json").document["tables"]
    assert [(x["name"], x["unit"]) for x in table["states"]] == [("integral", "N m")]
    assert "states" not in wucht("list", "rotor", "--json").document["tables"][0]


def test_bad_names(refused: Refused) -> None:
    refused("list", "rotar", says=("NAME", "did you mean 'rotor'?"))
    screens = "in the catalogue: practice/screen, practice/screen-loaded, practice/screen-unsynchronised"
    refused(
        "list", "screen", says=("NAME", "neither a study nor a part", screens, "`wucht new practice/screen` copies the first")
    )
    refused("list", "practice/fan-on-belt", says=("`wucht new practice/fan-on-belt` copies it",))
    refused("list", "--json", says=("--json", "only with the name"))


def test_the_catalogue_is_listed_with_its_titles(wucht: Command) -> None:
    lines = wucht("list").out.splitlines()
    (line,) = [line for line in lines if line.split()[:1] == ["practice/laundry-drum"]]
    assert line.endswith("  Washing machine: drum with laundry in one place and a ball balancing ring")
