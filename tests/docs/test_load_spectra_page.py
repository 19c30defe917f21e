"""The page on load spectra: its file and its code print what it says."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

TEXT = (Path(__file__).parents[2] / "docs" / "load-spectra.md").read_text(encoding="utf-8")
FORCES = (-2, 1, -3, 5, -1, 3, -4, 4, -2)


def test_the_record_of_the_standard(wucht, here):
    file, said = re.search(r"```toml\n(.*?)```.*?```text\n(.*?)```", TEXT, re.DOTALL).groups()
    (here / "specimen.toml").write_text(file, encoding="utf-8")
    rows = "\n".join(f"{i},{force}" for i, force in enumerate(FORCES))
    (here / "record.csv").write_text(f"time [s], force [kN]\n{rows}\n", encoding="utf-8")
    out = wucht("run", "specimen.toml", "-o", "results").out
    assert out.startswith(said)


def test_counting_alone():
    code, said = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", TEXT, re.DOTALL).groups()
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "docs/load-spectra.md", "exec"), {})
    assert printed.getvalue() == said


def test_when_the_specimen_fails(wucht, here):
    said = re.search(r"## When the specimen fails.*?```text\n(.*?)```", TEXT, re.DOTALL).group(1)
    out = wucht("run", "drozdetskaya-2020/failure-of-the-specimen", "-o", "results").out
    assert out.startswith(said)
    assert "its work -0.83" in out
