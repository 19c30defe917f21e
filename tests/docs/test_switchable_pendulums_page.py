"""The page on switchable pendulums: the numbers of its tables and sentences are those of the files that it runs."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

import pytest
from page_blocks import PAGES, blocks

from wucht import run
from wucht.studies.study_file import read_study

PAGE = PAGES["docs/switchable-pendulums.md"]
TEXT = PAGE.read_text(encoding="utf-8")


@cache
def answer(name: str) -> dict[str, Any]:
    study = read_study(name)
    return dict(run(study.spec, study.subject).wucht.summary)


def row(first: str) -> list[str]:
    """The cells of the table's row that begins with this one, without it."""
    (line,) = re.findall(rf"(?m)^\| {re.escape(first)} \|(.*)\|$", TEXT)
    return [cell.strip() for cell in str(line).split("|")]


def in_mm(summary: dict[str, Any]) -> float:
    return float(1e3 * summary["peak_amplitude"])


def test_the_formulas_for_the_pendulum_that_the_page_has() -> None:
    (block,) = [b for b in blocks(PAGE) if b.language == "toml"]
    numbers = {key: float(value) for key, value in re.findall(r'(?m)^(\w+) = "?([\d.]+)', block.text)}
    ms, ri, ro = numbers["moving_mass"], numbers["inner_stop"], numbers["outer_stop"]
    on = math.sqrt(numbers["preload"] / (ms * ri))
    off = math.sqrt((numbers["preload"] + numbers["stiffness"] * (ro - ri)) / (ms * ro))
    after = on * (numbers["inertia"] + ms * ri**2) / (numbers["inertia"] + ms * ro**2)
    assert row("unbalance of an open pendulum")[-1].startswith(f"{ms * (ro - ri):.2g} kg m")
    assert row("opens above")[-1].startswith(f"{on:.3g} rad/s ({on * 30 / math.pi:.0f} rpm)")
    assert row("closes below")[-1].startswith(f"{off:.3g} rad/s ({off * 30 / math.pi:.0f} rpm)")
    assert row("turns on, once open, with")[-1] == f"{after:.3g} rad/s"


@pytest.mark.slow
def test_the_drum() -> None:
    said = answer("practice/laundry-drum-switchable")
    assert row("none")[0] == f"{in_mm(said['none']):.2f} mm"
    assert row("rigid")[0].startswith("6.6 to 15.0 mm")
    assert max(in_mm(s) for s in said["rigid"]) == pytest.approx(15.0, abs=0.05)
    assert row("switchable")[0] == f"{max(in_mm(s) for s in said['switchable']):.2f} mm, from any start"
    (blow,) = re.findall(r"a transient of at most ([\d.]+) mm", TEXT)
    assert max(1e3 * s["peak_after"] for s in said["switchable"]) == pytest.approx(float(blow), abs=0.05)
    assert said["pendulums"][0]["after_opening"][0] == pytest.approx(34.2, abs=0.05)


@pytest.mark.slow
def test_how_they_should_stand() -> None:
    said = answer("drozdetskaya-2020/figure-6.3")
    *angles, none, _ = row("angle between the pendulums")
    *peaks, without, rigid = row("mm")
    assert (none, rigid) == ("none", "14.2")
    assert [f"{math.degrees(s['orientation']):.0f}°" for s in said["switchable"]] == angles
    assert [f"{in_mm(s):.2f}" for s in said["switchable"]] == peaks
    assert f"{in_mm(said['none']):.2f}" == without
    assert in_mm(answer("drozdetskaya-2020/figure-6.2")["rigid"][0]) == pytest.approx(float(rigid), abs=0.05)


@pytest.mark.slow
def test_small_permanent_unbalances() -> None:
    said = answer("drozdetskaya-2020/figure-6.5")
    assert f"the largest amplitude is {in_mm(said['switchable'][0]):.2f} mm" in TEXT
    assert f"with {in_mm(said['balanced'][0]):.2f} mm from 20°" in TEXT
    assert f"from {1e3 * said['balanced'][0]['peak_before']:.2f} to {in_mm(said['switchable'][0]):.2f} mm" in TEXT
    opened = said["switchable"][0]["orientations_at_activation"][0]
    assert math.degrees(opened) == pytest.approx(180, abs=1)


@pytest.mark.slow
def test_when_they_should_open() -> None:
    said = answer("drozdetskaya-2020/switchable-activation-speeds")
    worst = {round(s["activation_speed"]): in_mm(s) for s in said["switchable"] if s["orientation"] < 0.2}
    (told,) = re.findall(r"(?s)nearly as bad as rigid ones: (.*?)\. Pendulums that stand opposite", TEXT)
    assert [float(n) for n in re.findall(r"([\d.]+) mm", told)] == [round(worst[s], 1) for s in (105, 150, 180)]
    assert f"against {max(in_mm(s) for s in said['rigid']):.1f}" in told
    opposite = [in_mm(s) for s in said["switchable"] if s["orientation"] > 3]
    assert max(opposite) == pytest.approx(4.7, abs=0.05)
