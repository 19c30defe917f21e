"""Completion: what can follow on a line, in how little, and in a shell."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from wucht.cli.completing import words
from wucht.studies.study_file import read_study

Command = Callable[..., Any]
Study = Callable[..., Path]
HEAVY = {"numpy", "sympy", "llvmlite", "xarray", "pint", "matplotlib", "pydantic", "typer", "rich"}

LINES = {
    "wucht eq": ["equations"],
    "wucht ": None,
    "wucht run sperling-rollers/table-": [f"sperling-rollers/table-{k}" for k in (1, 2, 3)],
    "wucht run drozdetskaya-2020/r1 --set study.model=": [f"study.model={m}" for m in ("both", "full", "slow")],
    "wucht run drozdetskaya-2020/r1 --set drive.no": ["drive.no_load_speed="],
    "wucht run drozdetskaya-2020/r1 --set=drive.no": ["--set=drive.no_load_speed="],
    "wucht run practice/screen --set drives.e2.v": ["drives.e2.voltage="],
    "wucht run drozdetskaya-2020/table-5.1 --set la": ["lambda="],
    "wucht compare drozdetskaya-2020/r1 practice/screen --vary e1.un": ["e1.unbalance="],
    "wucht run drozdetskaya-2020/r1 --set study.kind=torque": ["study.kind=torque-balance"],
    "wucht run drozdetskaya-2020/r1 --set study.tolerance=": ["study.tolerance="],
    "wucht plot out --format s": ["svg"],
    "wucht plot out --style j": ["journal"],
    "wucht run practice/screen-loaded --set material.s": ["material.share="],
    "wucht equations x --no": ["--no-inertia"],
    "wucht list switch": ["switchable-pendulum"],
    "wucht new cam-p": ["cam-prediction"],
    "wucht completion f": ["fish"],
    "wucht run x --out ": [],
    'wucht run "un': [],
    "wucht r": ["report", "run"],
    "wucht plot out --format=s": ["--format=svg"],
    "wucht run drozdetskaya-2020/r1 --json --set p1.m": ["p1.mass="],
    "wucht run -o out drozdetskaya-2020/r1 --set p1.m": ["p1.mass="],
    "wucht compare --vary p1.mass=1 drozdetskaya-2020/r1 --set p2.m": ["p2.mass="],
}


@pytest.mark.parametrize(("line", "expected"), LINES.items(), ids=LINES.keys())
def test_what_can_follow(here: Path, line: str, expected: list[str] | None) -> None:
    if expected is None:
        assert {"run", "compare", "list", "completion", "--help"} <= set(words(line))
    else:
        assert words(line) == expected


def test_files_and_the_machine_that_they_use(study: Study) -> None:
    study(name="my drum.toml")
    Path("results").mkdir()
    Path("results/top.toml").write_text('[machine]\nuse = "../my drum.toml"\n[study]\nkind = "basin"\n')
    assert words("wucht run my") == ["my drum.toml"]
    assert words("wucht run res") == ["results/"]
    assert words("wucht run results/") == ["results/top.toml"]
    assert words("wucht run results/top.toml --set study.axes") == ["study.axes="]
    assert words("wucht run results/top.toml --set p1.l") == ["p1.length="]
    assert words('wucht run "my drum.toml" --set p2.l') == ["p2.length="]
    Path("broken.toml").write_text("[machine")
    assert "study.until=" in words("wucht run broken.toml --set "), "of a run-up, until it says otherwise"
    whole = str(Path("results").resolve())
    assert words(f"wucht run {whole}/") == [f"{whole}/top.toml"] and words("wucht run ./results/t") == ["./results/top.toml"]
    assert words("wucht run nowhere/") == []


def test_parts_have_the_paths_of_their_machine(here: Path) -> None:
    """One drive or load by itself, several by their rotor, several of one rotor by their kind."""
    loads = [("viscous", "a"), ("coulomb", "a"), ("viscous", "b")]
    parts = "".join(f'[[machine.loads]]\nkind = "{kind}"\non = "{rotor}"\n' for kind, rotor in loads)
    Path("many.toml").write_text(f'{parts}[[machine.drives]]\nkind = "linear"\non = "a"\n', encoding="utf-8")
    Path("one.toml").write_text('[machine.load]\nkind = "coulomb"\n[machine.drive]\nkind = "odd"\n', encoding="utf-8")
    many, one = ([w for w in words(f"wucht run {name}.toml --set ") if not w.startswith("study.")] for name in ("many", "one"))
    assert {"loads.a.viscous.coefficient=", "loads.a.coulomb.torque=", "loads.b.coefficient=", "drive.slope="} <= set(many)
    assert "load.torque=" in one and not any(word.startswith("drive") for word in one)


@pytest.mark.parametrize(
    "name", ["drozdetskaya-2020/r1", "practice/screen", "sperling-rollers/table-1", "practice/laundry-drum"]
)
def test_the_keys_can_be_set(name: str) -> None:
    machine = read_study(name).subject
    found = [word.removesuffix("=") for word in words(f"wucht run {name} --set ") if not word.startswith("study.")]
    told = {
        path.removesuffix(".x").removesuffix(".y")
        for path in machine.parameters
        if not {"mounts", "tracks"} & {*path.split(".")}
    }
    assert told <= set(found)


def test_nothing_heavy_is_loaded(here: Path) -> None:
    words("wucht ")  # gathered by now
    code = (
        "import sys; from wucht.cli.completing import words; found = words('wucht run drozdetskaya-2020/r1 --set p1.m');"
        f"print(found, sorted({HEAVY} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['p1.mass='] []"


def test_what_is_kept_is_gathered_anew_where_it_is_damaged(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(here / "cache"))
    assert words("wucht eq") == ["equations"]
    kept = here / "cache/completion"
    whole = kept.read_bytes()
    for damaged in (b"", b"{", b"null", whole.replace(b"equations", b"equalions")):
        kept.write_bytes(damaged)
        assert words("wucht eq") == ["equations"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_what_is_kept_is_the_users_alone(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(here / "cache"))
    before = os.umask(0o002)
    try:
        words("wucht ")
    finally:
        os.umask(before)
    modes = [path.stat().st_mode & 0o777 for path in (here / "cache", here / "cache/completion")]
    assert modes == [0o700, 0o600]


SCRIPT = """\
eval "$({python} -m wucht completion bash)"
wucht() {{ {python} -m wucht "$@"; }}
asked() {{
    COMP_LINE="$1" COMP_POINT=${{#1}} COMPREPLY=()
    read -ra COMP_WORDS <<< "$1"
    compopt() {{ :; }}
    _wucht_complete
    echo "${{COMPREPLY[*]}}"
}}
asked "wucht run practice/scr"
asked "wucht run drozdetskaya-2020/r1 --set study.model=s"
complete -p wucht
"""


@pytest.mark.slow
def test_in_bash(here: Path) -> None:
    script = SCRIPT.format(python=sys.executable)
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True, env=dict(os.environ))
    first, second, third = done.stdout.splitlines()
    assert first == "practice/screen practice/screen-loaded practice/screen-unsynchronised"
    assert second == "slow", "what stands before the sign is a word of its own to readline"
    assert third == "complete -o default -F _wucht_complete wucht"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_script_asks_the_program(wucht: Command, shell: str) -> None:
    done = wucht("completion", shell)
    assert done.code == 0
    assert "complete-words" in done.out


def test_an_unknown_shell(refused: Callable[..., str]) -> None:
    refused("completion", "tcsh", says=("tcsh", "fish"))


def test_a_shell_is_answered_with_words(here: Path) -> None:
    command = [sys.executable, "-m", "wucht", "complete-words", "wucht", "eq"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "equations\n"
