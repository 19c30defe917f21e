"""The page from the nameplate to the file: its screen runs as the trade's formulas say, and its report marks estimates."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import pytest
from page_blocks import PAGES, blocks, write_files

from wucht import run_file
from wucht.machines.parts import Roller
from wucht.reports.html_report import write_report

PAGE = PAGES["docs/from-nameplate-to-file.md"]


def test_its_screen_has_the_stroke_of_its_working_moments(here: Path) -> None:
    """2 (2 m r)/M far above the natural frequencies: with those, 0.7 % more; 1488 rpm, as two motors of 1450 rpm rated."""
    write_files(PAGE)
    result = run_file("screen.toml", folder="screen")
    summary = result.wucht.summary
    by_hand = 2 * 9.0 / 2060
    assert f"{1e3 * by_hand:.2f} mm" in PAGE.read_text(encoding="utf-8")
    assert summary["outcome"] == "synchronised"
    assert summary["stroke"] == pytest.approx(8.80e-3, rel=1e-3)
    assert by_hand < summary["stroke"] < 1.01 * by_hand
    assert summary["machine_number"] == pytest.approx(by_hand / 2 * (1488 * math.pi / 30) ** 2 / 9.80665, rel=1e-2)
    assert not any("far from practice" in note for note in result.wucht.notes)
    report = write_report(["screen"], "screen.html")
    assert "starting torque ratio 2.7 (estimate, 2.1 to 3.4)" in report.read_text(encoding="utf-8")


def test_its_balls_have_the_damping_that_it_states() -> None:
    (table,) = (tomllib.loads(b.text)["machine"]["bodies"][0] for b in blocks(PAGE) if "oil =" in b.text)
    ball = Roller(**{key: value for key, value in table.items() if key != "kind"})
    assert f"{ball.damping:.4f} N m s" in PAGE.read_text(encoding="utf-8")
