"""``wucht share``: a page from which no request leaves, or a sentence."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from wucht import WuchtError
from wucht.web import live_page

Command = Callable[..., Any]
Refused = Callable[..., str]
R1 = "drozdetskaya-2020/r1"
NAMESPACES = ("http://www.w3.org/2000/svg", "http://www.w3.org/1999/xhtml")


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> None:
    """Script and style as they would be built."""
    monkeypatch.setattr(live_page, "built_file", lambda name: f"/* {name} */")


def contents_of(page: str) -> dict[str, Any]:
    match = re.search(r"^const page = (.*);$", page, re.MULTILINE)
    assert match
    contents: dict[str, Any] = json.loads(match[1])
    return contents


@pytest.mark.usefixtures("built")
def test_a_page_has_the_verdict_of_its_file(wucht: Command, here: Path) -> None:
    assert wucht("share", R1, "--set", "study.until=4 s", "-o", "sub/r1.html").out == "sub/r1.html\n"
    page = (here / "sub" / "r1.html").read_text(encoding="utf-8")
    contents = contents_of(page)
    assert contents["until"] == 4
    assert contents["text"]["verdict"][0] == "unidentified"
    assert contents["text"]["card"]["title"] == "Captured, and beating"
    assert "default-src 'none'" in page
    wucht("share", R1, "--no-verdict", "-o", "r1.html")
    assert contents_of((here / "r1.html").read_text(encoding="utf-8"))["text"]["verdict"] is None


@pytest.mark.usefixtures("built")
@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ["sperling-vibration/figure-4"],
            (
                "figure-4.toml: machine.bodies[1] (b1).release: given {'time': 30.0}; not allowed in a live machine",
                "whose bodies are free from the start; b2 has one, too",
            ),
        ),
        (["kaltofen-cam/dwell-and-return"], ("this file has none",)),
        ([R1, "--set", "drum.mass=-1"], ("drum",)),
        ([R1, "-o", "."], ("this is a folder", "machine.html")),
        ([R1, "-o", "machine.pdf"], ("page of HTML",)),
    ],
)
def test_what_cannot_be_shared_is_refused_by_a_sentence(refused: Refused, words: list[str], says: tuple[str, ...]) -> None:
    refused("share", *words, "--no-verdict", says=says)


def test_an_installation_without_the_page_says_how_to_build_it(
    wucht: Command, monkeypatch: pytest.MonkeyPatch, here: Path
) -> None:
    monkeypatch.setattr(live_page, "_WEB", here)
    done = wucht("share", R1, "--no-verdict")
    assert (done.code, done.out, done.err.count("\n")) == (1, "", 1)
    assert "npm had no network" in done.err
    assert "pip install --force-reinstall --no-deps --no-cache-dir wucht" in done.err


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "practice/screen",
    ],
)
def test_a_page_is_small_and_has_no_address_outside(wucht: Command, here: Path, name: str) -> None:
    try:
        live_page.built_file("live.js")
    except WuchtError as error:
        pytest.skip(str(error))
    wucht("share", name, "--no-verdict")
    page = (here / "machine.html").read_text(encoding="utf-8")
    assert len(page.encode()) < 250_000
    assert [a for a in re.findall(r"https?://[^\s\"'<>)]*", page) if a not in NAMESPACES] == []
    assert re.findall(r"<(?:link|img|iframe|object|script\s+src)", page) == []
    assert "@import" not in page
    assert re.findall(r"url\((?!data:|blob:)", page) == []
