"""``wucht list NAME``: what a study, a part or a file of the catalogue is, on one screen."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from docs.site import gallery, gallery_pages, reference_pages

from wucht.cli.list_name import kinds
from wucht.files.catalogue import names
from wucht.studies.registry import studies
from wucht.studies.study_file import read_study

Command = Callable[..., Any]
Refused = Callable[..., str]


ALL = sorted({*names(), *studies(), *(name for of_kind in kinds().values() for name in of_kind)})


def test_keys_with_units_defaults_and_limits(wucht: Command) -> None:
    lines = wucht("list", "pendulum", "--all").out.splitlines()
    assert lines[0] == '[[machine.bodies]] kind = "pendulum"'
    rows = {line.split()[0]: k for k, line in enumerate(lines) if line.startswith("  ") and line[2] != " "}
    assert lines[rows["mass"]].split() == ["mass", "number", "kg", "needed", ">", "0"]
    assert lines[rows["mass"] + 1].strip() == "mass of the body"
    assert lines[rows["damping"]].split() == ["damping", "number", "N", "m", "s", "0.0", ">=", "0"]
    assert wucht("list", "run-up").out.startswith('[study] kind = "run-up"')


@pytest.mark.parametrize("name", ALL)
def test_every_name_is_explained_on_one_screen(wucht: Command, name: str) -> None:
    lines = wucht("list", name).out.splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 100
    assert any(line.startswith("page    ") for line in lines)


def test_keys_that_do_not_fit_are_named_and_counted(wucht: Command) -> None:
    lines = wucht("list", "induction").out.splitlines()
    every_key = wucht("list", "induction", "--json").document["tables"][0]["keys"]
    (more,) = [line for line in lines if line.startswith("  and ")]
    rows = [line.split()[0] for line in lines[lines.index(more) - int(more.split()[1]) :] if line.startswith("  ")]
    first = next(k for k, line in enumerate(lines) if line.split()[:2] == ["key", "default"])
    listed = [line.split()[0] for line in lines[first + 1 : lines.index(more)]]
    assert len(listed) + int(more.split()[1]) == len(every_key)
    assert not {"nameplate.power"} & set(listed[: listed.index("nameplate")])
    assert rows
    assert lines[-1] == "all     wucht list induction --all"


def test_needed_keys_come_first(wucht: Command) -> None:
    lines = wucht("list", "pendulum").out.splitlines()
    start = next(k for k, line in enumerate(lines) if line.split()[:1] == ["key"])
    assert [line.split()[:2] for line in lines[start + 1 : start + 5]] == [
        [key, "needed"] for key in ("name", "about", "mass", "length")
    ]


def test_a_machine_of_the_catalogue(wucht: Command, here: Path) -> None:
    said = wucht("list", "practice/grinder-4-balls").out
    lines = {line[:8].strip(): line[8:] for line in said.splitlines()}
    assert said.splitlines()[0] == "Angle grinder with a worn wheel and four balancing balls"
    assert lines["study"] == "run-up: Start the machine and follow its motion to the end."
    assert lines["parts"] == "carrier (xy); wheel (rotor); b1 to b4 (roller on wheel); drive (linear)"
    command = lines["copy"].split()
    assert wucht(*command[1:]).code == 0
    assert Path("my-grinder-4-balls.toml").is_file()
    document = wucht("list", "practice/grinder-4-balls", "--json").document
    assert document["run"] == lines["run"] == "wucht run practice/grinder-4-balls"
    assert document["move"] == lines["move"] == "wucht share practice/grinder-4-balls"
    for name in ("kaltofen-cam/dwell-and-return", "drozdetskaya-2020/figure-2.13", "sperling-vibration/table-1"):
        assert wucht("list", name, "--json").document["move"] == "", "a cam, equations, bodies with releases"
    assert wucht("list", "kaltofen-cam/dwell-and-return", "--json").document["parts"][0] == "law (harmonic)"
    assert wucht("list", "drozdetskaya-2020/figure-2.13", "--json").document["parts"] == ["equations of r, theta"]


def test_a_study_has_its_template(wucht: Command, here: Path) -> None:
    (copy,) = [line for line in wucht("list", "torque-balance").out.splitlines() if line.startswith("copy ")]
    assert wucht(*copy.split()[2:]).code == 0
    assert Path("my-torque-balance.toml").is_file()


def test_pages_are_those_of_the_documentation(wucht: Command) -> None:
    entries = [gallery.Entry("practice/screen", read_study("practice/screen"), {}, None, Path(), Path())]
    pages = {**reference_pages.pages(entries), **gallery_pages.pages(entries)}
    for name in (
        "roller",
        "xyr",
        "induction",
        "quadratic",
        "end-stop",
        "laval-rotor",
        "harmonic",
        "flat-faced",
        "four-bar",
        "sweep",
    ):
        for table in wucht("list", name, "--json").document["tables"]:
            assert table["page"].replace(".html", ".md") in pages
    assert wucht("list", "practice/screen", "--json").document["page"].replace(".html", ".md") in pages


def test_several_things_of_one_name(wucht: Command) -> None:
    said = wucht("list", "table").out
    assert [f"[{t}] kind" in said for t in ("machine.drive", "[machine.loads]", "law")] == [True] * 3
    assert said.count("wucht list table --all") == 1


def test_as_json(wucht: Command) -> None:
    document = wucht("list", "rotor", "--json").document
    (table,) = document["tables"]
    mass = next(key for key in table["keys"] if key["name"] == "mass")
    assert (document["name"], mass["unit"], mass["needed"], mass["type"]) == ("rotor", "kg", True, "number")


def test_the_own_states_of_a_part(wucht: Command) -> None:
    rows = [line.split() for line in wucht("list", "friction-damper", "--all").out.splitlines()]
    assert ["lining", "m", "lining", "travel"] in rows
    (table,) = wucht("list", "inverter", "--json").document["tables"]
    assert [(x["name"], x["unit"]) for x in table["states"]] == [("integral", "N m")]
    assert "states" not in wucht("list", "rotor", "--json").document["tables"][0]


def test_bad_names(refused: Refused) -> None:
    refused("list", "rotar", says=("NAME", "did you mean 'rotor'"))
    refused("list", "laundry-drum", says=("did you mean 'practice/laundry-drum'", "`wucht list` prints all names"))
    refused("list", "practice/scren", says=("must be a study, a part or a catalogue name", "'practice/screen'"))
    refused("list", "x" * 10_000, says=("NAME",))
    refused("list", "", says=("NAME",))
    refused("list", "--json", says=("--json", "only with the name"))
    refused("list", "--all", says=("--all", "only with the name"))


def test_the_catalogue_is_listed_with_its_titles(wucht: Command) -> None:
    lines = wucht("list").out.splitlines()
    (line,) = [line for line in lines if line.split()[:1] == ["practice/laundry-drum"]]
    assert line.endswith("  Washing machine: drum with laundry in one place and a ball balancing ring")
