"""``wucht compare``: its table, JSON, CSV and figure, and bad input."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Command = Callable[..., Any]
Study = Callable[..., Path]
Refused = Callable[..., str]
SLOPE = "slope of the torque-speed curve, drive"
SHORT = ("--set", "study.until=0.02 s")


@pytest.mark.usefixtures("no_figures")
def test_table_figure_and_files(wucht: Command, study: Study) -> None:
    study(name="a.toml")
    study('"9 kg"', '"11 kg"', name="b.toml")
    done = wucht("compare", "a.toml", "b.toml", "--vary", "drive.slope=0.03,0.05", *SHORT, "--csv")
    assert done.code == 0, done.err
    folder = Path("results/compare/a+b+drive.slope")
    title, verdict, *heads, a, b, c, d, _files, _next = done.out.splitlines()
    lines = [a, b, c, d]
    assert title == f"Comparison of a, b, varied: {SLOPE}"
    assert verdict == "verdict: 4 variants: 4 unidentified"
    assert [head.split() for head in heads[:2]] == [["slope", "of", "the"], ["torque-speed"]]
    assert heads[-1].split()[:3] == ["(N·m·s)", "outcome", "(rad/s)"]
    assert [line.split()[:2] for line in lines] == [[n, v] for n in "ab" for v in ("0.03", "0.05")]
    with (folder / "comparison-variant.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["variant"], row["drive.slope [N m s]"]) for row in rows] == [
        (f"{n}; {SLOPE} = {v} N m s", v) for n in "ab" for v in ("0.03", "0.05")
    ]
    assert f"{float(rows[2]['final_speed [rad/s]']):.5g}" in lines[2]
    assert {p.name for p in folder.iterdir()} == {
        "result.nc", "comparison.png", "summary.json",
        *(f"comparison-{n}.csv" for n in ("variant", "sample_1", "sample_2", "variants", "numbers")),
    }  # fmt: skip


@pytest.mark.usefixtures("no_figures")
def test_one_json_object(wucht: Command, study: Study) -> None:
    words = ("compare", study(), "--vary", "drive.slope=0.03 N m s,-1", *SHORT, "-o", "out", "--json")
    done = wucht(*words)
    assert done.code == 0, "one of them has an answer"
    first, second = done.document["summary"]["variants"]
    assert first["varied"] == {"drive.slope": 0.03}
    assert first["summary"]["final_speed"] > 0
    assert second["failure"].startswith("study.toml: machine.drive.slope: given -1")
    assert wucht(*words, "--resume").document["summary"] == done.document["summary"]


WRONG = {
    "one alone": (("study.toml",), ("study.of", "2 to 500 variants")),
    "no such file": (("study.toml", "nothing.toml"), ("nothing.toml", "no such file")),
    "no such key": (("study.toml", "--vary", "drive.slop=1,2"), ("study.toml: machine.drive.slop", "did you mean")),
    "an empty value": (("study.toml", "--vary", "drive.slope=1,,2"), ("--vary", "KEY=VALUE,VALUE")),
    "set too": (("study.toml", "--vary", "u=1,2", "--set", "u=3"), ("study.vary.u", "also in set")),
    "too many": (("study.toml", "--vary", f"u={','.join(map(str, range(501)))}"), ("study.vary", "these are 501")),
    "brackets": (("study.toml", "--vary", f"u={5000 * '['}"), ("--vary", "at most 40 brackets")),
    "a result": (("done", "study.toml", "--set", "drum.mass=10"), ("study.of", "this is a result")),
}


def test_a_comparison_of_comparisons(refused: Refused, wucht: Command, study: Study) -> None:
    assert wucht("new", "comparison").code == 0
    refused("compare", "comparison.toml", study(), says=("study.of", "this is a comparison"))
    refused("run", "comparison.toml", "--set", "study.vary=3", says=("comparison.toml: study.vary", "table of lists"))


@pytest.mark.parametrize(("words", "says"), WRONG.values(), ids=WRONG.keys())
def test_bad_input(refused: Refused, study: Study, words: tuple[str, ...], says: tuple[str, ...]) -> None:
    study()
    Path("done").mkdir()
    Path("done/result.nc").write_text("")
    refused("compare", *words, "-o", "out", says=says)
    assert not Path("out").exists()
