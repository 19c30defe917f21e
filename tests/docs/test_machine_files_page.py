"""Pages on machine files and load spectra: files run; the table of the material layer is that of one without rebound."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from docs.site.numbers import as_written
from page_blocks import PAGES, blocks, write_files
from scipy.optimize import brentq

from wucht import run
from wucht.studies.study_file import read_study

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "machine-files.md").read_text(encoding="utf-8")
FILES = [f for f in re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL) if "[machine.carrier]" in f]


@pytest.mark.slow
@pytest.mark.parametrize(("number", "outcome", "speed"), [(0, "passed", 151.844), (1, "passed", 59.969)])
def test_its_files_run(wucht, here, number, outcome, speed):
    (here / "machine.toml").write_text(FILES[number], encoding="utf-8")
    summary = json.loads(wucht("run", "machine.toml", "-o", "results", "--json").out)["summary"]
    assert summary["outcome"] == outcome
    assert summary["final_speed"] == pytest.approx(speed, rel=1e-3)


def first_harmonic(throw: float) -> tuple[float, float]:
    """Share of the mass and beta of the damper, in units a = omega = m = 1, g = 1/throw; throws of at most one period.

    The layer leaves the deck y = sin(p) where y'' = -g, flies and lands with the impulse u, and lies until it leaves again.
    """
    leave = math.asin(1 / throw)

    def above(p: float) -> float:
        t = p - leave
        return math.sin(leave) + math.cos(leave) * t - t**2 / (2 * throw) - math.sin(p)

    land = brentq(above, leave + 1e-2, leave + 2 * math.pi) if throw > 1 else leave
    u = math.cos(land) - math.cos(leave) + (land - leave) / throw
    p = np.linspace(land, leave + 2 * math.pi, 20001)
    lying = 1 / throw - np.sin(p)
    sine, cosine = np.trapezoid(lying * np.sin(p), p), np.trapezoid(lying * np.cos(p), p)
    return -(sine + u * math.sin(land)) / math.pi, (cosine + u * math.cos(land)) / math.pi


def test_the_table_of_the_material_layer():
    rows = re.findall(r"^\| (?:throw number.*?|share|beta) \| (.*) \|$", TEXT, re.MULTILINE)
    throws, shares, betas = (list(map(float, row.split(" | "))) for row in rows)
    assert len(throws) == 9
    expected = np.array([first_harmonic(t) for t in throws]).T
    assert np.array([shares, betas]) == pytest.approx(expected, abs=6e-4)


SPECTRA = PAGES["docs/load-spectra.md"]


def test_the_record_of_the_standard(wucht, here):
    said = next(b.said for b in blocks(SPECTRA) if b.text == "wucht run specimen.toml -o results --details\n")
    write_files(SPECTRA)
    out = wucht("run", "specimen.toml", "-o", "results", "--details").out
    assert out.startswith(said)


@pytest.mark.slow
def test_the_table_of_exciters():
    study = read_study("drozdetskaya-2020/where-the-failure-is-seen-best")
    result = run(study.spec, study.subject)
    rows = re.findall(r"(?m)^\| (0\.\d+) \| ([+-][\d.]+) \| ([\d.]+) \|$", SPECTRA.read_text(encoding="utf-8"))
    assert len(rows) == 6
    for slope, change, signal in rows:
        at = result.sel(along=float(slope), method="nearest")
        assert as_written(slope, float(at.along)) == slope
        assert (f"{float(at.change):+.1f}", as_written(signal, float(at.signal))) == (change, signal)
