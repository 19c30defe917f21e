"""The page on comparisons: its commands run and print what it says."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

TEXT = (Path(__file__).parents[2] / "docs" / "comparing.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)


@pytest.mark.slow
@pytest.mark.usefixtures("unpainted")
def test_the_page(wucht: Callable[..., Any], here: Path) -> None:
    said = ""
    kinds = set()
    for kind, text in BLOCK.findall(TEXT):
        kinds.add(kind)
        if kind == "text":
            assert said.startswith(text), text
        elif kind == "python":
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(text, "docs/comparing.md", "exec"), {})
            said = printed.getvalue()
        elif kind == "toml":
            Path("pair.toml").write_text(text, encoding="utf-8")
            assert wucht("run", "pair.toml").code == 0
            assert Path("results/pair/comparison.png").is_file()
        for line in text.splitlines() if kind == "sh" else ():
            done = wucht(*shlex.split(line)[1:])
            assert done.code == 0, done.err
            said = done.out
    assert kinds == {"sh", "text", "toml", "python"}
