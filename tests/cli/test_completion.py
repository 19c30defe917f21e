"""Completion as a shell asks for it: what can follow on a line. In zsh and fish where these are installed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from wucht.files.catalogue import FOLDER

Command = Callable[..., Any]
Study = Callable[..., Path]
PROGRAM = Path(sys.executable).with_name("wucht")
R1 = "wucht run drozdetskaya-2020/r1"
LINES = {
    "wucht run sperling-rollers/table-": [f"sperling-rollers/table-{k}" for k in (1, 2, 3)],
    f"{R1} --set study.tolerance=": ["study.tolerance="],
    "wucht compare drozdetskaya-2020/r1 practice/screen --vary e1.un": ["e1.unbalance="],
    "wucht new cam-p": ["cam-prediction"],
}


def answers(line: str) -> list[str]:
    """What fish is told; unlike bash it does not split words at "="."""
    asked = {"_WUCHT_COMPLETE": "complete_fish", "_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    done = subprocess.run([PROGRAM], env=os.environ | asked, capture_output=True, text=True, check=True)
    assert not done.stderr
    return [answer.partition("\t")[0] for answer in done.stdout.splitlines() if answer]


@pytest.mark.slow
@pytest.mark.parametrize(("line", "expected"), LINES.items(), ids=LINES.keys())
def test_what_can_follow(here: Path, line: str, expected: list[str]) -> None:
    assert answers(line) == expected


@pytest.mark.slow
def test_commands_and_all_names(here: Path) -> None:
    assert {"run", "compare", "list"} <= {*answers("wucht ")}
    catalogue = {path.relative_to(FOLDER).with_suffix("").as_posix() for path in FOLDER.rglob("*.toml")}
    assert {*answers("wucht run ")} == catalogue
    assert catalogue | {"run-up", "pendulum"} < {*answers("wucht list ")}


@pytest.mark.slow
def test_files_and_the_machine_that_they_use(study: Study) -> None:
    study(name="drum.toml")
    Path("results").mkdir()
    Path("results/top.toml").write_text('[machine]\nuse = "../drum.toml"\n[study]\nkind = "basin"\n')
    Path("results/notes.txt").touch()
    assert answers("wucht run dru") == ["drum.toml"]
    assert answers("wucht run res") == ["results/"]
    assert answers("wucht run results/") == ["results/top.toml"]
    assert answers("wucht run nowhere/") == []
    assert answers("wucht run results/top.toml --set study.axes") == ["study.axes="]
    assert answers("wucht run results/top.toml --set p1.l") == ["p1.length="]


ASKED = """
eval "$({program} completion bash)"
wucht() {{ {program} "$@"; }}
asked() {{
    COMP_LINE="$1" COMP_POINT=${{#1}} COMPREPLY=() COMP_CWORD=$2
    read -ra COMP_WORDS <<< "${{1//=/ = }}"
    compopt() {{ echo -n "no blank after: "; }}
    _wucht_complete
    echo "${{COMPREPLY[*]}}"
}}
asked "wucht run practice/scr" 2
asked "wucht run drozdetskaya-2020/r1 --set study.model=s" 6
asked "wucht run drozdetskaya-2020/r1 --set study.mod" 4
asked "wucht run my" 2
asked "wucht run fol" 2
complete -p wucht
"""


@pytest.mark.slow
def test_in_bash(study: Study) -> None:
    """Words that Readline splits at "=" are completed, blanks in names escaped; none follows KEY= or folder/."""
    study(name="my drum.toml")
    Path("folder").mkdir()
    script = ASKED.format(program=PROGRAM)
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "practice/screen practice/screen-loaded practice/screen-unsynchronised",
        "slow",
        "no blank after: study.model=",
        "my\\ drum.toml",
        "no blank after: folder/",
        "complete -o default -F _wucht_complete wucht",
    ]


def test_a_file_that_is_no_study_is_passed_over(here: Path) -> None:
    Path("number.toml").write_text('study = 3\n[machine]\nuse = "drozdetskaya-2020/r1"\n')
    assert answers("wucht run number.toml --set st") == []


def test_an_unknown_shell(refused: Callable[..., str]) -> None:
    refused("completion", "tcsh", says=("tcsh", "fish"))
