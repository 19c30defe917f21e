"""Words that complete a line, of a vocabulary made by hand; and the folder of a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from wucht.cli import completing
from wucht.cli.compare import _folder

PARTS = {
    "carriers": {"xy": ["mass", "stiffness"], "x": ["mass"]},
    "bodies": {"rotor": ["mass", "inertia"], "pendulum": ["length"]},
    "drives": {"linear": ["slope"], "induction": ["voltage"]},
    "loads": {"viscous": ["coefficient"], "quadratic": ["fan"]},
    "attachments": {"end-stop": ["gap"]},
    "dimensionless machines": {"exciter": ["u", "mu"]},
}
KNOWN: dict[str, Any] = {
    "commands": {
        "run": {"--set": True, "--out": True, "-o": True, "--json": False, "--format": True},
        "compare": {"--set": True, "--vary": True},
        "new": {},
        "list": {"--json": False},
    },
    "values": {"--format": ["png", "pdf"]},
    "names": {"list": ["rotor"], "new": ["run-up"]},
    "default": "run-up",
    "studies": {"run-up": {"until": "> 0", "model": "full, averaged"}, "sweep": {"points": ""}},
    "parts": PARTS,
}


@pytest.fixture(autouse=True)
def vocabulary(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(completing, "_vocabulary", lambda: KNOWN)
    monkeypatch.setattr(completing, "_catalogue", lambda: ["practice/fan"])
    Path("fan.toml").write_text('[machine]\nmodel = "exciter"\n', encoding="utf-8")
    Path("sweep.toml").write_text('[machine]\nuse = "fan.toml"\n[study]\nkind = "sweep"\n', encoding="utf-8")
    Path("notes.txt").write_text("", encoding="utf-8")
    Path("more").mkdir()


STUDY_FILES = ["fan.toml", "more/", "practice/fan", "sweep.toml"]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("wucht", ["--help", "--version", "compare", "list", "new", "run"]),
        ("wucht r", ["run"]),
        ("wucht run ", STUDY_FILES),
        ("wucht compare fan.toml ", STUDY_FILES),
        ("wucht new ", ["practice/fan", "run-up"]),
        ("wucht list ", ["practice/fan", "rotor"]),
        ("wucht run f", ["fan.toml"]),
        ("wucht run fan.toml -", ["--format", "--json", "--out", "--set", "-o"]),
        ("wucht run fan.toml --json ", STUDY_FILES),
        ("wucht run fan.toml --format ", ["pdf", "png"]),
        ("wucht run fan.toml --format=p", ["--format=pdf", "--format=png"]),
        ("wucht run fan.toml -o ", []),
        ("wucht run fan.toml --set ", ["mu=", "study.kind=", "study.model=", "study.until=", "u="]),
        ("wucht run sweep.toml --set ", ["mu=", "study.kind=", "study.points=", "u="]),
        ("wucht run fan.toml --set=m", ["--set=mu="]),
        ("wucht run fan.toml --set study.model=", ["study.model=averaged", "study.model=full"]),
        ("wucht run fan.toml --set study.until=", ["study.until="]),
        ("wucht run fan.toml --set study.kind=s", ["study.kind=sweep"]),
        ("wucht compare fan.toml sweep.toml --vary study.", ["study.kind=", "study.model=", "study.points=", "study.until="]),
        ("wucht compare --vary u=1 fan.toml --set m", ["mu="]),
        ('wucht run "fa', ["fan.toml"]),
        ("wucht run 'fa", ["fan.toml"]),
    ],
)
def test_what_may_follow(line: str, expected: list[str]) -> None:
    assert completing.words(line) == expected


def test_values_of_options_are_no_studies_but_what_follows_a_flag_is_one() -> None:
    options = KNOWN["commands"]["run"]
    assert completing._studies(["a.toml", "--out", "folder", "b.toml"], options) == ["a.toml", "b.toml"]
    assert completing._studies(["--set", "u=1", "a.toml"], options) == ["a.toml"]
    assert completing._studies(["--json", "a.toml"], options) == ["a.toml"]
    assert completing._studies(["--set=u=1", "a.toml"], options) == ["a.toml"]
    assert completing._studies(["-o", "folder"], options) == []
    assert completing._studies([], options) == []
    assert completing.words("wucht run --json fan.toml --set m") == ["mu="]


def test_files_of_a_folder_keep_its_path() -> None:
    Path("more/inner.toml").write_text("", encoding="utf-8")
    assert completing._files("more/") == ["more/inner.toml"]
    assert completing._files("./more/in") == ["./more/inner.toml"]
    whole = str(Path("more").resolve())
    assert completing._files(f"{whole}/") == [f"{whole}/inner.toml"]
    assert completing._files("nowhere/") == []
    assert "/tmp/" in completing._files("/tm")


@pytest.mark.parametrize(
    ("machine", "paths"),
    [
        ({}, ["carrier.mass", "carrier.stiffness"]),
        ({"carrier": {"directions": "x"}}, ["carrier.mass"]),
        ({"carrier": {"directions": "odd"}}, []),
        ({"model": "exciter", "carrier": {}}, ["u", "mu"]),
        ({"model": "odd"}, []),
    ],
)
def test_paths_of_a_carrier_or_a_model(machine: dict[str, Any], paths: list[str]) -> None:
    assert completing._paths(machine, PARTS) == paths


@pytest.mark.parametrize(
    ("shafts", "paths"),
    [
        ({"drive": {"kind": "linear"}}, ["drive.slope"]),
        ({"drives": [{"kind": "linear", "on": "a"}]}, ["drive.slope"]),
        ({"drives": [{"kind": "linear", "on": "a"}, {"kind": "induction", "on": "b"}]}, ["drives.a.slope", "drives.b.voltage"]),
        (
            {"loads": [{"kind": "viscous", "on": "a"}, {"kind": "quadratic", "on": "a"}, {"kind": "viscous", "on": "b"}]},
            ["loads.a.viscous.coefficient", "loads.a.quadratic.fan", "loads.b.coefficient"],
        ),
        ({"load": {"kind": "quadratic"}, "drive": {"kind": "odd"}}, ["load.fan"]),
        (
            {"bodies": [{"kind": "rotor", "name": "a"}, {"kind": "pendulum", "name": "p"}]},
            ["a.mass", "a.inertia", "p.length"],
        ),
        ({"attachments": [{"kind": "end-stop", "name": "s"}]}, ["s.gap"]),
    ],
)
def test_paths_of_parts_are_those_of_the_machine(shafts: dict[str, Any], paths: list[str]) -> None:
    assert completing._paths({"carrier": {"directions": "odd"}} | shafts, PARTS) == paths


@pytest.mark.parametrize(
    ("names", "folder"),
    [
        (["a.toml", "practice/fan"], "a+practice-fan"),
        (["../x y.toml", "u"], "x-y+u"),
        (["...", "/"], "all"),
        ([f"{'a' * 50}.toml", "b" * 50], f"{'a' * 50}+{'b' * 29}"),
    ],
)
def test_the_folder_of_a_comparison_is_named_after_what_is_compared(names: list[str], folder: str) -> None:
    assert _folder(names) == Path("results/compare") / folder
