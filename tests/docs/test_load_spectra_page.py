"""The page on load spectra: its file and its code print what it says."""

from __future__ import annotations

import contextlib
import io
import re

import pytest
from docs.site.numbers import as_written
from page_blocks import PAGES, blocks, write_files

from wucht import run
from wucht.studies.study_file import read_study

PAGE = PAGES["docs/load-spectra.md"]
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_record_of_the_standard(wucht, here):
    said = next(b.said for b in blocks(PAGE) if b.text == "wucht run specimen.toml -o results\n")
    write_files(PAGE)
    out = wucht("run", "specimen.toml", "-o", "results").out
    assert out.startswith(said)


def test_counting_alone():
    code, said = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", TEXT, re.DOTALL).groups()
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "docs/load-spectra.md", "exec"), {})
    assert printed.getvalue() == said


@pytest.mark.slow
def test_when_the_specimen_fails(wucht, here):
    said = re.search(r"## When the specimen fails.*?```text\n(.*?)```", TEXT, re.DOTALL).group(1)
    out = wucht("run", "drozdetskaya-2020/failure-of-the-specimen", "-o", "results").out
    assert out.startswith(said)
    assert "its work -0.83" in out


@pytest.mark.slow
def test_the_table_of_exciters():
    study = read_study("drozdetskaya-2020/where-the-failure-is-seen-best")
    result = run(study.spec, study.subject)
    rows = re.findall(r"(?m)^\| (0\.\d+) \| ([+-][\d.]+) \| ([\d.]+) \|$", TEXT)
    assert len(rows) == 6
    for slope, change, signal in rows:
        at = result.sel(along=float(slope), method="nearest")
        assert as_written(slope, float(at.along)) == slope
        assert (f"{float(at.change):+.1f}", as_written(signal, float(at.signal))) == (change, signal)
