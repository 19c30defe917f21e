"""``wucht list NAME``: what a study, a part or a file of the catalogue is, on one screen."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from wucht.cli.list_groups import groups
from wucht.cli.list_name import kinds
from wucht.files.catalogue import names
from wucht.studies.registry import studies

Command = Callable[..., Any]
Refused = Callable[..., str]


def test_keys_with_units_defaults_and_limits(wucht: Command) -> None:
    lines = wucht("list", "pendulum", "--all").out.splitlines()
    assert lines[0] == '[[machine.bodies]] kind = "pendulum"'
    rows = {line.split()[0]: k for k, line in enumerate(lines) if line.startswith("  ") and line[2] != " "}
    assert lines[rows["mass"]].split() == ["mass", "number", "kg", "needed", ">", "0"]
    assert lines[rows["mass"] + 1].strip() == "mass of the body"
    assert lines[rows["damping"]].split() == ["damping", "number", "N", "m", "s", "0.0", ">=", "0"]
    assert wucht("list", "run-up").out.startswith('[study] kind = "run-up"')


def test_every_name_is_explained_on_one_screen(wucht: Command) -> None:
    for name in sorted({*names(), *studies(), *(name for of_kind in kinds().values() for name in of_kind)}):
        lines = wucht("list", name).out.splitlines()
        assert len(lines) <= 24 and max(map(len, lines)) <= 100, name
        assert any(line.startswith("page    ") for line in lines), name


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


def test_everything_is_named_on_a_screen_without_codes_of_papers(wucht: Command) -> None:
    lines = wucht("list").out.splitlines()
    assert len(lines) <= 40 and max(map(len, lines)) <= 100
    words = set(re.findall(r"[\w./-]+", "\n".join(lines)))
    assert {name for of_kind in kinds().values() for name in of_kind} | set(studies()) <= words
    assert f"practice ({sum(name.startswith('practice/') for name in names())})" in "\n".join(lines)
    for group in (*groups(), "studies"):
        for line in wucht("list", group).out.splitlines():
            assert re.search(r"\(\d+\.\d+\)|\(\d+\)-|\b00[0-4]\b|Drozdetskaya|Sperling", line) is None, line


def test_a_group_has_a_line_for_each_name(wucht: Command) -> None:
    from wucht.machines.parts import drives

    lines = wucht("list", "drives").out.splitlines()
    assert [line.split()[0] for line in lines] == list(drives())
    assert "  induction        A three-phase induction motor by its equivalent circuit." in lines
    practice = wucht("list", "practice").out.splitlines()
    assert [line.split()[0] for line in practice] == [name for name in names() if name.startswith("practice/")]
    assert len(wucht("list", "catalogue").out.splitlines()) == len(names())
    assert [line.split()[0] for line in wucht("list", "studies").out.splitlines()] == list(studies())
    document = wucht("list", "carriers", "--json").document
    assert document["name"] == "carriers" and "xyr" in document["names"]
    assert wucht("list", "xyr").out.startswith('[machine.carrier] directions = "xyr"')


def test_a_word_is_searched_in_names_titles_keys_and_results(wucht: Command) -> None:
    found = {line.split()[0]: line for line in wucht("list", "--search", "stroke").out.splitlines()}
    assert len(found) <= 16
    assert "in its results: stroke" in found["run-up"] and "in its results: stroke" in found["response"]
    assert "key stroke" in found["modified-sine"]
    nameplate = wucht("list", "--search", "Nameplate").out
    assert "induction" in nameplate and "practice/fan-on-belt" in nameplate
    first = wucht("list", "--search", "run-up").out.splitlines()[0]
    assert first.split()[0] == "run-up", "a name comes before what only mentions it"
    assert next(iter(wucht("list", "--search", "screen").out.splitlines())).split()[0].startswith("practice/screen")
    every = wucht("list", "--search", "a").out.splitlines()
    assert len(every) == 16 and "more: give more letters" in every[-1]


def test_bad_names(refused: Refused) -> None:
    refused("list", "rotar", says=("NAME", "did you mean 'rotor'"))
    refused("list", "laundry-drum", says=("did you mean 'practice/laundry-drum'", "`wucht list` prints all names"))
    refused("list", "practice/scren", says=("must be a study, a part or a catalogue name", "'practice/screen'"))
    refused("list", "x" * 10_000, says=("NAME",))
    refused("list", "", says=("NAME",))
    refused("list", "--json", says=("--json", "only with the name"))
    refused("list", "--search", "xyzzy", says=("--search", "nothing has this word", "`wucht list` prints all names"))
    refused("list", "--search", "  ", says=("--search", "must be a word"))
    refused("list", "rotor", "--search", "balls", says=("--search", "give either a word or the name 'rotor'"))
    refused("list", "--json", "--search", "balls", says=("--json", "only with the name"))
    refused("list", "practise", says=("NAME", "practice"))
    refused("list", "--all", says=("--all", "only with the name"))
