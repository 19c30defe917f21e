"""What cannot be designed: a sentence each, with the file and the key, and exit code 2."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.refusals import cases_of, check_file

from wucht import run_file

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
CHANGES = {
    TARGET: [
        "", "target = 3", "target = { table = [[1, 9], [2, 2]], largest = 1 }", 'target = [["1 mm", 5], ["2 mm", 9]]',
        'target = [["1 mm", 5]]', 'target = [["1 mm", 5], ["1 mm", 3]]', 'target = [["1 mm", 5], ["2 s", 3]]',
        "target = { table = [1, 2] }", 'target = { file = "traget.csv" }',
    ],
    '"normal"': ['"gauss"'], ", cycles = 1e6": [""],
    "cycles = 1e6": [
        "cycles = 1e6, table = [[1, 2]]", "cycles = 1e6, stepped = true", "cycles = 1e6, ratio = 1.5", "cycels = 1e6",
    ],
    '"2 mm"': ['"2 N"', '"-2 mm"'],
    VARY: ["", "vary = { drive.slope = [3e-3, 2e-4] }", "vary = { rotor.inertia = [1e-9, 1] }"],
    "drive.slope": ["drive.slop"],
    "reach = 16": [
        'metric = "area"', 'signal = "stress"', 'direction = "r"', "evaluations = 8", "beats = 1", "spread = 1.2",
    ],
    'use = "practice/exciter"': ['use = "drozdetskaya-2020/table-3.1-laval"'],
}  # fmt: skip


@pytest.mark.parametrize(("old", "new"), cases_of(CHANGES))
def test_what_cannot_be_is_a_sentence(here: Path, old: str, new: str) -> None:
    check_file("exciter-design", FILE, {old: new})


@pytest.mark.parametrize("rows", ["amplitude [mm], cycles\n1, 1e5\n2, 2e5\n", "amplitude [N], cycles\n1, 1e5\n2, 2e4\n"])
def test_a_file_of_the_target_is_read_beside_the_study_file(here: Path, rows: str) -> None:
    Path("target.csv").write_text(rows, encoding="utf-8")
    check_file(f"exciter-design, {rows}", FILE, {TARGET: 'target = { file = "target.csv" }'})


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
