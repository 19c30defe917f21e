"""What cannot be designed: a sentence each, with the file and the key, and exit code 2."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tests import refusals

import wucht
from wucht import run_file
from wucht.studies.study_file import read_study

FILE = """\
[machine]
use = "practice/exciter"
[study]
kind = "exciter-design"
vary = { drive.slope = ["2e-4 N m s", "3e-3 N m s"] }
target = { shape = "normal", largest = "2 mm", cycles = 1e6 }
reach = 16
"""
TARGET = 'target = { shape = "normal", largest = "2 mm", cycles = 1e6 }'
VARY = 'vary = { drive.slope = ["2e-4 N m s", "3e-3 N m s"] }'
CASES = {
    "no target": (TARGET, "", ("study.target", "missing")),
    "target a number": (TARGET, "target = 3", ("study.target", "given 3", "{ file = FILE }")),
    "shape": ('"normal"', '"gauss"', ("study.target.shape", "'gauss'", "'straight-line'")),
    "shape without cycles": (", cycles = 1e6", "", ("study.target.cycles", "missing", "needs it")),
    "shape and table": ("cycles = 1e6", "cycles = 1e6, table = [[1, 2]]", ("study.target", "shape, table", "one of shape")),
    "steps of a shape": ("cycles = 1e6", "cycles = 1e6, stepped = true", ("study.target.stepped", "only with a table")),
    "largest of a table": (TARGET, "target = { table = [[1, 9], [2, 2]], largest = 1 }", ("study.target.largest", "a shape")),
    "unit of the largest": ('"2 mm"', '"2 N"', ("study.target.largest", "'2 N'", "a force")),
    "negative largest": ('"2 mm"', '"-2 mm"', ("study.target.largest", "greater than 0")),
    "ratio": ("cycles = 1e6", "cycles = 1e6, ratio = 1.5", ("study.target.ratio", "less than 1")),
    "rising cycles": (TARGET, 'target = [["1 mm", 5], ["2 mm", 9]]', ("study.target.table", "do not increase")),
    "one row": (TARGET, 'target = [["1 mm", 5]]', ("study.target.table", "two rows")),
    "same amplitude": (TARGET, 'target = [["1 mm", 5], ["1 mm", 3]]', ("study.target.table", "different amplitudes")),
    "unit in the table": (TARGET, 'target = [["1 mm", 5], ["2 s", 3]]', ("study.target.table[1][0]", "'2 s'")),
    "no pairs": (TARGET, "target = { table = [1, 2] }", ("study.target.table", "pairs [AMPLITUDE, CYCLES]")),
    "no such file": (TARGET, 'target = { file = "traget.csv" }', ("study.target.file", "traget.csv", "no such file")),
    "key of the target": ("cycles = 1e6", "cycels = 1e6", ("study.target.cycels", "did you mean 'cycles'")),
    "no vary": (VARY, "", ("study.vary", "missing")),
    "unknown parameter": ("drive.slope", "drive.slop", ("study.vary", "did you mean 'drive.slope'")),
    "range turned round": (VARY, "vary = { drive.slope = [3e-3, 2e-4] }", ("study.vary.drive.slope", "low below high")),
    "end that is no part": (VARY, "vary = { rotor.inertia = [1e-9, 1] }", ("study.vary.rotor.inertia", "1e-09")),
    "metric": ("reach = 16", 'metric = "area"', ("study.metric", "'area'", "'cumulative'")),
    "signal": ("reach = 16", 'signal = "stress"', ("study.signal", "'stress'", "'bearing-force'")),
    "direction": ("reach = 16", 'direction = "r"', ("study.direction", "'r'", "x, y")),
    "few evaluations": ("reach = 16", "evaluations = 8", ("study.evaluations", "given 8", "at least 16")),
    "too many beats": ("reach = 16", "beats = 1", ("study.beats", "given 1", "from 2 to 10000")),
    "spread": ("reach = 16", "spread = 1.2", ("study.spread", "less than 1")),
    "no pendulum": ('use = "practice/exciter"', 'use = "drozdetskaya-2020/table-3.1-laval"', ("machine", "are needed")),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_what_cannot_be_is_a_sentence(refused: Callable[..., str], here: Path, case: str) -> None:
    old, new, says = CASES[case]
    assert old in FILE
    Path("design.toml").write_text(FILE.replace(old, new), encoding="utf-8")
    refused("run", "design.toml", says=("design.toml", *says))


def test_a_file_of_the_target_is_read_beside_the_study_file(refused: Callable[..., str], here: Path) -> None:
    Path("design.toml").write_text(FILE.replace(TARGET, 'target = { file = "target.csv" }'), encoding="utf-8")
    Path("target.csv").write_text("amplitude [mm], cycles\n1, 1e5\n2, 2e5\n", encoding="utf-8")
    refused("run", "design.toml", says=("design.toml", "study.target.file", "do not increase"))
    with refusals.refused("study.target.file", given="target.csv", code="not-allowed"):
        read = read_study("design.toml")
        wucht.run(read.spec, read.subject.machine)
    Path("target.csv").write_text("amplitude [N], cycles\n1, 1e5\n2, 2e4\n", encoding="utf-8")
    refused("run", "design.toml", says=("design.toml", "study.target.file", "this one is a force"))


@pytest.mark.parametrize(
    "target",
    [
        'target = { file = "target.csv" }',
        'target = [["2 mm", "2e4 cycles"], ["1 mm", 1e5]]',
        'target = { exponent = 2, largest = "2 mm", cycles = "1e5 cycles" }',
    ],
)
def test_a_cycle_is_one_and_no_angle(here: Path, target: str) -> None:
    """In the words of units a cycle is 2 pi; in a table as in its heading it counts."""
    Path("design.toml").write_text(FILE.replace(TARGET, target), encoding="utf-8")
    Path("target.csv").write_text("amplitude [mm], cycles\n1, 1e5\n2, 2e4\n", encoding="utf-8")
    nothing_beats = {
        "study.vary": {"drive.slope": [4e-3, 8e-3]},
        "study.evaluations": 4,
        "study.population": 4,
        "study.reach": 4,
    }
    form = run_file("design.toml", nothing_beats).wucht.summary["target"]
    assert (form["cycles"], form["upper"]) == (pytest.approx(1e5), pytest.approx(2e-3))
