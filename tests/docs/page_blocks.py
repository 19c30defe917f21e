"""Pages as what they ask a reader to type: their blocks, run in a folder of their own, with what they say comes out.

A block ``sh`` holds commands, a block ``text`` behind it what they print: line by line, ``...`` for any number of lines, and at
the end of a line for its rest. A block ``toml`` or ``csv`` with a title is a file of that name. A block ``python`` is run, and
``text`` behind it is what it prints.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PAGES = {p.relative_to(ROOT).as_posix(): p for p in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))}
_FENCE = re.compile(r'^```([a-z]+)?(?: title="(.+?)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page. said: the text behind it, if that follows at once."""

    language: str
    title: str
    text: str
    said: str = ""

    @property
    def commands(self) -> list[list[str]]:
        """The words of each command, its comment left out."""
        return [words for line in self.text.splitlines() if (words := shlex.split(line, comments=True))]


def blocks(page: Path, section: str = "") -> list[Block]:
    """The fenced blocks of a page, or of the section with that heading; a text belongs to the block before it, where nothing
    but blank lines is between them."""
    text = page.read_text(encoding="utf-8")
    if section:
        text = text.partition(f"\n## {section}\n")[2].partition("\n## ")[0]
        assert text, f"no section {section!r}"
    found: list[Block] = []
    end = 0
    for match in _FENCE.finditer(text):
        language, title, inside = match[1] or "", match[2] or "", match[3]
        if language == "text" and found and not text[end : match.start()].strip() and not found[-1].said:
            last = found[-1]
            found[-1] = Block(last.language, last.title, last.text, inside)
        else:
            found.append(Block(language, title, inside))
        end = match.end()
    return found


def without_blocks(text: str) -> str:
    """The sentences and tables of a page."""
    return _FENCE.sub("", text)


def inline_commands(page: Path) -> list[list[str]]:
    """The words of each ``wucht ...`` within a sentence that says all of it: no FILE, STUDY, NAME to be filled in."""
    text = without_blocks(page.read_text(encoding="utf-8"))
    found = [shlex.split(command) for command in re.findall(r"`(wucht \w+ [^`]+)`", text)]
    return [words for words in found if not any(re.search(r"\b[A-Z]{4,}\b|\.\.\.", word) for word in words)]


def write_files(page: Path) -> None:
    """The page's files into the working directory. Of two with one name the last remains."""
    for block in blocks(page):
        if block.language in ("toml", "csv") and block.title:
            Path(block.title).write_text(block.text, encoding="utf-8")


def run_python(block: Block, known: dict[str, Any]) -> str:
    """What a block prints; names that it defines are known to the next."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(block.text, "a page", "exec"), known)
    return printed.getvalue()


def missing(said: str, printed: str) -> list[str]:
    """The lines of a page that are not printed, in the order in which they stand there."""
    lines = iter(printed.splitlines())
    lost, skipping = [], False
    for wanted in said.splitlines():
        if wanted.strip() == "...":
            skipping = True
        elif not _found(wanted, lines, skipping):
            lost.append(wanted)
        else:
            skipping = False
    return lost


def _found(wanted: str, lines: Iterator[str], skipping: bool) -> bool:
    for line in lines:
        if line == wanted or (wanted.endswith("...") and line.startswith(wanted.removesuffix("..."))):
            return True
        if not skipping:
            return False
    return False
