"""The page on machine files: its files run, and the table of the material layer is that of a layer that does not rebound."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

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


@pytest.mark.slow
def test_what_the_page_on_the_fan_prints(wucht, here):
    page = (DOCS / "practice" / "fan.md").read_text(encoding="utf-8")
    said = re.search(r"```text\n(.*?)```", page, re.DOTALL).group(1)
    asked = ["--set", "drive.torque_limit=3.4", "--set", "study.kind=torque-balance"]
    assert said.removesuffix("...\n") in wucht("run", "practice/fan-on-inverter", *asked, "-o", "results").out


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
