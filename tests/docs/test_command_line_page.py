"""The page on the command line: its commands run and print what it says."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

TEXT = (Path(__file__).parents[2] / "docs" / "command-line.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)


@pytest.mark.slow
@pytest.mark.usefixtures("unpainted")
def test_the_page(wucht: Callable[..., Any], here: Path) -> None:
    said, kinds = "", list[str]()
    for kind, text in BLOCK.findall(TEXT):
        kinds.append(kind)
        if kind == "text":
            assert said.strip() == text.strip()
        if kind == "json":
            told, printed = json.loads(text), json.loads(said)
            folder = printed["file"].removesuffix(told["file"])
            assert told == {k: v.replace(folder, "") if isinstance(v, str) else v for k, v in printed.items()}
        for line in text.splitlines() if kind == "sh" else ():
            done = wucht(*shlex.split(line)[1:])
            assert done.code == (2 if "slop=" in line else 0), done.err
            said = done.out
    assert kinds == ["sh", "text", "sh", "sh", "json", "sh"]
    files = {path.name for folder in ("r1", "tables") for path in Path(folder).iterdir()}
    assert {"run-up-time.csv", "run-up-numbers.csv", "run-up.svg", "run-up.pdf"} <= files
