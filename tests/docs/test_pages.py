"""README and docs: each command is one that there is, each file is read, each snippet runs, and prints what the page says.

The fast tests read commands and files as the command line does; the slow ones run them.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from page_blocks import PAGES, ROOT, Block, blocks, inline_commands, missing, run_python, write_files

from wucht.cli.options import parse_settings
from wucht.files.building import machine_from
from wucht.files.catalogue import FOLDER, names
from wucht.machines.parts import bodies, carriers, drives, loads
from wucht.studies.registry import studies
from wucht.studies.study_file import read_study

# Their blocks are run by tests of their own, which check what they compute by other means.
ELSEWHERE = {
    "docs/continuation.md": "test_continuation_page",
    "docs/averaging.md": "test_averaging_page",
    "docs/fatigue.md": "test_fatigue_page",
    "docs/journeys.md": "test_journeys_page",
}
LANGUAGES = ("sh", "toml", "csv", "json", "python", "text", "")
TABLES = ("title", "machine", "study", "system", "law", "follower", "linkage", "speed", "shaft")


def _all(language: str) -> list[Any]:
    found = [(name, page, b) for name, page in PAGES.items() for b in blocks(page) if b.language == language]
    return [pytest.param(page, b, id=f"{name}-{i}") for i, (name, page, b) in enumerate(found, 1)]


@pytest.mark.parametrize("name", PAGES)
def test_blocks_are_of_a_kind_that_is_tested(name: str) -> None:
    found = blocks(PAGES[name])
    assert {b.language for b in found} <= set(LANGUAGES)
    stray = re.findall(r"(?m)^    (?:wucht|make|pip|python) .*$", PAGES[name].read_text(encoding="utf-8"))
    assert not stray, "commands stand in blocks ```sh"


@pytest.mark.parametrize(("page", "block"), _all("sh"))
def test_commands_are_ones_that_there_are(page: Path, block: Block, here: Path) -> None:
    _write_all_files(page)
    assert {words[0] for words in block.commands} <= set(CHECKED)
    for words in block.commands:
        CHECKED[words[0]](words[1:])


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in PAGES if inline_commands(PAGES[n])])
def test_commands_in_sentences_are_ones_that_there_are(name: str, here: Path) -> None:
    _write_all_files(PAGES[name])
    for words in inline_commands(PAGES[name]):
        assert words[0] == "wucht"
        _wucht(words[1:])


def _wucht(words: list[str]) -> None:
    """The options are known; a study that is named can be read, with all settings made."""
    import typer

    from wucht.cli import app as cli

    cli.register()
    whole: Any = typer.main.get_command(cli.app)
    if words[0] in {option for parameter in whole.params for option in parameter.opts}:
        return
    assert words[0] in whole.commands
    command = whole.commands[words[0]]
    if "--import" in words:  # what is loaded stays loaded: only a process of its own may do it
        assert (ROOT / words[words.index("--import") + 1]).is_file()
        return
    given = command.make_context(words[0], words[1:]).params
    if words[0] in ("run", "equations"):
        _provide(given["study"])
        read_study(given["study"], parse_settings(given.get("set_") or []))
    if words[0] == "new":
        assert given["name"] in (*studies(), *names())


def _write_all_files(page: Path) -> None:
    """Those that the page's ``wucht new NAME FILE`` write, and those that it shows."""
    for words in (words for block in blocks(page) if block.language == "sh" for words in block.commands):
        if words[:2] == ["wucht", "new"] and len(words) == 4:
            kind = studies().get(words[2])
            text = (FOLDER / f"{words[2]}.toml").read_text(encoding="utf-8") if kind is None else kind.template or ""
            Path(words[3]).write_text(text, encoding="utf-8")
    write_files(page)


def _provide(study: str) -> None:
    """A file of the reader's own, such as my-rotor.toml, that the page does not have: from a template."""
    kind = {"my-rotor.toml": "run-up", "my-cam.toml": "cam-contour"}.get(study)
    if kind is not None and not Path(study).is_file():
        Path(study).write_text(studies()[kind].template or "", encoding="utf-8")


def _make(words: list[str]) -> None:
    targets = re.findall(r"(?m)^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"))
    assert {w for w in words if "=" not in w} <= set(targets)


def _pip(words: list[str]) -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    assert words[0] == "install"
    for package, extra in re.findall(r"(\S+?)\[(\w+)\]", words[-1]):
        assert (package, extra in extras) == ("wucht", True)


def _python(words: list[str]) -> None:
    if words[0] == "-m":
        assert words[1] in ("docs.site", "tests.validation.errata", "http.server")
    else:
        assert (ROOT / words[0]).is_file()


def _known_to_others(words: list[str]) -> None:
    """Of dask, and of OpenSSL: tests/studies/test_scheduler_access.py runs them."""
    assert words[0] in ("scheduler", "worker", "req")


def _git(words: list[str]) -> None:
    assert words == ["clone", "ADDRESS", "wucht"], "no address of a host: a reader takes that of the page"


def _cd(words: list[str]) -> None:
    assert words == ["wucht"], "into the folder that was cloned"


CHECKED: dict[str, Callable[[list[str]], None]] = {
    "git": _git, "cd": _cd,
    "wucht": _wucht, "make": _make, "pip": _pip, "python": _python, "dask": _known_to_others,
    "openssl": _known_to_others,
}  # fmt: skip


@pytest.mark.parametrize(("page", "block"), _all("toml"))
def test_files_are_read(page: Path, block: Block, here: Path) -> None:
    """A file as a study, a part of one as the tables it has."""
    document = tomllib.loads(block.text)
    if block.title:
        _write_all_files(page)
        read_study(block.title)
        return
    kinds = {"bodies": bodies(), "drives": drives(), "loads": loads(), "carrier": carriers()}
    machine = document.get("machine", {})
    assert set(document) <= set(TABLES)
    for table in machine.get("bodies", []):
        part = kinds["bodies"][table["kind"]]
        part(**{k: v for k, v in table.items() if k != "kind"})
    if "carrier" in machine and "bodies" in machine:
        machine_from(machine)
    if "study" in document:
        table = document["study"]
        studies()[table["kind"]].study.from_table(table)


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in PAGES if n not in ELSEWHERE])
def test_pages_run_as_they_are_read(name: str, wucht: Any, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From top to bottom in one folder: commands, snippets, and what both print."""
    page = PAGES[name]
    (here / "examples").symlink_to(ROOT / "examples")
    write_files(page)
    known: dict[str, Any] = {}
    for block in blocks(page):
        printed = ""
        if block.language == "python":
            printed = run_python(block, known)
        for words in block.commands if block.language == "sh" else []:
            asked = _demo() if words == ["make", "demo"] else words
            if asked[0] != "wucht" or "--scheduler" in asked or asked[1] == "app":  # a server runs until Ctrl-C
                continue
            if "--import" in asked:  # as above
                subprocess.run([sys.executable, "-m", *asked], check=True, capture_output=True)
                continue
            done = wucht(*asked[1:])
            assert done.code == 0, (words, done.err)
            printed += done.out
        if block.said and block.language in ("sh", "python"):
            assert missing(block.said, printed) == [], printed
    for words in dict.fromkeys(map(tuple, inline_commands(page))):  # a file is written once
        if words[1] in ("app", "completion"):  # Typer prints the script of fish and ends the process
            continue
        _provide(words[2])
        done = wucht(*words[1:])
        assert done.code == 0, (words, done.err)


def _demo() -> list[str]:
    """What ``make demo`` runs."""
    (recipe,) = re.findall(r"(?m)^demo:.*\n\t\$\(BIN\)/(.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"))
    return str(recipe).split()


def test_what_is_missing_is_told() -> None:
    assert missing("a\n...\nd\n", "a\nb\nc\nd\n") == []
    assert missing("a\nc\n", "a\nb\nc\n") == ["c"]
    assert missing("speed 3...\n", "speed 3.14\n") == []
